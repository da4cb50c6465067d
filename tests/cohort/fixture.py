# SPDX-License-Identifier: Apache-2.0
"""Fixture of the cohort tests: phantoms, their table, and calls of scripts/cohort."""
from __future__ import annotations

import csv
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from with_program import main, program, skip  # noqa: E402

ROOT = Path(__file__).resolve().parent.parent.parent
COHORT = ROOT / "scripts" / "cohort"
SHAPES = ("sphere", "ellipsoid", "cube")
STEPS = 40


class CohortFixture(unittest.TestCase):
    """Three phantoms and a folder for results, deleted after each test."""

    def setUp(self) -> None:
        self.temporary = tempfile.TemporaryDirectory(prefix="simplexseg-cohort-")
        self.folder = Path(self.temporary.name)
        self.out = self.folder / "out"
        self.config = self.folder / "config.yaml"
        self.config.write_text(f"steps: {STEPS}\nsettings: [simulation.final_vertices=320]\n")
        self.rows: list[dict[str, str]] = []
        for shape in SHAPES:
            self.call("phantom", shape, f"{shape}.nii.gz", "--labels", f"{shape}_truth.nii.gz", "--size", "24", "--spacing", "2")
            self.rows.append({"name": shape, "image": f"{shape}.nii.gz", "x": "1", "y": "0", "z": "0", "radius": "8",
                              "reference": f"{shape}_truth.nii.gz"})

    def tearDown(self) -> None:
        self.temporary.cleanup()

    def call(self, *arguments: str) -> str:
        """Runs the program in the folder and returns its output."""
        return subprocess.run([program(), *arguments], cwd=self.folder, capture_output=True, text=True, check=True).stdout

    def write_table(self, rows: list[dict[str, str]]) -> Path:
        """Writes the rows to a table."""
        path = self.folder / "table.csv"
        with open(path, "w", newline="", encoding="utf-8") as file:
            columns = dict.fromkeys(key for row in rows for key in row)
            writer = csv.DictWriter(file, list(columns), restval="")
            writer.writeheader()
            writer.writerows(rows)
        return path

    def command(self, *arguments: str) -> list[str]:
        """Returns the command line of scripts/cohort for the table."""
        return [str(COHORT), str(self.folder / "table.csv"), str(self.out), "--config", str(self.config), *arguments]

    def cohort(self, *arguments: str, environment: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
        """Runs scripts/cohort and waits for its end."""
        given = dict(environment or os.environ)
        given.setdefault("SIMPLEXSEG_CLI", program())
        return subprocess.run(self.command(*arguments), env=given, capture_output=True, text=True, check=False)

    def wrapper(self, body: str) -> str:
        """Writes a script that runs `body`, then the program; "$@" are the arguments of the program."""
        path = self.folder / "wrapper"
        path.write_text(f'#!/bin/bash\n{body}\nexec {program()} "$@"\n')
        path.chmod(0o755)
        return str(path)

    def break_a_volume(self) -> None:
        """Inserts a case with a truncated file into the table."""
        whole = (self.folder / "sphere.nii.gz").read_bytes()
        (self.folder / "broken.nii.gz").write_bytes(whole[: len(whole) // 2])
        self.rows.insert(1, {"name": "broken", "image": "broken.nii.gz", "x": "0", "y": "0", "z": "0", "radius": "8"})

    def assert_labels_of_the_bare_program(self) -> None:
        """Expects that the labels of all phantoms are identical to those of single calls."""
        for shape in SHAPES:
            self.call("segment", f"{shape}.nii.gz", "bare.nii.gz", "--seed", "1,0,0", "--radius", "8", "--steps", str(STEPS),
                      "--set", "simulation.final_vertices=320", "--backend", "cpu")
            self.assertEqual((self.out / "cases" / shape / "labels.nii.gz").read_bytes(),
                             (self.folder / "bare.nii.gz").read_bytes(), shape)
