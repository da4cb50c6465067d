# SPDX-License-Identifier: Apache-2.0
import os

import numpy as np
import pytest

import simplexseg
from simplexseg import DataWarning, Error


@pytest.mark.parametrize("name", ["v.nii", "v.nii.gz", "v.nrrd", "v.mha"])
def test_a_written_volume_is_read_again(tmp_path, ramp, name):
    simplexseg.write_volume(tmp_path / name, ramp)
    volume = simplexseg.read_volume(tmp_path / name)
    np.testing.assert_array_equal(volume.array, ramp.array)
    assert volume.same_grid(ramp)
    assert volume.dtype == ramp.dtype
    assert volume.path == tmp_path / name
    info = simplexseg.read_info(str(tmp_path / name))
    assert info["shape"] == ramp.shape
    assert info["dtype"] == ramp.dtype
    np.testing.assert_allclose(info["origin"], ramp.origin, atol=1e-5)


def test_nibabel_has_the_same_voxels_and_affine(tmp_path, ramp):
    nibabel = pytest.importorskip("nibabel", reason="the Debian package python3-nibabel is missing")
    simplexseg.write_volume(tmp_path / "ours.nii.gz", ramp)
    theirs = nibabel.load(tmp_path / "ours.nii.gz")
    np.testing.assert_array_equal(np.asarray(theirs.dataobj), ramp.array)
    np.testing.assert_allclose(theirs.affine, ramp.affine_ras, atol=1e-5)
    nibabel.save(nibabel.Nifti1Image(np.asarray(theirs.dataobj), theirs.affine), tmp_path / "theirs.nii")
    back = simplexseg.read_volume(tmp_path / "theirs.nii")
    np.testing.assert_array_equal(back.array, ramp.array)
    assert back.same_grid(ramp)
    given = simplexseg.Volume(np.asarray(theirs.dataobj), affine_ras=theirs.affine)
    np.testing.assert_allclose(given.affine_ras, theirs.affine, atol=1e-12)
    assert given.same_grid(ramp)
    nibabel.save(nibabel.Nifti1Image(given.array, given.affine_ras), tmp_path / "again.nii")
    assert simplexseg.read_volume(tmp_path / "again.nii").same_grid(ramp)
    assert simplexseg.Volume(theirs.get_fdata(dtype="float32"), affine_ras=theirs.affine).dtype == np.float32


def test_labels_repeat_the_header_of_their_image(tmp_path, ramp):
    simplexseg.write_volume(tmp_path / "image.nii", ramp)
    header = bytearray((tmp_path / "image.nii").read_bytes())
    header[252:256] = b"\2\0\4\0"  # codes of qform and sform
    header[123] = 0  # unknown unit
    (tmp_path / "image.nii").write_bytes(header)
    image = simplexseg.read_volume(tmp_path / "image.nii")
    labels = simplexseg.Volume(np.ones(image.shape, np.uint8), like=image)
    assert labels.same_grid(image)
    simplexseg.write_labels(tmp_path / "labels.nii", labels)
    written = (tmp_path / "labels.nii").read_bytes()
    assert written[76:92] == bytes(header[76:92])
    assert written[252:328] == bytes(header[252:328])
    assert written[123] == 0
    with pytest.raises(Error, match="defined twice"):
        simplexseg.Volume(np.ones(image.shape), like=image, spacing=(1, 1, 1))


def test_sheared_grids_are_written_with_a_warning(tmp_path):
    affine = np.eye(4)
    affine[0, 2] = 0.5
    with pytest.warns(DataWarning, match="right angles"):
        simplexseg.write_volume(tmp_path / "v.nii", simplexseg.Volume(np.zeros((2, 2, 2), np.uint8), affine_lps=affine))


def test_labels_keep_their_names(tmp_path, phantom):
    simplexseg.write_labels(tmp_path / "l.seg.nrrd", phantom[1], {1: "Kugel, groß"})
    labels, names = simplexseg.read_labels(tmp_path / "l.seg.nrrd")
    assert names == {1: "Kugel, groß"}
    np.testing.assert_array_equal(labels.array, phantom[1].array)
    with pytest.raises(Error, match="must be integers"):
        simplexseg.write_labels(tmp_path / "l.nii", simplexseg.Volume(np.zeros((2, 2, 2))))


def test_labels_are_resampled_onto_another_grid(tmp_path, phantom):
    simplexseg.write_labels(tmp_path / "l.nii", phantom[1])
    finer = simplexseg.make_phantom("sphere", size=48, spacing=1)[0]
    with pytest.warns(DataWarning):
        labels, _ = simplexseg.read_labels(tmp_path / "l.nii", like=finer)
    assert labels.same_grid(finer)
    assert labels.array.sum() == 8 * int(phantom[1].array.sum())


def test_assumptions_of_the_reader_are_warnings(tmp_path, ramp):
    voxels = np.zeros((2, 2, 2), np.float32)
    voxels[0, 0, 0] = np.nan
    simplexseg.write_volume(tmp_path / "v.nii", simplexseg.Volume(voxels))
    with pytest.warns(DataWarning, match="1 voxel is not a finite"):
        simplexseg.read_volume(tmp_path / "v.nii")
    with pytest.raises(DataWarning):
        import warnings

        with warnings.catch_warnings():
            warnings.simplefilter("error")
            simplexseg.read_volume(tmp_path / "v.nii")


def test_files_that_cannot_be_read_are_one_line(tmp_path):
    (tmp_path / "text.nii").write_text("no image")
    (tmp_path / "empty.nii").write_text("")
    for name in ["absent.nii", "text.nii", "empty.nii"]:
        for read in [simplexseg.read_volume, simplexseg.read_info, simplexseg.read_labels]:
            with pytest.raises(Error) as refused:
                read(tmp_path / name)
            assert name in str(refused.value) and "\n" not in str(refused.value)
    with pytest.raises(Error, match="out of range"):
        simplexseg.read_volume(tmp_path / "text.nii", number=0)
    with pytest.raises(TypeError):
        simplexseg.read_volume(3)


def test_file_names_that_are_not_utf_8(tmp_path):
    with pytest.raises(Error, match="cannot|no such|absent"):
        simplexseg.read_volume(os.fsencode(tmp_path) + b"/\xff\xfe.nii")


def test_a_missing_folder_is_rejected(tmp_path, ramp):
    with pytest.raises(Error):
        simplexseg.write_volume(tmp_path / "absent" / "v.nii", ramp)
    with pytest.raises(Error, match="extension"):
        simplexseg.write_volume(tmp_path / "v.png", ramp)


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_no_file_ends_the_interpreter(data):
    """Reads damaged files; one of them violates an assertion of GDCM."""
    names = sorted(p for p in (data / "bad_input").iterdir() if p.is_file() and "DICOMDIR" in p.name or p.suffix == ".mnc")
    assert names
    for path in names:
        try:
            assert min(simplexseg.read_volume(path).shape) >= 1
        except Error as error:
            assert "\n" not in str(error)
