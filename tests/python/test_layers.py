# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

import simplexseg
from simplexseg import Error, Session, Volume


@pytest.fixture
def images(tmp_path):
    grid = np.indices((16, 16, 16), dtype=np.float32)
    simplexseg.write_volume(tmp_path / "image.nii", Volume(grid[2], spacing=(2, 2, 2)))
    simplexseg.write_volume(tmp_path / "other.nii", Volume(10 * grid[0] + grid[1], spacing=(1, 1, 1)))
    return tmp_path


def test_layers_are_added_edited_and_undone(images):
    with Session(images / "image.nii") as session:
        assert session.layers == []
        layer = session.add_layer(images / "other.nii")
        other = session.add_layer(images / "other.nii", name="T2")
        assert session.layers == [layer, other] and layer != other and len({layer, session.layers[0]}) == 1
        assert layer.name == "other" and other.name == "T2" and layer.path == images / "other.nii"
        assert layer.visible and layer.filters == "" and layer.unit == ""
        layer.opacity, layer.window, layer.level = 0.25, 100, 50
        assert (layer.opacity, layer.window, layer.level) == (0.25, 100, 50)
        with pytest.raises(Error, match="opacity"):
            layer.opacity = 2
        layer.visible = False
        assert session.undo() and layer.visible
        other.remove()
        assert session.layers == [layer]
        with pytest.raises(Error, match="no longer"):
            other.name


def test_values_are_interpolated_at_points_of_the_volume(images):
    with Session(images / "image.nii") as session:
        layer = session.add_layer(images / "other.nii")
        values = layer.values_at([[(2.5, 3, 4), (0, 0, 0)], [(1, 1, 1), (25, 0, 0)]])
        assert values.shape == (2, 2)
        assert values[0] == pytest.approx([28, 0]) and values[1, 0] == pytest.approx(11) and np.isnan(values[1, 1])
        affine = np.eye(4)
        affine[0, 3] = -10
        layer.affine = affine
        assert (layer.affine == affine).all()
        assert layer.values_at((25, 0, 0)) == pytest.approx(150)
        with pytest.raises(Error, match="invertible"):
            layer.affine = np.zeros((4, 4))


def test_a_saved_scene_has_its_layers_and_pictures_show_them(images):
    with Session(images / "image.nii") as session:
        layer = session.add_layer(images / "other.nii")
        session.save_picture(images / "with.png")
        layer.visible = False
        session.save_picture(images / "without.png")
        session.save_scene(images / "scene.json")
    assert (images / "with.png").read_bytes() != (images / "without.png").read_bytes()
    with Session(images / "scene.json") as session:
        (layer,) = session.layers
        assert not layer.visible and layer.values_at((2, 3, 4)) == pytest.approx(23)
    (images / "other.nii").unlink()
    with Session(images / "scene.json") as session, pytest.raises(Error, match="other.nii"):
        session.layers[0].values_at((0, 0, 0))


def test_filters_of_scenes_are_applied(images):
    scene = images / "scene.json"
    scene.write_text(
        '{"simplexseg_scene": 1, "volume": "image.nii", "preprocessing": {"filters": [{"name": "suv", "factor": 0.5}]},'
        ' "layers": [{"name": "a", "image": "other.nii", "window": 1, "level": 0,'
        ' "preprocessing": {"filters": [{"name": "suv", "factor": 3}]}}]}'
    )
    with Session(scene) as session:
        assert session.volume.array[0, 0, 6] == 3
        assert session.layers[0].filters == "Uptake values (factor 3)"
        assert session.layers[0].values_at((2, 3, 4)) == pytest.approx(69)
