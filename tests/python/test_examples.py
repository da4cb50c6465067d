# SPDX-License-Identifier: Apache-2.0
"""Runs the examples of README and docs unchanged."""

import pathlib
import re
import subprocess
import sys

import pytest

import simplexseg

SOURCE = pathlib.Path(__file__).resolve().parents[2]


def run(folder, *arguments):
    done = subprocess.run([sys.executable, *map(str, arguments)], capture_output=True, text=True, check=False, cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("document", ["README.md", "docs/python.md"])
def test_the_examples_run_unchanged(tmp_path, document):
    simplexseg.write_volume(tmp_path / "image.nii.gz", simplexseg.make_phantom("sphere", size=24, spacing=2)[0])
    blocks = re.findall(r"```python\n(.*?)```", (SOURCE / document).read_text(), re.S)
    assert blocks
    for number, block in enumerate(blocks):
        (tmp_path / f"example{number}.py").write_text(block)
        run(tmp_path, f"example{number}.py")


def test_the_readme_example_finds_the_object(tmp_path):
    block = re.search(r"```python\n(.*?)```", (SOURCE / "README.md").read_text(), re.S).group(1)
    (tmp_path / "example.py").write_text(block)
    printed = run(tmp_path, "example.py")
    assert float(re.search(r"Dice (0\.\d+)", printed).group(1)) > 0.95
    labels, _ = simplexseg.read_labels(tmp_path / "labels.nii.gz")
    assert labels.array.any()
    assert len(list((tmp_path / "meshes").glob("*.ply"))) == 1


def test_the_script_segments_plots_and_writes(tmp_path):
    script = SOURCE / "docs" / "examples" / "segment_and_plot.py"
    printed = run(tmp_path, script, "--out", tmp_path / "out")
    assert "Dice" in printed
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"labels.nii.gz", "object.ply", "picture.png"} <= names
    image, _ = simplexseg.make_phantom("sphere", size=32)
    simplexseg.write_volume(tmp_path / "v.nii", image)
    run(tmp_path, script, tmp_path / "v.nii", "--centre", 1, 0, 0, "--radius", 5, "--out", tmp_path / "second")
    assert simplexseg.read_labels(tmp_path / "second" / "labels.nii.gz")[0].array.any()
