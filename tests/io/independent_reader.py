# SPDX-License-Identifier: Apache-2.0
# Independent reader of volumes: NIfTI, Analyze, NRRD, MetaImage and GIPL by their specifications, MINC by nibabel,
# DICOM by pydicom. For each file or DICOM folder it prints "file PATH COLUMNS ROWS SLICES POINTS", then the LPS position (mm)
# and the value of the eight corner voxels and of 100 others. Unreadable files are skipped.
import gzip
import io
import os
import random
import struct
import sys
import zlib

NUMBERS = {'b': 1, 'B': 1, 'h': 2, 'H': 2, 'i': 4, 'I': 4, 'q': 8, 'Q': 8, 'f': 4, 'd': 8}


def read(path):
    data = open(path, 'rb').read()
    return gzip.decompress(data) if data[:2] == b'\x1f\x8b' else data


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def unit_axes(numbers):
    """Direction cosines, normalised because files store few digits."""
    axes = [float(x) for x in numbers]
    lengths = [sum(x * x for x in axes[a:a + 3]) ** 0.5 for a in (0, 3)]
    return [x / lengths[a // 3] for a, x in enumerate(axes)]


class Grid:
    """Volume grid. columns[a]: step between voxels along axis a, LPS, mm; value(i, j, k): voxel value."""

    def __init__(self, size, columns, origin, value):
        self.size, self.columns, self.origin, self.value = list(size), columns, origin, value

    def position(self, index):
        return [self.origin[r] + sum(self.columns[a][r] * index[a] for a in range(3)) for r in range(3)]


def array_of(code, order, data, start, size):
    bytes_each = NUMBERS[code]

    def value(i, j, k):
        at = start + bytes_each * ((k * size[1] + j) * size[0] + i)
        return struct.unpack_from(order + code, data, at)[0]
    return value


def nifti(path):
    data = read(path)
    order = '<' if struct.unpack_from('<i', data)[0] in (348, 540) else '>'
    get = lambda fmt, at: struct.unpack_from(order + fmt, data, at)
    if get('i', 0)[0] == 540:
        kind, dim, pixdim = get('h', 12)[0], get('8q', 16), get('8d', 104)
        start, slope, inter = get('q', 168)[0], *get('2d', 176)
        qcode, scode = get('2i', 344)
        quaternion, offset, rows = get('3d', 352), get('3d', 376), get('12d', 400)
        units = get('i', 500)[0]
    else:
        kind, dim, pixdim = get('h', 70)[0], get('8h', 40), get('8f', 76)
        start, slope, inter = (int(get('f', 108)[0]), *get('2f', 112))
        qcode, scode = get('2h', 252)
        quaternion, offset, rows = get('3f', 256), get('3f', 268), get('12f', 280)
        units = data[123]
    size = [dim[a] if a <= dim[0] else 1 for a in (1, 2, 3)]
    if scode > 0:
        columns = [[rows[4 * r + a] for r in range(3)] for a in range(3)]
        origin = [rows[4 * r + 3] for r in range(3)]
    elif qcode > 0:
        b, c, d = quaternion
        a = max(0.0, 1 - b * b - c * c - d * d) ** 0.5
        rotation = [[a * a + b * b - c * c - d * d, 2 * (b * c - a * d), 2 * (b * d + a * c)],
                    [2 * (b * c + a * d), a * a + c * c - b * b - d * d, 2 * (c * d - a * b)],
                    [2 * (b * d - a * c), 2 * (c * d + a * b), a * a + d * d - b * b - c * c]]
        sign = [1, 1, -1 if pixdim[0] < 0 else 1]
        columns = [[rotation[r][x] * pixdim[x + 1] * sign[x] for r in range(3)] for x in range(3)]
        origin = list(offset)
    else:
        return None
    mm = {1: 1000.0, 3: 1e-3}.get(units & 7, 1.0)
    lps = [-mm, -mm, mm]
    columns = [[c[r] * lps[r] for r in range(3)] for c in columns]
    code = {2: 'B', 4: 'h', 8: 'i', 16: 'f', 64: 'd', 256: 'b', 512: 'H', 768: 'I', 1024: 'q', 1280: 'Q'}[kind]
    stored = array_of(code, order, data, start, size)
    scaled = slope not in (0, 1) or (slope == 1 and inter != 0)
    value = (lambda i, j, k: stored(i, j, k) * slope + inter) if scaled else stored
    return Grid(size, columns, [origin[r] * lps[r] for r in range(3)], value)


def analyze(path):
    """Analyze 7.5, which has voxel sizes but no orientation: the axes are assumed to be LPS."""
    data = read(path)
    order = '<' if struct.unpack_from('<i', data)[0] == 348 else '>'
    dim, kind = struct.unpack_from(order + '4h', data, 40), struct.unpack_from(order + 'h', data, 70)[0]
    pixdim = struct.unpack_from(order + '4f', data, 76)
    columns = [[pixdim[a + 1] if r == a else 0 for r in range(3)] for a in range(3)]
    voxels = open(path[:-4] + '.img', 'rb').read()
    return Grid(dim[1:], columns, [0, 0, 0], array_of({4: 'h'}[kind], order, voxels, 0, dim[1:]))


def gipl(path):
    data = read(path)
    size = struct.unpack_from('>3H', data)
    spacing, origin = struct.unpack_from('>3f', data, 10), struct.unpack_from('>3d', data, 204)
    columns = [[spacing[a] if r == a else 0 for r in range(3)] for a in range(3)]
    return Grid(size, columns, origin, array_of({15: 'h'}[struct.unpack_from('>H', data, 8)[0]], '>', data, 256, size))


def minc(path):
    import nibabel
    image = nibabel.load(path)
    values, affine, lps = image.get_fdata(), image.affine, [-1, -1, 1]
    if values.ndim == 4:  # the first of several in time
        values = values[0]
    columns = [[affine[r][2 - a] * lps[r] for r in range(3)] for a in range(3)]  # its first axis is the slowest
    return Grid(values.shape[::-1], columns, [affine[r][3] * lps[r] for r in range(3)],
                lambda i, j, k: float(values[k, j, i]))


def nrrd(path):
    data = open(path, 'rb').read()
    end = data.find(b'\n\n') + 2
    end = end if end > 1 else len(data)
    fields = dict(line.split(': ', 1) for line in data[:end].decode().split('\n') if ': ' in line and line[0] != '#')
    vector = lambda text: [float(x) for x in text.strip('()').split(',')]
    size = [int(x) for x in fields['sizes'].split()]
    known = [{'left': 1, 'right': -1}, {'posterior': 1, 'anterior': -1}, {'superior': 1, 'inferior': -1}]
    sign = [words[word] for words, word in zip(known, fields['space'].split('-'))]
    columns = [[v * s for v, s in zip(vector(t), sign)] for t in fields['space directions'].split()]
    origin = [v * s for v, s in zip(vector(fields['space origin']), sign)]
    code = {'signed char': 'b', 'unsigned char': 'B', 'uchar': 'B', 'short': 'h', 'unsigned short': 'H', 'int': 'i',
            'unsigned int': 'I', 'float': 'f', 'double': 'd'}[fields['type']]
    voxels = data[end:]
    if 'data file' in fields:
        voxels = open(os.path.join(os.path.dirname(path), fields['data file']), 'rb').read()
    if fields['encoding'] == 'gzip':
        voxels = gzip.decompress(voxels)
    if fields['encoding'] == 'ascii':
        numbers = voxels.split()
        voxels = struct.pack('<%d%s' % (len(numbers), code), *(int(x) for x in numbers))
    return Grid(size, columns, origin, array_of(code, '>' if fields.get('endian') == 'big' else '<', voxels, 0, size))


def meta(path):
    data = open(path, 'rb').read()
    end = data.index(b'\n', data.index(b'ElementDataFile')) + 1
    fields = dict(line.split(' = ', 1) for line in data[:end].decode().split('\n') if ' = ' in line)
    numbers = lambda key: [float(x) for x in fields[key].split()]
    size, spacing, matrix = [int(x) for x in fields['DimSize'].split()], numbers('ElementSpacing'), numbers('TransformMatrix')
    columns = [[matrix[3 * a + r] * spacing[a] for r in range(3)] for a in range(3)]
    code = {'MET_CHAR': 'b', 'MET_UCHAR': 'B', 'MET_SHORT': 'h', 'MET_USHORT': 'H', 'MET_INT': 'i', 'MET_UINT': 'I',
            'MET_FLOAT': 'f', 'MET_DOUBLE': 'd'}[fields['ElementType']]
    voxels = data[end:]
    if fields['ElementDataFile'] != 'LOCAL':
        voxels = open(os.path.join(os.path.dirname(path), fields['ElementDataFile']), 'rb').read()
    if fields.get('CompressedData') == 'True':
        voxels = zlib.decompress(voxels)
    return Grid(size, columns, numbers('Offset'), array_of(code, '<', voxels, 0, size))


# Transfer syntaxes with exact decoding in pydicom: JPEG 2000 and run lengths. Decoders of the others can differ.
EXACT = ('1.2.840.10008.1.2.4.90', '1.2.840.10008.1.2.4.91', '1.2.840.10008.1.2.5')


def dataset(path):
    import pydicom
    return pydicom.dcmread(io.BytesIO(read(path)))


def can_be_read(data):
    syntax = data.file_meta.TransferSyntaxUID
    return (not syntax.is_compressed or syntax in EXACT) and data.SamplesPerPixel == 1


def dicom(slices):
    """Slices of one file each. Defaults are position 0, LPS axes and a pixel size of 1 mm."""
    if any(not can_be_read(s) or s.get('NumberOfFrames', 1) > 1 for s in slices):
        return None
    at = lambda s: [float(x) for x in s.get('ImagePositionPatient', [0, 0, 0])]
    first = slices[0]
    axes = unit_axes(first.get('ImageOrientationPatient', [1, 0, 0, 0, 1, 0]))
    normal = cross(axes[:3], axes[3:])
    slices.sort(key=lambda s: sum(p * n for p, n in zip(at(s), normal)))
    first, last = slices[0], slices[-1]
    between = [(b - a) / max(1, len(slices) - 1) for a, b in zip(at(first), at(last))]
    down, across = (float(x) for x in first.get('PixelSpacing', first.get('ImagerPixelSpacing', [1, 1])))
    columns = [[x * across for x in axes[:3]], [x * down for x in axes[3:]], between]

    def value(i, j, k):
        s = slices[k]
        return int(s.pixel_array[j, i]) * float(s.get('RescaleSlope', 1)) + float(s.get('RescaleIntercept', 0))
    return Grid([first.Columns, first.Rows, len(slices)], columns, at(first), value)


def dose(data):
    """RT dose: frames at offsets that start at 0 or at the coordinate of the position."""
    if not can_be_read(data):
        return None
    axes = unit_axes(data.ImageOrientationPatient)
    normal = cross(axes[:3], axes[3:])
    frames = data.get('NumberOfFrames', 1)
    offsets = [float(x) for x in data.GridFrameOffsetVector] if frames > 1 else [0]
    step = (offsets[-1] - offsets[0]) / max(1, frames - 1)
    down, across = (float(x) for x in data.PixelSpacing)
    columns = [[x * across for x in axes[:3]], [x * down for x in axes[3:]], [x * step for x in normal]]
    pixels = data.pixel_array.reshape(frames, data.Rows, data.Columns)
    return Grid([data.Columns, data.Rows, frames], columns, [float(x) for x in data.ImagePositionPatient],
                lambda i, j, k: int(pixels[k, j, i]) * float(data.DoseGridScaling))


def nuclear(data):
    """Slices of nuclear medicine (PS3.3 C.8.4.15): the sign of their distance is the direction of stacking."""
    detector = data.DetectorInformationSequence[0]
    axes = unit_axes(detector.ImageOrientationPatient)
    down, across = (float(x) for x in data.PixelSpacing)
    step = [x * float(data.SpacingBetweenSlices) for x in cross(axes[:3], axes[3:])]
    columns = [[x * across for x in axes[:3]], [x * down for x in axes[3:]], step]
    frame_of = {int(number): frame for frame, number in enumerate(data.SliceVector)}
    size = [data.Columns, data.Rows, len(frame_of)]
    stored = array_of('H', '<', data.PixelData, 0, size)
    return Grid(size, columns, [float(x) for x in detector.ImagePositionPatient],
                lambda i, j, k: stored(i, j, frame_of[k + 1]))


def enhanced(data):
    """Multi-frame file of one volume: frames in any order, each with position and rescaling."""
    shared, each = data.SharedFunctionalGroupsSequence[0], data.PerFrameFunctionalGroupsSequence
    group = lambda frame, name: (frame if name in frame else shared)[name][0]
    axes = unit_axes(group(each[0], 'PlaneOrientationSequence').ImageOrientationPatient)
    down, across = (float(x) for x in group(each[0], 'PixelMeasuresSequence').PixelSpacing)
    normal = cross(axes[:3], axes[3:])
    frames = []
    for number, frame in enumerate(each):
        at = [float(x) for x in group(frame, 'PlanePositionSequence').ImagePositionPatient]
        rescale = group(frame, 'PixelValueTransformationSequence')
        frames.append((sum(p * n for p, n in zip(at, normal)), number, at, float(rescale.RescaleSlope),
                       float(rescale.RescaleIntercept)))
    frames.sort()
    between = [(b - a) / max(1, len(frames) - 1) for a, b in zip(frames[0][2], frames[-1][2])]
    columns = [[x * across for x in axes[:3]], [x * down for x in axes[3:]], between]
    size = [data.Columns, data.Rows, len(frames)]
    stored = array_of('H', '<', data.PixelData, 0, size)
    return Grid(size, columns, frames[0][2],
                lambda i, j, k: stored(i, j, frames[k][1]) * frames[k][3] + frames[k][4])


def grid_of(path):
    if os.path.isdir(path):
        return dicom([dataset(os.path.join(path, name)) for name in sorted(os.listdir(path))])
    if path.endswith(('.nrrd', '.nhdr')):
        return nrrd(path)
    if path.endswith(('.mha', '.mhd')):
        return meta(path)
    if path.endswith(('.gipl', '.gipl.gz')):
        return gipl(path)
    if path.endswith('.mnc'):
        return minc(path)
    if path.endswith('.hdr'):
        return analyze(path)
    if path.endswith(('.nii', '.nii.gz')):
        return nifti(path)
    data = dataset(path)
    if 'PerFrameFunctionalGroupsSequence' in data:
        return enhanced(data)
    if 'SliceVector' in data:
        return nuclear(data)
    return dose(data) if data.get('Modality') == 'RTDOSE' else dicom([data])


for path in sys.stdin.read().split('\n'):
    if not path:
        continue
    try:
        grid = grid_of(path)
    except Exception as exception:
        sys.stderr.write('independent_reader: %s: %r\n' % (path, exception))
        grid = None
    if grid is None:
        continue
    n = grid.size
    chosen = [(x * (n[0] - 1), y * (n[1] - 1), z * (n[2] - 1)) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    source = random.Random(1)
    chosen += [tuple(source.randrange(s) for s in n) for _ in range(100)]
    print('file %s' % path)
    print(n[0], n[1], n[2], len(chosen))
    for index in chosen:
        print('%.9g %.9g %.9g %.9g' % (*grid.position(index), grid.value(*index)))
