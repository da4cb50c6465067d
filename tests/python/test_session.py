# SPDX-License-Identifier: Apache-2.0
import json

import numpy as np
import pytest

import simplexseg
from simplexseg import DataWarning, Error, Session, Volume


def test_a_sphere_grows_to_the_object_and_settles(session, phantom):
    result = session.run_until_rest()
    assert result.at_rest and result.steps == session.steps > 0 and result.seconds > 0
    labels = session.labels()
    assert labels.same_grid(phantom[0]) and labels.dtype == np.uint8
    assert simplexseg.compare(phantom[1], labels)["dice"] > 0.95
    assert session.run_until_rest().steps == 0
    assert session.backend == "cpu" and "CPU" in session.device


def test_exact_numbers_of_steps(session):
    assert session.run(7).steps == 7
    assert session.run(0).steps == 0
    assert session.run(33).steps == 33 and session.steps == 40
    assert session.run_until_rest(3).steps == 3
    assert session.run_for(0).steps == 0
    assert session.run_for(0.05).steps > 0
    for steps in (-1, 2**30 + 5):
        with pytest.raises(Error, match="out of range"):
            session.run(steps)
    with pytest.raises(TypeError):
        session.run(2**40)
    for seconds in (-1, np.nan, np.inf):
        with pytest.raises(Error, match="seconds"):
            session.run_for(seconds)


def test_shapes_are_independent_copies(session):
    ball = session.mesh("ball")
    before = ball.mesh
    vertices = before.vertices.copy()
    assert len(before) == 80
    session.run_until_rest()
    assert len(ball.mesh) == 320
    np.testing.assert_array_equal(before.vertices, vertices)
    session.close()
    np.testing.assert_array_equal(before.vertices, vertices)


def test_meshes_are_named_listed_and_edited(session):
    ball = session.mesh("ball")
    other = session.add_mesh(centre=(0, 14, 0), radius=4, like=ball)
    assert [mesh.name for mesh in session.meshes] == ["ball", "mesh 1"]
    assert session.meshes[1] == other and other != ball and len({ball, session.meshes[0]}) == 1
    other.name, other.label, other.colour, other.opacity = "knob", 7, (1, 2, 3), 0.5
    other.locked, other.visible = True, False
    assert (other.name, other.label, other.colour, other.opacity) == ("knob", 7, (1, 2, 3), 0.5)
    assert other.locked and not other.visible
    assert session.labels().array.max() == 7
    for attribute, value in [("name", "ball"), ("name", ""), ("label", 0), ("label", 70000), ("opacity", 2)]:
        with pytest.raises(Error):
            setattr(other, attribute, value)
    for attribute, value in [("colour", (1, 2, 300)), ("name", b"\xff"), ("name", None), ("label", 1.5)]:
        with pytest.raises(TypeError):
            setattr(other, attribute, value)
    with pytest.raises(TypeError):
        session.add_mesh(b"\xff", centre=(0, 0, 0), radius=4)
    other.delete()
    with pytest.raises(Error, match="no longer"):
        other.name
    with pytest.raises(Error, match="has this name"):
        session.mesh("knob")


