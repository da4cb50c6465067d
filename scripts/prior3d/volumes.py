# SPDX-License-Identifier: Apache-2.0
"""Labelled volumes: files, the objects of scripts/click_cases, and the objects of which networks learn."""
import gzip
import os
import pathlib
import struct
import subprocess

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
TEMPLATES = pathlib.Path("/usr/share/mricron/templates")
TYPES = {2: "u1", 4: "i2", 8: "i4", 16: "f4", 64: "f8", 256: "i1", 512: "u2", 768: "u4"}


def data_folder():
    folder = os.environ.get("SIMPLEXSEG_DATA", "")
    if not folder:
        raise SystemExit("real volumes are needed, and SIMPLEXSEG_DATA does not name their folder; set it")
    return pathlib.Path(folder)


def read_nifti(file):
    """Voxels [i, j, k] and their spacing in mm of a NIfTI-1 file; of several volumes the first."""
    content = gzip.decompress(pathlib.Path(file).read_bytes())
    order = "<" if struct.unpack("<i", content[:4])[0] == 348 else ">"
    size = struct.unpack(order + "8h", content[40:56])
    kind, = struct.unpack(order + "h", content[70:72])
    spacing = struct.unpack(order + "8f", content[76:108])[1:4]
    offset, slope, intercept = struct.unpack(order + "3f", content[108:120])
    shape = size[1:4]
    voxels = np.frombuffer(content, order + TYPES[kind], int(np.prod(shape)), int(offset)).reshape(shape, order="F")
    if slope not in (0.0, 1.0) or (slope == 1.0 and intercept != 0):
        voxels = voxels.astype(np.float32) * slope + intercept
    return voxels.astype(voxels.dtype.newbyteorder("=")), np.abs(np.array(spacing, float))


def write_nifti(file, voxels, spacing):
    """Writes a float32 NIfTI-1 file, compressed if its name ends in .gz; RAS axes along i, j, k, first voxel at the origin."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *voxels.shape, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 16, 32)
    struct.pack_into("<8f", header, 76, 1, *spacing, 0, 0, 0, 0)
    struct.pack_into("<3f", header, 108, 352, 1, 0)
    header[123] = 2  # mm
    struct.pack_into("<2h", header, 252, 0, 1)
    for axis in range(3):
        struct.pack_into("<4f", header, 280 + 16 * axis, *(spacing[axis] if a == axis else 0 for a in range(3)), 0)
    header[344:348] = b"n+1\0"
    content = bytes(header) + voxels.astype("<f4").tobytes(order="F")
    pathlib.Path(file).write_bytes(gzip.compress(content, 1) if str(file).endswith(".gz") else content)


def evaluation_cases():
    """Objects of the robot's 17 groups (scripts/click_cases): (group, image file, label file, label or None for all)."""
    data_folder()
    command = f"source '{ROOT}/scripts/click_cases'; cases"
    text = subprocess.run(["bash", "-c", command], check=True, capture_output=True, text=True).stdout
    found = []
    for line in text.splitlines():
        group, _, image, labels, *objects = line.split()
        found += [(group, image, labels, int(label)) for label in objects] or [(group, image, labels, None)]
    return found


def further_cases():
    """Objects of other volumes for the training of a fusion, as evaluation_cases(). Groups that are not of the 17 come last."""
    more = data_folder() / "more"
    table = [("abdomen", f"mr_abdomen_chaos{n}", (1, 2, 3, 4)) for n in (8, 20, 31)]
    table += [("heart", "mr_heart_cmr20", (1, 2, 3)), ("lungs", "ct_lung_imlab1", (1,)), ("sarcoma", "pet_sarcoma_003", (1,)),
              ("glioma", "mr_flair_tumour_0001", (1,)), ("thalamus", "mr_brain_oasis1000", (5, 6)), ("putamen", "mr_brain_oasis1000", (7, 8)),
              ("caudate", "mr_brain_oasis1000", (9, 10)), ("hippocampi", "mr_brain_oasis1000", (11, 12)), ("ventricles", "mr_brain_oasis1000", (1, 2, 3, 4)),
              ("rims", "mr_t1c_enhancing_0001", (1,)), ("rims", "mr_t1c_enhancing_0002", (1,)),
              ("atria", "mr_leftatrium_06SR", (1,)), ("atria", "mr_leftatrium_3DA0", (1,))]
    return [(group, str(more / f"{name}.nii.gz"), str(more / f"{name}_labels.nii.gz"), label) for group, name, labels in table for label in labels]


# Kinds of groups. A fold leaves out whole kinds.
KIND_OF_GROUP = {
    **dict.fromkeys(["kidneys", "bladder", "gallbladder", "abdomen", "spleen"], "abdominal"), "nuclei": "nuclei",
    **dict.fromkeys(["caudate", "putamen", "thalamus", "hippocampi", "brain", "glioma", "ventricles", "rims"], "brain"), "vertebrae": "bone", "skull": "skull",
    "heart": "heart", "atria": "heart", "lungs": "lungs", "sarcoma": "sarcoma"}
