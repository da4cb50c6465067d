#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""robot_test.py SCRIPTS CLI FIELD_SERVER: the robot in Python makes the clicks of simplexseg-cli clicks, on three objects.

The volumes are made here: a lobed object beside one that is equally bright, a thin shell, and an object in thick slices."""
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPTS, CLI, SERVER = (Path(sys.argv.pop(1)).resolve() for _ in range(3))
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True
os.environ["FIELD_SERVER"] = str(SERVER)
try:
    import numpy as np
    from scipy import ndimage
except ImportError as error:
    print(f"robot_test: {error}; install python3-scipy", file=sys.stderr)
    sys.exit(77)
from prior3d import field, robot, volumes  # noqa: E402

CLICKS = 6


def objects():
    """Name, image, mask, spacing."""
    generator = np.random.default_rng(3)

    def noisy(image, level):
        return ndimage.gaussian_filter(image + level * generator.normal(size=image.shape), 0.7)

    x, y, z = np.meshgrid(*(np.arange(n) for n in (44, 40, 36)), indexing="ij")
    lobes = ((x - 18) ** 2 + (y - 20) ** 2 + (z - 17) ** 2 < 90) | ((x - 24) ** 2 + (y - 13) ** 2 + (z - 20) ** 2 < 40)
    beside = ((x - 31) ** 2 + (y - 24) ** 2 + (z - 18) ** 2 < 60) & ~lobes
    yield "lobes", noisy(lobes * 1.0 + beside, 0.25), lobes, (1.0, 1.0, 1.0)
    r = np.sqrt((x - 22) ** 2 + (y - 20) ** 2 + (z - 18.0) ** 2)
    shell = (r < 13) & (r > 9.5)
    yield "shell", noisy(shell * 1.0 + 0.5 * (r <= 9.5), 0.2), shell, (0.8, 1.1, 1.0)
    x, y, z = np.meshgrid(*(np.arange(n) for n in (48, 44, 12)), indexing="ij")
    flat = ((x - 22) / 13) ** 2 + ((y - 21) / 9) ** 2 + ((z - 5.5) / 3.2) ** 2 < 1
    yield "thick slices", noisy(flat * 0.6 + 0.4 * (x + y > 60), 0.15), flat, (1.25, 1.25, 7.7)


class Robot(unittest.TestCase):
    def test_clicks_are_those_of_the_program(self):
        for name, image, mask, spacing in objects():
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                image_file, label_file, out = (f"{folder}/{word}" for word in ("image.nii.gz", "labels.nii.gz", "clicks.json"))
                volumes.write_nifti(image_file, image, spacing)
                volumes.write_nifti(label_file, mask, spacing)
                subprocess.run([CLI, "clicks", image_file, label_file, "--max", str(CLICKS), "--json", out], check=True, stdout=subprocess.DEVNULL)
                clicks = json.loads(Path(out).read_text())["cases"][0]["clicks"]
                read, sizes = volumes.read_nifti(image_file)
                np.testing.assert_allclose(sizes, spacing, rtol=1e-6)
                subject = field.Field(image_file, read.shape)
                radii = []

                class Checked:
                    def segment(self, marks):
                        self.mask = subject.segment(marks)
                        return self.mask

                    def brush(self, inside, voxel):
                        radius = subject.brush(inside, voxel)
                        radii.append((robot.brush_radius(self.mask, inside, voxel, sizes, sizes.min()), radius))
                        return radius

                marks, scores = robot.run(mask, sizes, Checked(), CLICKS)
                subject.close()
                self.assertEqual(len(marks), len(clicks))
                self.assertGreater(len(marks), 3)
                for mark, score, click in zip(marks, scores, clicks):
                    self.assertEqual("inside" if mark.inside else "outside", click["kind"])
                    np.testing.assert_allclose(mark.index * sizes * (-1, -1, 1), click["position_mm"], atol=1e-4)
                    self.assertAlmostEqual(mark.radius, click["radius_mm"], places=4)
                    self.assertAlmostEqual(score, click["dice"], places=9)
                for own, program in radii:
                    self.assertAlmostEqual(own, program, places=4)


if __name__ == "__main__":
    unittest.main()