def test_points_attract_mark_and_move(session):
    ball = session.mesh("ball")
    session.run_until_rest()
    before = ball.mesh.volume_mm3
    pull = ball.add_point((20, 0, 0))
    assert (pull.kind, pull.position, pull.mesh) == ("boundary", (20, 0, 0), ball)
    session.run(200)
    assert ball.mesh.vertices[:, 0].max() > 17
    mark = ball.add_point((5, 0, 0), "inside", radius=3)
    assert mark.radius == 3
    mark.resize(2)
    mark.move((4, 0, 0))
    assert (mark.radius, mark.position) == (2, (4, 0, 0))
    assert session.points == ball.points == [pull, mark]
    stroke = ball.add_point((14, -4, 0), "outside", path=[(15, 0, 0), (14, 4, 0)])
    assert stroke.path == [(14, -4, 0), (15, 0, 0), (14, 4, 0)] and mark.path == [(4, 0, 0)]
    stroke.move((14, -4, 1))
    assert stroke.path[-1] == (14, 4, 1)
    stroke.delete()
    unpainted = session.labels().array.copy()
    paint = ball.paint([(0, 0, 22), (4, 0, 22)], 3)
    ball.paint([(0, 0, 8)], 4, erase=True, normal=(0, 0, 1), thickness=2)
    changed = session.labels().array.astype(int) - unpainted
    assert (changed > 0).any() and (changed < 0).any()
    paint.delete()
    assert ((session.labels().array.astype(int) - unpainted) <= 0).all()
    session.undo(), session.undo(), session.undo()
    assert (session.labels().array == unpainted).all()
    with pytest.raises(Error, match="path"):
        ball.add_point((14, -4, 0), "boundary", path=[(15, 0, 0)])
    mark.delete()
    pull.delete()
    assert session.points == []
    session.run_until_rest()
    assert ball.mesh.volume_mm3 == pytest.approx(before, rel=0.1)
    for position, kind in [((0, 0), "boundary"), ((0, 0, np.nan), "boundary"), ((1e4, 0, 0), "inside"), ("abc", "inside")]:
        with pytest.raises(Error):
            ball.add_point(position, kind)
    with pytest.raises(Error, match="has this name"):
        ball.add_point((0, 0, 0), "beside")
    with pytest.raises(Error, match="no such point"):
        pull.move((0, 0, 0))
    with pytest.raises(Error, match="no longer"):
        pull.position


def test_undo_restores_the_exact_shape(session):
    ball = session.mesh("ball")
    session.run(50)
    before = ball.mesh.vertices
    ball.add_point((20, 0, 0))
    session.run(50)
    after = ball.mesh.vertices
    assert session.can_undo and "point" in session.undo_title
    assert session.undo()
    np.testing.assert_array_equal(ball.mesh.vertices, before)
    assert session.can_redo and session.redo()
    np.testing.assert_array_equal(ball.mesh.vertices, after)
    assert not session.redo()
    while session.undo():
        pass
    assert session.meshes == [] and session.undo_title == ""


def test_parameters_are_those_of_the_tables(session):
    ball = session.mesh("ball")
    table = simplexseg.parameters()
    for name, parameter in table.items():
        owner = session if name.startswith("simulation.") else ball
        assert parameter.doc and isinstance(parameter.unit, str)
        extremes = parameter.choices or [parameter.minimum, parameter.maximum]
        for value in [*extremes, parameter.default]:
            owner.set(name, value)
            assert owner.get(name) == value
    for name, value in [("forces.smoothing.weight", 1e9), ("forces.smoothing.weight", np.nan), ("simulation.solver", "euler")]:
        with pytest.raises(Error):
            (session if name.startswith("sim") else ball).set(name, value)
    with pytest.raises(Error, match="nearest known is 'forces.smoothing.weight'"):
        ball.set("forces.smoothing.wieght", 1)
    with pytest.raises(TypeError):
        ball.set("forces.smoothing.weight", None)
    with pytest.raises(Error, match="not a parameter of a mesh"):
        ball.set("simulation.timestep", 1)
    session.set("forces.smoothing.weight", 2.5)
    assert ball.get("forces.smoothing.weight") == 2.5


def test_settings_apply_to_future_meshes(phantom):
    with Session(phantom[0], settings={"forces.gradient.weight": 0.25, "simulation.solver": "damped"}) as session:
        assert session.add_mesh(centre=(0, 0, 0), radius=5).get("forces.gradient.weight") == 0.25
        assert session.get("simulation.solver") == "damped"
    for settings in [{"forces.gradient.wait": 1}, {"simulation.solver": 3.5}, {"": 1}]:
        with pytest.raises(Error):
            Session(phantom[0], settings=settings)


def test_evidence_is_a_probability_on_its_box(session, phantom):
    ball = session.mesh("ball")
    assert ball.evidence() is None
    ball.add_point((0, 0, 0), "inside")
    session.run(10)
    field = ball.evidence()
    assert field.dtype == np.float32 and 0 <= field.array.min() and field.array.max() <= 1
    np.testing.assert_allclose(field.spacing, phantom[0].spacing)
    corner = phantom[0].index_from_lps(field.origin)
    np.testing.assert_allclose(corner, np.round(corner), atol=1e-9)
    first = np.round(corner).astype(int)
    box = tuple(slice(f, f + n) for f, n in zip(first, field.shape))
    truth = phantom[1].array[box] == 1
    assert field.array[truth].mean() > 0.9 > 0.1 > field.array[~truth].mean()


