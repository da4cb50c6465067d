#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""training_test.py SCRIPTS: training of the 3D network on the CPU, with small volumes. Skipped (77) without PyTorch."""
import json
import os
import random
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

SCRIPTS = Path(sys.argv.pop(1)) if len(sys.argv) > 1 else Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
sys.dont_write_bytecode = True
try:
    import numpy as np
    import torch
    from scipy import ndimage
except ImportError as error:
    print(f"training_test: {error}; install python3-torch and python3-scipy", file=sys.stderr)
    sys.exit(77)
from prior3d import checkpoints, episodes, grids, marks, network, scanner, shapes  # noqa: E402


def random_masks(count, n):
    return torch.rand(count, 1, n, n, n) < torch.tensor([0.2, 0.35, 0.6]).repeat(count)[:count].view(-1, 1, 1, 1, 1)


class Grids(unittest.TestCase):
    def setUp(self):
        torch.manual_seed(1), random.seed(1), np.random.seed(1)

    def test_largest_component_is_that_of_scipy(self):
        masks = random_masks(6, 12)
        part, size = grids.largest_component(masks)
        for mask, own, voxels in zip(masks[:, 0].numpy(), part[:, 0].numpy(), size.numpy()):
            labels, _ = ndimage.label(mask)
            sizes = np.bincount(labels.ravel())[1:]
            self.assertEqual(voxels, sizes.max())
            self.assertEqual(own.sum(), sizes.max())
            self.assertEqual(len(np.unique(labels[own])), 1)

    def test_empty_mask_has_no_component(self):
        part, size = grids.largest_component(torch.zeros(2, 1, 8, 8, 8, dtype=torch.bool))
        self.assertFalse(part.any())
        self.assertEqual(size.tolist(), [0, 0])

    def test_depth_is_that_of_scipy(self):
        masks = random_masks(3, 14)
        masks[:, :, 0, 0, 0] = False
        for mask, depth in zip(masks[:, 0].numpy(), grids.squared_depth(masks, 5)[:, 0].numpy()):
            expected = np.minimum(ndimage.distance_transform_edt(mask) ** 2, 25)
            np.testing.assert_allclose(depth, expected, atol=1e-3)


class Volumes(unittest.TestCase):
    def setUp(self):
        torch.manual_seed(2), random.seed(2), np.random.seed(2)

    def test_objects_are_connected_and_of_many_sizes(self):
        sizes = []
        for _ in range(4):
            image, truth = shapes.synthetic(6, 32, "cpu")
            self.assertTrue(torch.isfinite(image).all())
            for mask in truth[:, 0].numpy():
                sizes.append(int(mask.sum()))
                self.assertLessEqual(ndimage.label(mask)[1], 1)
        self.assertGreater(np.percentile(sizes, 90), 10 * max(np.percentile(sizes, 10), 1))

    def test_scanner_keeps_scale_and_normalised_images_their_range(self):
        image = torch.rand(4, 1, 32, 32, 32)
        spoilt = scanner.scanned(image)
        self.assertTrue(torch.isfinite(spoilt).all())
        valid = scanner.cut_volume(4, 32, "cpu")
        normal = marks.normalised(spoilt, valid)
        self.assertLessEqual(normal.abs().max(), 1.25)
        self.assertEqual(normal[~valid].abs().sum(), 0)

    def test_clicks_reduce_the_error_they_are_made_for(self):
        pool = episodes.Episodes(4, 32, 1, lambda count, n: episodes.make(count, n, "cpu"), "cpu")
        pool.renew = lambda slots, start=False: None
        nothing = torch.zeros_like(pool.image)
        pool.inside.zero_()
        pool.click(nothing)
        for truth, inside, outside in zip(pool.truth, pool.inside, pool.outside):
            self.assertEqual(outside.sum(), 0)
            if truth.sum() > 0:
                self.assertTrue((truth & (inside > 0.5)).any())  # a missing object gets an inside mark
        pool.outside.zero_(), pool.inside.zero_()
        pool.click(torch.ones_like(pool.image))
        for truth, valid, inside, outside in zip(pool.truth, pool.valid, pool.inside, pool.outside):
            self.assertEqual(inside.sum(), 0)
            self.assertTrue((valid & ~truth & (outside > 0.5)).any())


class Training(unittest.TestCase):
    def run_training(self, out, *further):
        command = [str(SCRIPTS / "train_prior3d"), str(out), "--seconds", "1", "--sizes", "16,32", "--batches", "2,1", "--device", "cpu",
                   "--log-every", "5", *further]
        environment = {**os.environ, "PYTHON": sys.executable, "OMP_NUM_THREADS": "1"}
        subprocess.run(command, check=True, env=environment, stdout=subprocess.DEVNULL)

    def test_training_resumes_from_its_parts(self):
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "net"
            self.run_training(out)
            first = torch.load(f"{out}.pt")
            self.assertEqual(first["step"], 10)
            lines = [json.loads(line) for line in Path(f"{out}.jsonl").read_text().splitlines()]
            self.assertEqual([line["step"] for line in lines], [5, 10])
            self.assertTrue(all(0 < line["loss"] < 10 for line in lines))
            checkpoints.pack(str(out))
            os.remove(f"{out}.pt")
            checkpoints.unpack(str(out))
            again = torch.load(f"{out}.pt")
            for name, value in first["network"].items():
                torch.testing.assert_close(again["network"][name].double(), value.double(), rtol=1e-3, atol=1e-6)
            self.run_training(out, "--resume", "--seconds", "1000000", "--steps", "13")
            second = torch.load(f"{out}.pt")
            self.assertEqual((second["step"], second["stage"]), (13, 1))
            moved = max((second["network"][name] - value).abs().max() for name, value in again["network"].items() if value.is_floating_point())
            self.assertGreater(moved, 0)
            self.assertEqual(int(second["optimizer"]["state"][0]["step"]), 13)

    def test_stored_weights_keep_large_running_variances(self):
        model = network.Network()
        with torch.no_grad():
            model.x3.b.running_var.fill_(1e6)  # more than float16 holds
        with tempfile.TemporaryDirectory() as folder:
            torch.save(network.weights_of(model), f"{folder}/w.pt")
            loaded = network.load_network(f"{folder}/w.pt")
            self.assertLess(os.path.getsize(f"{folder}/w.pt"), 6.3e6)
        self.assertEqual(float(loaded.x3.b.running_var.max()), 1e6)
        x = torch.randn(1, network.CHANNELS, 16, 16, 16)
        with torch.no_grad():
            expected, now = model.eval()(x), loaded(x)
        self.assertLess(float((now - expected).norm() / expected.norm()), 2e-3)


if __name__ == "__main__":
    unittest.main()
