# SPDX-License-Identifier: Apache-2.0
# Independent check that labels lie on their image in every program. Input: lines "IMAGE<tab>LABELS". For each pair and
# each rule by which programs place voxels it prints "RULE DISTANCE LABELS", the largest distance of a corner of the two
# grids in mm: 0 also if the rule refuses both, inf if it refuses one. NIfTI rules: nibabel, sform first (SPM, FSL), qform
# first (dcm2niix), ITK 5 (sform only if orthogonal, and of code 1, equal to the qform or alone) and ITK 4 (qform first).
# NRRD and MetaImage: the fields themselves.
import gzip
import itertools
import struct
import sys

import nibabel
import numpy


def contents(path):
    data = open(path, 'rb').read()
    return gzip.decompress(data) if data[:2] == b'\x1f\x8b' else data


class Nifti:
    def __init__(self, path):
        data = contents(path)
        order = '<' if struct.unpack_from('<i', data)[0] in (348, 540) else '>'
        get = lambda form, at: struct.unpack_from(order + form, data, at)
        if get('i', 0)[0] == 540:
            self.dim, self.pixdim, (self.qcode, self.scode) = get('8q', 16), get('8d', 104), get('2i', 344)
            quaternion, offset, rows, self.units = get('3d', 352), get('3d', 376), get('12d', 400), get('i', 500)[0]
        else:
            self.dim, self.pixdim, (self.qcode, self.scode) = get('8h', 40), get('8f', 76), get('2h', 252)
            quaternion, offset, rows, self.units = get('3f', 256), get('3f', 268), get('12f', 280), data[123]
        self.size = [self.dim[a] if a <= self.dim[0] else 1 for a in (1, 2, 3)]
        self.scale = {1: 1000.0, 3: 0.001}.get(self.units & 7, 1.0)
        self.sform = numpy.vstack([numpy.reshape(rows, (3, 4)), [0, 0, 0, 1]])
        b, c, d = quaternion
        a = max(0.0, 1 - b * b - c * c - d * d) ** 0.5
        rotation = numpy.array([[a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
                                [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)],
                                [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c]])
        zooms = [abs(x) for x in self.pixdim[1:4]]
        if self.pixdim[0] < 0:
            zooms[2] *= -1
        self.qform = numpy.eye(4)
        self.qform[:3, :3] = rotation * zooms
        self.qform[:3, 3] = offset
        self.plain = numpy.diag([*self.pixdim[1:4], 1.0])


def sform_first(f):
    return f.sform if f.scode > 0 else f.qform if f.qcode > 0 else f.plain


def qform_first(f):
    return f.qform if f.qcode > 0 else f.sform if f.scode > 0 else f.plain


def orthogonal(matrix):
    columns = matrix[:3, :3] / numpy.linalg.norm(matrix[:3, :3], axis=0)
    return numpy.abs(columns.T @ columns - numpy.eye(3)).max() < 1e-4


def with_spacing_of_header(f, matrix):
    """ITK normalises the columns and takes the spacing from pixdim."""
    result = matrix.copy()
    result[:3, :3] = matrix[:3, :3] / numpy.linalg.norm(matrix[:3, :3], axis=0) * f.pixdim[1:4]
    return result


def itk_5(f):
    if f.qcode <= 0 and f.scode <= 0:
        return f.plain
    if f.scode > 0 and orthogonal(f.sform):
        if f.qcode <= 0 or f.scode == 1 or numpy.abs(f.sform - f.qform).max() < 1e-4:
            return with_spacing_of_header(f, f.sform)
    return with_spacing_of_header(f, f.qform) if f.qcode > 0 else None


def itk_4(f):
    return with_spacing_of_header(f, qform_first(f)) if f.qcode > 0 or f.scode > 0 else f.plain


def nifti_matrices(path):
    f = Nifti(path)
    matrices = {'sform-first': sform_first(f), 'qform-first': qform_first(f), 'itk-5': itk_5(f), 'itk-4': itk_4(f)}
    unit = numpy.diag([f.scale, f.scale, f.scale, 1.0])
    matrices = {rule: None if matrix is None else unit @ matrix for rule, matrix in matrices.items()}
    matrices['nibabel'] = nibabel.load(path).affine
    matrices['codes'] = numpy.diag([f.qcode, f.scode, f.units & 7, 1.0])
    return f.size, matrices


def nrrd_matrices(path):
    header = contents(path).split(b'\n\n')[0].decode()
    fields = dict(line.split(': ', 1) for line in header.split('\n') if ': ' in line and line[0] != '#')
    vector = lambda text: [float(x) for x in text.strip('()').split(',')][:3]
    sizes, matrix = fields['sizes'].split(), numpy.eye(4)
    spatial = [a for a, text in enumerate(fields.get('space directions', '- - -').split()) if text != 'none'][:3]
    words = lambda key, other: [fields[key].split()[a] for a in spatial] if key in fields else [other] * 3
    if 'space directions' in fields:
        matrix[:3, :3] = numpy.array([vector(fields['space directions'].split()[a]) for a in spatial]).T
    else:
        matrix[:3, :3] = numpy.diag([float(x) for x in words('spacings', '1')])
        matrix[:3, 3] = [float(x) for x in words('axis mins', '0')]
    if 'space origin' in fields:
        matrix[:3, 3] = vector(fields['space origin'])
    name = fields.get('space', '').lower()
    rule = 'nrrd %s %s %s' % (name[:-5] if name.endswith('-time') else name, words('centers', ''), words('units', ''))
    rule += ' '.join(fields.get('space units', '').replace('"', '').split()[:3])
    return [int(sizes[a]) for a in spatial], {rule.replace(' ', '_'): matrix}


def meta_matrices(path):
    data = contents(path)
    header = data[:data.index(b'\n', data.index(b'ElementDataFile'))].decode()
    fields = dict(line.split(' = ', 1) for line in header.split('\n') if ' = ' in line)
    numbers = lambda key, other: [float(x) for x in fields.get(key, other).split()]
    matrix, axes = numpy.eye(4), int(fields['NDims'])
    identity = ' '.join(str(int(x)) for x in numpy.eye(axes).ravel())
    directions = numpy.reshape(numbers('TransformMatrix', identity), (axes, axes))[:3, :3].T
    matrix[:3, :3] = directions * numbers('ElementSpacing', '1 1 1 1')[:3]
    matrix[:3, 3] = numbers('Offset', '0 0 0 0')[:3]
    code = fields.get('AnatomicalOrientation', '')[:3]
    return [int(x) for x in fields['DimSize'].split()][:3], {'meta_' + code: matrix}


def matrices_of(path):
    if path.endswith('.nrrd'):
        return nrrd_matrices(path)
    return meta_matrices(path) if path.endswith('.mha') else nifti_matrices(path)


def distance(size, a, b):
    if a is None or b is None:
        return 0.0 if a is None and b is None else float('inf')
    corners = [[x * (size[0] - 1), y * (size[1] - 1), z * (size[2] - 1), 1]
               for x, y, z in itertools.product((0, 1), repeat=3)]
    return max(numpy.linalg.norm((a - b) @ corner) for corner in corners)


for pair in sys.stdin.read().split('\n'):
    if not pair:
        continue
    image, labels = pair.split('\t')
    size, of_image = matrices_of(image)
    size_of_labels, of_labels = matrices_of(labels)
    for rule in sorted(set(of_image) | set(of_labels)):
        known = rule in of_image and rule in of_labels and size == size_of_labels
        print(rule, '%.9g' % (distance(size, of_image[rule], of_labels[rule]) if known else float('inf')), labels)