def test_a_mesh_starts_from_labels(session, phantom, tmp_path):
    mesh = session.add_mesh_from(phantom[1], "given", label=1)
    assert simplexseg.compare(phantom[1], mesh.mesh.rasterise(phantom[1]))["dice"] > 0.95
    with pytest.raises(Error, match="no file"):
        simplexseg.write_volume(tmp_path / "v.nii", phantom[0])
        with Session(simplexseg.read_volume(tmp_path / "v.nii")) as saved:
            saved.add_mesh_from(phantom[1])
            saved.save_scene(tmp_path / "s.json")
    simplexseg.write_labels(tmp_path / "l.nii", phantom[1])
    assert session.add_mesh_from(tmp_path / "l.nii", label=1).name == "mesh 1"
    simplexseg.write_mesh(tmp_path / "m.ply", mesh.mesh)
    again = session.add_mesh_from(tmp_path / "m.ply").mesh
    np.testing.assert_array_equal(again.vertices, mesh.mesh.vertices)
    with pytest.raises(Error):
        session.add_mesh_from(phantom[1], label=9)


def test_refine_reset_duplicate(session):
    ball = session.mesh("ball")
    start = ball.mesh.vertices
    ball.refine()
    assert len(ball.mesh) == 4 * len(start)
    copy = ball.duplicate()
    assert copy.name == "ball copy" and copy.label != ball.label
    ball.record_profiles()
    ball.reset()
    np.testing.assert_array_equal(ball.mesh.vertices, start)


def test_seeds_outside_or_without_size_are_rejected(session, phantom):
    for centre, radius in [((1e3, 0, 0), 5), ((0, 0, 0), 0), ((0, 0, 0), np.nan), ((0, 0), 5), (None, 5)]:
        with pytest.raises(Error):
            session.add_mesh(centre=centre, radius=radius)
    assert len(session.meshes) == 1
    with Session(phantom[0]) as other, pytest.raises(Error, match="another session"):
        other.add_mesh(centre=(0, 0, 0), radius=5, like=session.mesh("ball"))


def test_failed_steps_raise_error_and_the_session_continues(session):
    stiff = {"simulation.solver": "verlet", "simulation.damping": 0, "forces.evidence.source": "intensities"}
    stiff |= {"forces.shape_memory.weight": 10, "forces.shape_memory.scaling": 1, "forces.evidence.weight": 5}
    for name, value in stiff.items():
        session.set(name, value)
    session.mesh("ball").add_point((20, 0, 0))
    with pytest.raises(simplexseg.SimulationError, match="after [0-9]+ steps: segmentation 'ball': force shape_memory"):
        session.run(1000)
    assert np.isfinite(session.mesh("ball").mesh.vertices).all()
    session.set("simulation.solver", "automatic")
    session.set("forces.shape_memory.weight", 0.1)
    assert session.run(20).steps == 20


def test_a_saved_session_continues(session, phantom, tmp_path):
    with pytest.raises(Error, match="no file"):
        session.save_scene(tmp_path / "s.json")
    simplexseg.write_volume(tmp_path / "v.nii.gz", phantom[0])
    with Session(simplexseg.read_volume(tmp_path / "v.nii.gz"), backend="cpu") as first:
        first.add_mesh("ball", centre=(1, 0, 0), radius=9)
        first.run(30)
        first.save_scene(tmp_path / "s.json")
        vertices = first.mesh("ball").mesh.vertices
    with Session(tmp_path / "s.json", backend="cpu") as again:
        np.testing.assert_array_equal(again.mesh("ball").mesh.vertices, vertices)
        np.testing.assert_array_equal(again.volume.array, phantom[0].array)
        assert again.can_undo and again.undo() and again.meshes == []
    with pytest.raises(Error, match="ends in .json"):
        session.save_scene(tmp_path / "s.txt")


