# SPDX-License-Identifier: Apache-2.0
import gc

import numpy as np
import pytest

import simplexseg
from simplexseg import Error, Volume

KEPT = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"]


@pytest.mark.parametrize("dtype", KEPT)
def test_voxels_round_trip(dtype):
    voxels = np.arange(2 * 3 * 4).reshape(2, 3, 4).astype(dtype)
    volume = Volume(voxels)
    assert volume.dtype == np.dtype(dtype)
    assert volume.shape == (2, 3, 4)
    np.testing.assert_array_equal(volume.array, voxels)


def test_memory_layout_and_byte_order_do_not_matter():
    voxels = np.arange(2 * 3 * 4, dtype=np.int16).reshape(2, 3, 4)
    layouts = [np.asfortranarray(voxels), voxels.astype(">i2"), voxels.transpose(2, 1, 0).copy().transpose(2, 1, 0)]
    layouts.append(np.repeat(voxels, 2, axis=1)[:, ::2])
    layouts.append(voxels[::-1, :, ::-1][::-1, :, ::-1])
    for layout in layouts:
        np.testing.assert_array_equal(Volume(layout).array, voxels)


def test_other_types_are_converted_without_loss():
    flags = np.random.default_rng(1).random((3, 3, 3)) > 0.5
    assert Volume(flags).dtype == np.uint8
    np.testing.assert_array_equal(Volume(flags).array, flags)
    halves = np.full((2, 2, 2), 0.5, np.float16)
    assert Volume(halves).dtype == np.float32
    assert Volume(np.full((1, 1, 1), -(2**31), np.int64)).dtype == np.int32
    assert Volume(np.full((1, 1, 1), 2**32 - 1, np.uint64)).array[0, 0, 0] == 2**32 - 1
    np.testing.assert_array_equal(Volume([[[1, 2], [3, 4]]]).array, [[[1, 2], [3, 4]]])


@pytest.mark.parametrize(
    "array, words",
    [
        (np.zeros((3, 3)), "it has 2 axes"),
        (np.zeros((3, 3, 3, 3)), "it has 4 axes"),
        (np.zeros((0, 3, 3)), "axis 0 has 0 voxels"),
        (np.zeros((2, 2, 2), complex), "complex128"),
        (np.full((2, 2, 2), "a"), "<U1"),
        (np.full((2, 2, 2), None), "object"),
        (np.full((2, 2, 2), 2**40), "do not fit into 32 bits"),
        (np.array([[[-1, 2**32 - 1]]]), "do not fit into 32 bits"),
        (np.broadcast_to(np.uint8(1), (2**20, 2**20, 2**20)), "voxels"),
        (np.broadcast_to(np.float32(1), (2**15, 2**15, 2**15)), "of memory"),
        (np.broadcast_to(np.uint8(1), (2**33, 1, 1)), "axis 0 has"),
        ("brain.nii", "axes"),
        (None, "axes"),
    ],
)
def test_invalid_arrays_are_rejected(array, words):
    with pytest.raises(Error, match=words) as refused:
        Volume(array)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "geometry, words",
    [
        ({"spacing": (1, 0, 1)}, "spacing"),
        ({"spacing": (1, np.nan, 1)}, "not finite"),
        ({"spacing": (1, 2)}, "three numbers"),
        ({"spacing": "abc"}, "three numbers"),
        ({"direction": np.ones((3, 3))}, "cannot be inverted"),
        ({"direction": np.eye(4)}, "3 x 3"),
        ({"affine_lps": np.zeros((4, 4))}, "last row"),
        ({"affine_ras": np.eye(3)}, "4 x 4"),
        ({"affine_ras": np.diag([1, 0, 1, 1])}, "spacing"),
        ({"affine_ras": np.eye(4), "affine_lps": np.eye(4)}, "defined twice"),
        ({"affine_ras": np.eye(4), "spacing": (1, 1, 1)}, "defined twice"),
    ],
)
def test_invalid_geometries_are_rejected(geometry, words):
    with pytest.raises(Error, match=words):
        Volume(np.zeros((2, 2, 2)), **geometry)


def test_values_that_are_not_finite_are_kept():
    voxels = np.full((3, 3, 3), np.nan)
    voxels[1, 1, 1] = np.inf
    np.testing.assert_array_equal(Volume(voxels).array, voxels)


def test_positions_and_indices_are_inverse(ramp):
    affine = ramp.affine_lps
    np.testing.assert_allclose(affine[:3, :3], ramp.direction * np.array(ramp.spacing))
    np.testing.assert_allclose(affine[:3, 3], ramp.origin)
    indices = np.random.default_rng(2).random((7, 2, 3)) * 5
    points = ramp.lps_from_index(indices)
    np.testing.assert_allclose(points, indices @ affine[:3, :3].T + affine[:3, 3])
    np.testing.assert_allclose(ramp.index_from_lps(points), indices, atol=1e-12)
    np.testing.assert_allclose(ramp.lps_from_index([0, 0, 0]), ramp.origin)
    np.testing.assert_allclose(ramp.lps_from_index((np.array(ramp.shape) - 1) / 2), ramp.centre)
    with pytest.raises(Error, match="last axis"):
        ramp.lps_from_index([1, 2])


def test_both_affines_are_of_the_same_grid(ramp):
    np.testing.assert_allclose(ramp.affine_ras, np.diag([-1, -1, 1, 1]) @ ramp.affine_lps)
    for key in ["affine_lps", "affine_ras"]:
        again = Volume(ramp.array, **{key: getattr(ramp, key)})
        assert again.same_grid(ramp)
        np.testing.assert_allclose(again.spacing, ramp.spacing)
    assert not Volume(ramp.array).same_grid(ramp)


def test_arrays_share_the_memory_of_the_volume_and_outlive_it(ramp):
    voxels = np.array(ramp.array)
    array = ramp.array
    assert not array.flags.writeable
    assert array.flags.f_contiguous
    assert np.shares_memory(array, ramp.array)
    assert np.shares_memory(np.asarray(ramp), array)
    with pytest.raises(ValueError):
        array[0, 0, 0] = 1
    row = Volume(voxels).array[1]
    gc.collect()
    np.testing.assert_array_equal(row, voxels[1])
    assert np.asarray(ramp, dtype=float).dtype == float


def test_changes_of_the_source_array_have_no_effect(ramp):
    voxels = np.zeros((2, 2, 2), np.uint8, order="F")
    volume = Volume(voxels)
    voxels[:] = 7
    assert volume.array.max() == 0


def test_errors_have_one_type():
    assert issubclass(Error, RuntimeError)
    assert issubclass(simplexseg.SimulationError, Error)
    assert issubclass(simplexseg.DataWarning, UserWarning)
