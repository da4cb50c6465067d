# SPDX-License-Identifier: Apache-2.0
"""Fixtures of the tests of the Python module. ctest sets PYTHONPATH, SIMPLEXSEG_CLI and SIMPLEXSEG_BUILD."""

import os
import pathlib
import subprocess

import numpy as np
import pytest

import simplexseg

SOURCE = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def cli():
    """Function that runs simplexseg-cli, expects success and returns its output."""
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
    """Folder of real images."""
    folder = os.environ.get("SIMPLEXSEG_DATA")
    if not folder:
        pytest.skip("SIMPLEXSEG_DATA names no folder of real images")
    return pathlib.Path(folder)


@pytest.fixture(scope="session")
def phantom():
    """Volume of 24^3 voxels of 2 mm with a sphere, and its truth."""
    return simplexseg.make_phantom("sphere", size=24, spacing=2, noise=5)


@pytest.fixture
def session(phantom):
    """Session with one small mesh near the centre of the sphere; it settles quickly."""
    settings = {"simulation.start_vertices": 80, "simulation.final_vertices": 320, "simulation.steps_per_level": 20}
    with simplexseg.Session(phantom[0], backend="cpu", settings=settings) as opened:
        opened.add_mesh("ball", centre=(1, 0, 0), radius=9)
        yield opened


@pytest.fixture
def ramp():
    """Volume with distinct voxels on an oblique, left-handed grid with unequal spacing."""
    angle = 0.3
    direction = np.array([[np.cos(angle), np.sin(angle), 0], [np.sin(angle), -np.cos(angle), 0], [0, 0, 1]])
    voxels = np.arange(4 * 5 * 6, dtype=np.int16).reshape(4, 5, 6)
    return simplexseg.Volume(voxels, spacing=(0.5, 1, 2.5), origin=(10, -20, 30), direction=direction)