def test_results_are_written(session, tmp_path):
    session.run(20)
    session.save_labels(tmp_path / "l.seg.nrrd")
    labels, names = simplexseg.read_labels(tmp_path / "l.seg.nrrd")
    assert names == {1: "ball"}
    np.testing.assert_array_equal(labels.array, session.labels().array)
    assert session.save_meshes(tmp_path / "meshes", "stl") == [tmp_path / "meshes" / "ball.stl"]
    session.save_picture(tmp_path / "p.png")
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG")
    session.save_report(tmp_path / "r.json")
    report = json.loads((tmp_path / "r.json").read_text())
    assert report["steps"] == 20 and report["meshes"][0]["name"] == "ball"
    for save in [session.save_labels, session.save_picture, session.save_meshes]:
        with pytest.raises(Error):
            save(tmp_path / "p.png" / "below")
    with pytest.raises(Error):
        session.save_meshes(tmp_path, "docx")


def test_shared_voxels_are_a_warning(session, tmp_path):
    session.add_mesh(centre=(2, 0, 0), radius=9)
    with pytest.warns(DataWarning, match="lie inside two or more segmentations"):
        session.save_labels(tmp_path / "l.nii")


def test_a_closed_session_raises_error(phantom):
    session = Session(phantom[0])
    mesh = session.add_mesh(centre=(0, 0, 0), radius=5)
    point = mesh.add_point((1, 1, 1))
    session.close()
    session.close()
    assert session.closed and "closed" in repr(session) and "closed" in repr(mesh)
    for use in [session.run, session.labels, session.undo, lambda: session.meshes, lambda: mesh.mesh, point.delete]:
        with pytest.raises(Error, match="it is closed"):
            use()


@pytest.mark.parametrize("options", [{"threads": -1}, {"threads": 5000}, {"backend": "tpu"}, {"backend": "cuda", "threads": 2}])
def test_invalid_backends_and_threads(phantom, options):
    with pytest.raises(Error):
        Session(phantom[0], **options)
    with pytest.raises(TypeError):
        Session(phantom[0], threads="two")


def test_cuda_without_a_device(phantom):
    if not simplexseg.why_no_cuda():
        with Session(phantom[0], backend="cuda") as session:
            assert session.backend == "cuda"
    else:
        with pytest.raises(Error):
            Session(phantom[0], backend="cuda")


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_sessions_on_one_voxel_and_on_nan():
    for voxels in [np.zeros((1, 1, 1)), np.full((5, 5, 5), np.nan)]:
        with Session(Volume(voxels), backend="cpu") as session:
            session.add_mesh(centre=(0, 0, 0), radius=2)
            assert session.run(30).steps == 30
            assert np.isfinite(session.meshes[0].mesh.vertices).all()


def test_invalid_sources(tmp_path, ramp):
    (tmp_path / "broken.json").write_text("{")
    for source in [tmp_path / "absent.nii", tmp_path / "broken.json", tmp_path, ""]:
        with pytest.raises(Error):
            Session(source)
    for source in [None, 3, ramp.array]:
        with pytest.raises(TypeError):
            Session(source)


def test_names_of_a_label_preset_have_labels_and_codes(session, tmp_path):
    ball = session.mesh("ball")
    assert ball.code["type"] == ("SCT", "85756007", "Tissue") and session.label_preset == ""
    session.label_preset = "abdomen"
    assert session.label_preset == "abdomen" and "abdomen" in simplexseg.label_presets()
    ball.name = "Left kidney"
    entry = simplexseg.read_label_preset("abdomen")["Left kidney"]
    assert ball.label == entry["label"] == 3
    assert ball.code == entry["code"]
    assert ball.code["modifier"] == ("SCT", "7771000", "Left") and len(entry["colour"]) == 3
    ball.code = {"category": ("SCT", "85756007", "Tissue"), "type": ("99X", "1", "Blob")}
    assert ball.code["type"] == ("99X", "1", "Blob") and "modifier" not in ball.code
    for code in ({"type": ("SCT", "1", "a")}, {"category": ("SCT", "1", "a")}, {"x": 1}, 5, {"type": ("a", "b")}):
        with pytest.raises(Error, match="code"):
            ball.code = code
    ball.code = {}
    assert ball.code == entry["code"]
    session.undo()
    assert ball.code["type"] == ("99X", "1", "Blob")
    with pytest.raises(Error, match="heart"):
        session.label_preset = "hart"
    with pytest.raises(Error, match="none.json"):
        simplexseg.read_label_preset(str(tmp_path / "none.json"))
    session.label_preset = ""
    assert session.label_preset == "" and ball.label == 3


