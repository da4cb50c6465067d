# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pytest

import simplexseg
from simplexseg import DataWarning, Error, Volume


def cube(first, last, size=12, **geometry):
    voxels = np.zeros((size, size, size), np.uint8)
    voxels[first:last, 2:6, 2:6] = 3
    return Volume(voxels, **geometry)


def test_equal_labels_agree():
    result = simplexseg.compare(cube(2, 6), cube(2, 6))
    assert result["dice"] == 1 and result["surface_dice"] == 1
    assert result["hd_mm"] == result["hd95_mm"] == result["assd_mm"] == 0


def test_a_shift_is_measured_in_millimetres():
    spacing = (2, 1, 1)
    result = simplexseg.compare(cube(2, 6, spacing=spacing), cube(3, 7, spacing=spacing))
    assert result["dice"] == pytest.approx(0.75)
    assert result["hd_mm"] == pytest.approx(2)
    assert result["reference_mm3"] == result["test_mm3"] == pytest.approx(4 * 4 * 4 * 2)


def test_one_label_of_several_and_an_empty_one():
    assert simplexseg.compare(cube(2, 6), cube(3, 7), 3)["dice"] == pytest.approx(0.75)
    nothing = simplexseg.compare(cube(2, 6), cube(3, 7), 1)
    assert nothing["dice"] == 1 and nothing["reference_mm3"] == 0
    empty = simplexseg.compare(cube(2, 6), Volume(np.zeros((12, 12, 12), np.uint8)))
    assert empty["dice"] == 0 and math.isinf(empty["hd_mm"])
    with pytest.raises(Error, match="finite"):
        simplexseg.compare(cube(2, 6), cube(2, 6), math.inf)
    with pytest.raises(Error):
        simplexseg.compare(cube(2, 6), cube(2, 6), tolerance_mm=-1)


def test_test_labels_are_resampled_onto_the_reference(tmp_path):
    finer = np.repeat(np.repeat(np.repeat(cube(2, 6).array, 2, 0), 2, 1), 2, 2)
    test = Volume(finer, spacing=(0.5, 0.5, 0.5), origin=(-0.25, -0.25, -0.25))
    with pytest.warns(DataWarning):
        assert simplexseg.compare(cube(2, 6), test)["dice"] == 1
    simplexseg.write_labels(tmp_path / "test.nii", test)
    with pytest.warns(DataWarning):
        assert simplexseg.compare(cube(2, 6), tmp_path / "test.nii")["dice"] == 1
    with pytest.raises(Error):
        simplexseg.compare(cube(2, 6), Volume(test.array, origin=(1000, 0, 0)))


def test_every_number_is_defined():
    assert list(simplexseg.metric_definitions()) == list(simplexseg.compare(cube(2, 6), cube(2, 6)))
    assert all(simplexseg.metric_definitions().values())


def test_phantoms_have_reference_labels():
    image, labels = simplexseg.make_phantom("two-spheres", size=32)
    assert set(np.unique(labels.array)) == {0, 1, 2}
    assert image.array[labels.array == 1].mean() > image.array[labels.array == 0].mean() + 80
    np.testing.assert_allclose(image.centre, 0, atol=1e-9)
    noisy = [simplexseg.make_phantom("cube", size=16, noise=10, seed=seed)[0].array for seed in (1, 1, 2)]
    assert (noisy[0] == noisy[1]).all() and (noisy[0] != noisy[2]).any()
    for kind, size in [("pyramid", 32), ("cube", -1), ("cube", 10**6)]:
        with pytest.raises(Error):
            simplexseg.make_phantom(kind, size=size)
