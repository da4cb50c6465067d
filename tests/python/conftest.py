# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python module share. ctest sets PYTHONPATH, SIMPLEXSEG_CLI and SIMPLEXSEG_BUILD."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import simplexseg

SOURCE = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def cli():
    """Runs simplexseg-cli, which must succeed, and gives what it printed."""
    program = os.environ.get("SIMPLEXSEG_CLI")
    if not program:
        pytest.skip("SIMPLEXSEG_CLI does not name simplexseg-cli")

    def call(*arguments):
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return call


@pytest.fixture(scope="session")
def data():
    """The folder of real images."""
    folder = os.environ.get("SIMPLEXSEG_DATA")
    if not folder:
        pytest.skip("SIMPLEXSEG_DATA names no folder of real images")
    return pathlib.Path(folder)


@pytest.fixture(scope="session")
def phantom():
    """A sphere of 24 voxels a side, 2 mm, and its truth."""
    return simplexseg.make_phantom("sphere", size=24, spacing=2, noise=5)


@pytest.fixture
def session(phantom):
    """One mesh off the middle of the sphere, small enough to rest in a moment."""
    settings = {"simulation.start_vertices": 80, "simulation.final_vertices": 320, "simulation.steps_per_level": 20}
    with simplexseg.Session(phantom[0], backend="cpu", settings=settings) as opened:
        opened.add_mesh("ball", centre=(1, 0, 0), radius=9)
        yield opened


@pytest.fixture
def ramp():
    """Voxels that are all different, on a grid that is oblique, left-handed and of unequal spacing."""
    angle = 0.3
    direction = np.array([[np.cos(angle), np.sin(angle), 0], [np.sin(angle), -np.cos(angle), 0], [0, 0, 1]])
    voxels = np.arange(4 * 5 * 6, dtype=np.int16).reshape(4, 5, 6)
    return simplexseg.Volume(voxels, spacing=(0.5, 1, 2.5), origin=(10, -20, 30), direction=direction)
