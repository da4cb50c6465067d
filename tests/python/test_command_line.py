# SPDX-License-Identifier: Apache-2.0
"""Agreement with the command line: equal scenes produce identical files."""

import json

import numpy as np
import pytest

import simplexseg
from simplexseg import Session

SIMULATION = {"start_vertices": 80, "final_vertices": 320, "steps_per_level": 20}


def write_scene(folder, steps, **mesh):
    ball = {"name": "ball", "sphere": {"centre_mm": [1, 0, 0], "radius_mm": 9}, "label": 3, **mesh}
    scene = {
        "simplexseg_scene": 1,
        "volume": "image.nii.gz",
        "simulation": SIMULATION,
        "meshes": [ball, {"name": "knob", "sphere": {"centre_mm": [0, 16, 0], "radius_mm": 4}}],
        "points": [
            {"mesh": "ball", "position_mm": [20, 0, 0]},
            {"mesh": "knob", "position_mm": [0, 18, 0], "kind": "inside"},
        ],
        "steps": steps,
    }
    (folder / "scene.json").write_text(json.dumps(scene))
    return folder / "scene.json"


@pytest.fixture
def folder(tmp_path, cli):
    settings = ("--size", 24, "--spacing", 2, "--noise", 5)
    cli("phantom", "sphere", tmp_path / "image.nii.gz", "--labels", tmp_path / "truth.nii.gz", *settings)
    return tmp_path


def run_by_command(cli, folder, *options):
    out = folder / "by-command"
    files = ("--labels", out.with_suffix(".nii.gz"), "--meshes", out, "--report", out.with_suffix(".json"))
    cli("run", folder / "scene.json", "--backend", "cpu", *files, *options)
    return out


def assert_same_files(session, folder, by_command):
    session.save_labels(folder / "by-python.nii.gz")
    session.save_meshes(folder / "by-python")
    assert (folder / "by-python.nii.gz").read_bytes() == by_command.with_suffix(".nii.gz").read_bytes()
    names = sorted(path.name for path in by_command.iterdir())
    assert names == sorted(path.name for path in (folder / "by-python").iterdir()) and names
    for name in names:
        assert (folder / "by-python" / name).read_bytes() == (by_command / name).read_bytes()


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
@pytest.mark.parametrize("steps, threads", [(90, 1), (90, 2), (0, 0)])
def test_a_scene_produces_the_same_files(cli, folder, steps, threads):
    scene = write_scene(folder, steps)
    by_command = run_by_command(cli, folder)
    with Session(scene, backend="cpu", threads=threads) as session:
        result = session.run()
        assert_same_files(session, folder, by_command)
        assert result.at_rest == json.loads(by_command.with_suffix(".json").read_text())["at_rest"]


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_chunks_of_a_run_and_queries_do_not_change_the_result(cli, folder):
    scene = write_scene(folder, 90)
    by_command = run_by_command(cli, folder)
    with Session(scene, backend="cpu") as session:
        for steps in (1, 2, 7, 30, 50):
            session.run(steps)
            assert len(session.mesh("ball").mesh) and session.labels().array.any()
        assert_same_files(session, folder, by_command)


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_settings_equal_the_option_set(cli, folder):
    scene = write_scene(folder, 60)
    settings = {"forces.smoothing.weight": 2.5, "meshes.ball.gradient.object": "dark", "simulation.damping": 0.5}
    options = [text for name, value in settings.items() for text in ("--set", f"{name}={value}")]
    by_command = run_by_command(cli, folder, *options)
    with Session(scene, backend="cpu", settings=settings) as session:
        session.run()
        assert_same_files(session, folder, by_command)


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_the_command_replays_the_log_of_python(cli, folder):
    scene = write_scene(folder, 0)
    with Session(scene, backend="cpu") as session:
        session.run(25)
        ball = session.mesh("ball")
        point = ball.add_point((0, -18, 3), "outside", radius=3)
        session.run(13)
        point.move((0, -17, 3))
        session.set("forces.smoothing.weight", 1.5)
        session.add_mesh("new", centre=(-4, 0, 8), radius=5, like=ball)
        session.run(40)
        session.undo()
        session.run(11)
        session.save_log(folder / "log.json")
        by_command = run_by_command(cli, folder, "--replay", folder / "log.json")
        assert_same_files(session, folder, by_command)


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_both_continue_a_scene_saved_by_python(cli, folder):
    settings = {f"simulation.{name}": value for name, value in SIMULATION.items()}
    with Session(folder / "image.nii.gz", backend="cpu", settings=settings) as session:
        session.add_mesh("ball", centre=(1, 0, 0), radius=9)
        session.run(30)
        session.save_scene(folder / "scene.json")
    by_command = run_by_command(cli, folder, "--steps", "50")
    with Session(folder / "scene.json", backend="cpu") as session:
        session.run(50)
        assert_same_files(session, folder, by_command)


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_reports_are_equal(cli, folder):
    scene = write_scene(folder, 40, reference={"labels": "truth.nii.gz", "value": 1})
    theirs = json.loads(run_by_command(cli, folder).with_suffix(".json").read_text())
    with Session(scene, backend="cpu") as session:
        session.run()
        session.save_report(folder / "ours.json")
    ours = json.loads((folder / "ours.json").read_text())
    for report in (ours, theirs):
        for key in ("load_ms", "wall_ms", "step_us"):
            assert report.pop(key) > 0
        for mesh in report["meshes"]:
            mesh.pop("trace", None)
    assert ours == theirs and ours["meshes"][0]["dice"] > 0.3