def test_points_of_a_locked_mesh_stay(session):
    mesh = session.meshes[0]
    point = mesh.add_point(mesh.mesh.centroid, "inside", radius=2)
    mesh.locked = True
    with pytest.raises(Error, match="it is locked; unlock it first"):
        point.move(np.asarray(point.position) + 1)
    with pytest.raises(Error, match="locked"):
        point.resize(3)
    with pytest.raises(Error, match="locked"):
        point.delete()
    mesh.locked = False
    point.delete()


def test_a_range_without_effect_is_a_warning():
    image = np.full((24, 24, 24), 20, np.int16)
    image[6:18, 6:18, 6:18] = 120
    with Session(Volume(image)) as session:
        mesh = session.add_mesh("cube", centre=(12, 12, 12), radius=4)
        mesh.intensity_range = (-1000, 1000)
        with pytest.warns(simplexseg.DataWarning, match="'cube' contains the whole image and has no effect"):
            session.run(5)
        mesh.intensity_range = (0, 50)
        with pytest.warns(simplexseg.DataWarning, match="excludes most of the seed"):
            session.run(5)


def test_a_model_is_a_path_or_none(session, tmp_path):
    mesh = session.meshes[0]
    assert mesh.model is None
    (tmp_path / "bad.model").write_bytes(b"no model")
    for path, why in ((tmp_path / "bad.model", "damaged"), (tmp_path / "none.model", "none.model")):
        with pytest.raises(Error, match=why):
            mesh.model = path
    assert mesh.model is None
    mesh.model = None


def test_voxels_are_edited_and_frozen(session):
    session.run_until_rest()
    mesh = session.meshes[0]
    before = session.labels().array.astype(bool)
    mesh.edit_voxels("margin", size=3)
    grown = session.labels().array.astype(bool)
    assert grown.sum() > before.sum() and (grown | before == grown).all()
    assert session.undo() and (session.labels().array.astype(bool) == before).all()
    mesh.paint([mesh.mesh.vertices[0]], 4, edit="freeze")
    assert (session.labels().array.astype(bool) == before).all()
    with pytest.raises(Error, match="use one of"):
        mesh.edit_voxels("freeze")
    with Session(Volume(np.zeros((8, 8, 8), np.uint8))) as another:
        stranger = another.add_mesh("stranger", centre=(4, 4, 4), radius=2)
        with pytest.raises(Error, match="another session"):
            mesh.edit_voxels("add", other=stranger)
    centre = np.asarray(mesh.mesh.centroid)
    square = [centre + offset for offset in ((-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0))]
    lasso = mesh.add_lasso(square, normal=(0, 0, 1))
    assert session.undo_title == "add inside lasso"
    assert session.points[-1] == lasso and len(lasso.path) == 4 and lasso.normal == (0, 0, 1)
    lasso.move(np.add(lasso.position, (1, 0, 0)))
    assert np.allclose(lasso.path, np.add(square, (1, 0, 0)))
    with pytest.raises(Error, match="no radius"):
        lasso.resize(2)
    lasso.delete()
    assert lasso not in session.points
    assert session.undo() and session.undo() and np.allclose(session.points[-1].path, square)


def test_a_mesh_starts_from_a_lasso(session):
    circle = [(6 * np.cos(angle), 6 * np.sin(angle), 0) for angle in np.linspace(0, 6, 24)]
    mesh = session.add_mesh_from_lasso(circle, (0, 0, 1), "around")
    assert session.undo_title == "add segmentation" and mesh.name == "around"
    assert [point.kind for point in mesh.points] == ["inside"] and mesh.points[0].normal == (0, 0, 1)
    with pytest.raises(Error, match="three vertices"):
        session.add_mesh_from_lasso(circle[:2], (0, 0, 1))
