# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

import simplexseg
from simplexseg import Error, Mesh


@pytest.fixture
def sphere():
    return Mesh.sphere((10, -20, 30), 8, level=3)


def test_measures_of_a_sphere(sphere):
    assert len(sphere) == 20 * 4**3
    np.testing.assert_allclose(np.linalg.norm(sphere.vertices - np.float32([10, -20, 30]), axis=1), 8, rtol=1e-5)
    assert sphere.volume_mm3 == pytest.approx(4 / 3 * np.pi * 8**3, rel=0.01)
    assert sphere.area_mm2 == pytest.approx(4 * np.pi * 8**2, rel=0.01)
    np.testing.assert_allclose(sphere.centroid, (10, -20, 30), atol=1e-4)
    assert sphere.mean_edge_mm > 0


def test_fractions_add_up_to_the_volume(sphere):
    like = simplexseg.Volume(np.zeros((9, 9, 9), np.uint8), spacing=(3, 3, 3), origin=(-2, -32, 18))
    fractions = sphere.fractions(like)
    assert fractions.array.dtype == np.float32 and fractions.array.min() == 0 and fractions.array.max() == 1
    assert 27 * fractions.array.sum() == pytest.approx(sphere.volume_mm3, rel=0.003)


def test_neighbours_are_mutual(sphere):
    for vertex in range(0, len(sphere), 97):
        for other in sphere.neighbours[vertex]:
            assert vertex in sphere.neighbours[other]
    assert not sphere.vertices.flags.writeable and sphere.vertices.dtype == np.float32
    assert sphere.neighbours.dtype == np.int32


def test_arrays_recreate_the_mesh(sphere):
    again = Mesh(sphere.vertices, sphere.neighbours)
    np.testing.assert_array_equal(again.vertices, sphere.vertices)
    np.testing.assert_array_equal(again.neighbours, sphere.neighbours)
    assert Mesh(sphere.vertices.astype(">f8"), sphere.neighbours.astype(np.int64)).volume_mm3 == sphere.volume_mm3


def test_triangles_are_closed_and_oriented_outward(sphere):
    points, triangles = sphere.tessellate()
    assert len(triangles) == 3 * len(sphere)
    assert len(points) == len(sphere) + len(sphere) // 2 + 2
    a, b, c = (points[triangles[:, k]].astype(float) for k in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(sphere.volume_mm3, rel=1e-6)
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert Mesh.from_triangles(points, triangles).volume_mm3 == pytest.approx(sphere.volume_mm3, rel=0.03)


@pytest.mark.parametrize(
    "vertices, neighbours",
    [
        (np.zeros((4, 3)), np.zeros((4, 3), int)),
        (np.zeros((4, 2)), np.zeros((4, 3), int)),
        (np.zeros((4, 3)), np.zeros((4, 3))),
        (np.zeros((0, 3)), np.zeros((0, 3), int)),
        (np.full((4, 3), np.nan), [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
        (np.eye(4, 3), [[1, 2, 9], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
        (np.eye(4, 3), [[1, 2, -1], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
        (np.eye(4, 3), np.full((4, 3), 2**40)),
        (np.full((4, 3), "a"), np.zeros((4, 3), int)),
        (None, None),
    ],
)
def test_invalid_meshes_are_rejected(vertices, neighbours):
    with pytest.raises(Error) as refused:
        Mesh(vertices, neighbours)
    assert "\n" not in str(refused.value)


def test_open_triangulations_are_rejected():
    points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]
    closed = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]
    assert len(Mesh.from_triangles(points, closed)) == 4
    for triangles in [closed[:3], [*closed[:3], [0, 3, 7]], closed * 2, []]:
        with pytest.raises(Error):
            Mesh.from_triangles(points, triangles)


@pytest.mark.parametrize("radius, level", [(0, 1), (np.nan, 1), (-1, 1), (1, -1), (1, 20)])
def test_spheres_out_of_range_are_rejected(radius, level):
    with pytest.raises(Error):
        Mesh.sphere((0, 0, 0), radius, level)


@pytest.mark.parametrize("extension", ["ply", "obj", "stl", "vtk", "vtp"])
def test_meshes_round_trip(tmp_path, sphere, extension):
    simplexseg.write_mesh(tmp_path / f"m.{extension}", sphere)
    again = simplexseg.read_mesh(tmp_path / f"m.{extension}")
    assert again.volume_mm3 == pytest.approx(sphere.volume_mm3, rel=0.03)
    if extension == "ply":
        np.testing.assert_array_equal(again.vertices, sphere.vertices)
        np.testing.assert_array_equal(again.neighbours, sphere.neighbours)


def test_a_mesh_of_labels_reproduces_the_labels(phantom):
    labels = phantom[1]
    mesh = simplexseg.mesh_from_labels(labels, 1)
    voxel = np.prod(labels.spacing)
    assert mesh.volume_mm3 == pytest.approx(labels.array.sum() * voxel, rel=0.01)
    inside = mesh.rasterise(labels)
    assert inside.dtype == np.uint8 and inside.same_grid(labels)
    assert simplexseg.compare(labels, inside)["dice"] > 0.97
    assert len(simplexseg.mesh_from_labels(labels, vertices=500)) == pytest.approx(500, rel=0.2)
    with pytest.raises(Error, match="label 7"):
        simplexseg.mesh_from_labels(labels, 7)
    with pytest.raises(Error):
        simplexseg.mesh_from_labels(labels, part=2)
    with pytest.raises(Error, match="finite"):
        simplexseg.mesh_from_labels(labels, np.nan)
    with pytest.raises(Error, match="out of range"):
        simplexseg.mesh_from_labels(labels, vertices=-5)