def test_comparing_gives_the_same_numbers(cli, folder):
    write_scene(folder, 30)
    by_command = run_by_command(cli, folder).with_suffix(".nii.gz")
    theirs = json.loads(cli("compare", folder / "truth.nii.gz", by_command, "--json", "--tolerance", 2))
    definitions = theirs.pop("definitions")
    reference, test = (simplexseg.read_labels(path)[0] for path in (folder / "truth.nii.gz", by_command))
    for pair in [(reference, test), (folder / "truth.nii.gz", str(by_command)), (reference, by_command)]:
        assert simplexseg.compare(*pair, tolerance_mm=2) == theirs
    assert simplexseg.metric_definitions() == definitions


def test_parameters_and_phantoms_are_the_same(cli, folder, phantom):
    theirs = json.loads(cli("parameters", "--json"))
    tables = {"simulation": theirs["simulation"]}
    tables |= {f"forces.{force['name']}": force["parameters"] for force in theirs["forces"]}
    ours = simplexseg.parameters()
    assert list(ours) == [f"{table}.{entry['name']}" for table, entries in tables.items() for entry in entries]
    for table, entries in tables.items():
        for entry in entries:
            parameter = ours[f"{table}.{entry.pop('name')}"]
            for key, value in entry.items():
                assert getattr(parameter, key) == value
    np.testing.assert_array_equal(simplexseg.read_volume(folder / "image.nii.gz").array, phantom[0].array)
    np.testing.assert_array_equal(simplexseg.read_labels(folder / "truth.nii.gz")[0].array, phantom[1].array)


def test_a_mesh_of_labels_is_the_same_file(cli, folder):
    cli("mesh", folder / "truth.nii.gz", folder / "theirs.ply", "--vertices", 600)
    labels, _ = simplexseg.read_labels(folder / "truth.nii.gz")
    simplexseg.write_mesh(folder / "ours.ply", simplexseg.mesh_from_labels(labels, vertices=600))
    assert (folder / "ours.ply").read_bytes() == (folder / "theirs.ply").read_bytes()


@pytest.mark.filterwarnings("ignore::simplexseg.DataWarning")
def test_a_hippocampus_produces_the_same_files(cli, data, tmp_path):
    image = sorted((data / "hippocampus" / "images").glob("*.nii*"))[0]
    truth, _ = simplexseg.read_labels(data / "hippocampus" / "labels" / image.name)
    inside = np.argwhere(truth.array > 0)
    middle = inside[np.abs(inside - inside.mean(axis=0)).sum(axis=1).argmin()]
    centre = truth.lps_from_index(middle).tolist()
    sphere = {"name": "hippocampus", "sphere": {"centre_mm": centre, "radius_mm": 4}}
    scene = {"simplexseg_scene": 1, "volume": str(image), "simulation": {"final_vertices": 1280}, "meshes": [sphere]}
    (tmp_path / "scene.json").write_text(json.dumps({**scene, "steps": 150}))
    by_command = run_by_command(cli, tmp_path)
    with Session(tmp_path / "scene.json", backend="cpu") as session:
        session.run()
        assert_same_files(session, tmp_path, by_command)
    with Session(simplexseg.read_volume(image), backend="cpu", settings={"simulation.final_vertices": 1280}) as session:
        session.add_mesh("hippocampus", centre=centre, radius=4)
        session.run(150)
        assert_same_files(session, tmp_path, by_command)