FOLDS = {"1": ["abdominal", "nuclei"], "2": ["brain"], "3": ["bone", "skull", "heart", "lungs", "sarcoma"], "all": []}


def fold_without(kind):
    """Name of the fold whose network has seen no object of a kind."""
    return next((name for name, kinds in FOLDS.items() if kind in kinds), "all")


def training_objects():
    """Objects of which networks learn: (kind, class of equal weight, image file, label file, label or None)."""
    data, more = data_folder(), data_folder() / "more"
    ct = (data / "ct_abdomen/ct.nii.gz", data / "ct_abdomen/labels.nii.gz")
    head = (TEMPLATES / "ch2.nii.gz", TEMPLATES / "aal.nii.gz")

    def pair(name):
        return more / f"{name}.nii.gz", more / f"{name}_labels.nii.gz"

    found = []

    def add(kind, group, files, labels):
        found.extend((kind, group, str(files[0]), str(files[1]), label) for label in labels)

    add("abdominal", "organs of CT", ct, (1, 2, 3, 4, 5, 6, 14, 21, 7, 10, 11, 12, 13))
    add("bone", "vertebrae", ct, range(26, 33))
    add("bone", "bones of CT", ct, (25, 75, 76, 77, 78))
    add("muscle", "muscles of CT", ct, range(80, 90))
    add("vessel", "vessels of CT", ct, (52, 63, 65, 66, 79))
    add("brain", "deep nuclei", head, (71, 72, 73, 74, 75, 76, 77, 78, 37, 38, 41, 42))
    add("brain", "cortex", head, (5, 15, 29, 31, 39, 43, 50, 55, 63, 79, 81, 85, 91, 96, 101))
    add("brain", "brain", (TEMPLATES / "ch2.nii.gz", TEMPLATES / "ch2bet.nii.gz"), (None,))
    for image in sorted((data / "hippocampus/images").glob("*.nii.gz")):
        add("brain", "hippocampi", (image, data / "hippocampus/labels" / image.name), (None,))
    add("brain", "structures of OASIS", pair("mr_brain_oasis1000"), range(1, 13))
    for name in ("mr_flair_tumour_0001", "mr_flair_tumour_0002"):
        add("brain", "glioma", pair(name), (1,))
    for name in ("mr_t1c_enhancing_0001", "mr_t1c_enhancing_0002"):
        add("brain", "enhancing rims", pair(name), (1,))
    for name in ("mr_abdomen_chaos1", "mr_abdomen_chaos8", "mr_abdomen_chaos20", "mr_abdomen_chaos31"):
        add("abdominal", "organs of MR", pair(name), (1, 2, 3, 4))
    add("abdominal", "spleen", pair("ct_spleen_msd8"), (1,))
    for name in ("mr_heart_cmr1", "mr_heart_cmr12", "mr_heart_cmr20"):
        add("heart", "heart", pair(name), (1, 2, 3))
    for name in ("mr_leftatrium_06SR", "mr_leftatrium_3DA0"):
        add("heart", "atria", pair(name), (1,))
    add("lungs", "lungs of MR", pair("mr_lung_0004"), (1, 2))
    add("lungs", "lungs of CT", pair("ct_lung_imlab1"), (1,))
    for name in ("mr_sarcoma_002", "mr_sarcoma_003", "pet_sarcoma_003"):
        add("sarcoma", "sarcoma", pair(name), (1,))
    add("nuclei", "nuclei", pair("ovulenuclei_1135"), range(1, 12))
    add("skull", "skull of a mouse", pair("microct_mouseskull"), (1, 2, 3, 15, 21))
    return found


GROUPS_OF_CLASSES = {"vertebrae": "vertebrae", "brain": "brain", "hippocampi": "hippocampi", "glioma": "glioma", "organs of MR": "abdomen",
                     "spleen": "spleen", "heart": "heart", "atria": "heart", "lungs of MR": "lungs", "lungs of CT": "lungs", "sarcoma": "sarcoma",
                     "nuclei": "nuclei", "skull of a mouse": "skull"}
GROUPS_OF_LABELS = {("organs of CT", 2): "kidneys", ("organs of CT", 3): "kidneys", ("organs of CT", 1): "spleen", ("organs of CT", 4): "gallbladder",
                    ("organs of CT", 21): "bladder", ("organs of CT", 5): "abdomen",
                    **{("deep nuclei", label): group for group, labels in {"caudate": (71, 72), "putamen": (73, 74), "thalamus": (77, 78),
                                                                           "hippocampi": (37, 38)}.items() for label in labels},
                    **{("structures of OASIS", label): group for group, labels in {"thalamus": (5, 6), "putamen": (7, 8), "caudate": (9, 10),
                                                                                   "hippocampi": (11, 12)}.items() for label in labels}}


def group_of(name, label):
    """Group of the 17 whose field networks have not seen an object of training_objects(); none: of no group."""
    return GROUPS_OF_LABELS.get((name, label), GROUPS_OF_CLASSES.get(name, "none"))


def mask_of(labels, label):
    return labels != 0 if label is None else labels == label
