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
from unittest import mock

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
from prior3d import checkpoints, corrections, episodes, field, fusion, grids, marks, network, robot, scanner, segmenter, sequences, shapes  # noqa: E402


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


class BallField:
    """Stands in for the process of the field: balls of twice the radius of the inside marks, less the outside marks."""

    def __init__(self, image_file, shape, networks="", threads=1):
        self.shape, self.size, self.first, self.cell = tuple(shape), tuple(shape), np.zeros(3, int), np.ones(3)

    def update(self, marks):
        axes = [np.arange(n).astype(float) for n in self.shape]
        inside, outside = segmenter.balls_of([m._replace(radius=2 * m.radius if m.inside else m.radius) for m in marks], axes, np.ones(3))
        self.probability = np.where(inside & ~outside, 0.9, 0.1).astype(np.float32)
        return self.probability

    def restore(self, probability):
        self.probability = probability
        return True

    def object(self):
        return self.probability > 0.5

    def segment(self, marks):
        self.update(marks)
        return self.object()

    def brush(self, inside, voxel):
        return 1.5

    def close(self):
        pass


def two_balls():
    x, y, z = np.meshgrid(*[np.arange(n) for n in (40, 36, 32)], indexing="ij")
    truth = ((x - 16) ** 2 + (y - 17) ** 2 + (z - 15) ** 2 < 60) | ((x - 23) ** 2 + (y - 18) ** 2 + (z - 15) ** 2 < 30)
    return truth * 1.0 + 0.1 * np.random.default_rng(0).normal(size=truth.shape), truth


class Corrections(unittest.TestCase):
    def setUp(self):
        torch.manual_seed(3), random.seed(3), np.random.seed(3)
        patch = mock.patch.object(field, "Field", BallField)
        patch.start()
        self.addCleanup(patch.stop)

    def parts(self):
        image, truth = two_balls()
        with tempfile.TemporaryDirectory() as folder:
            return sequences.sequence(image, truth, np.ones(3), "", 64, np.random.default_rng(5), folder)

    def test_sequence_has_the_marks_and_the_field_after_each(self):
        parts = self.parts()
        self.assertGreater(len(parts["fields"]), 1)
        self.assertEqual(len(parts["fields"]), len(parts["marks"]))
        for inside, *place, _ in parts["marks"]:
            self.assertEqual(parts["truth"][tuple(np.round(place).astype(int))], bool(inside))
        self.assertEqual(len(np.unique(parts["fields"])), 2)
        self.assertTrue((parts["fields"][0] > 127).any())

    def test_small_objects_and_stored_size(self):
        image, truth = two_balls()
        with tempfile.TemporaryDirectory() as folder:
            none = sequences.sequence(image, truth & (np.arange(32) == 3), np.ones(3), "", 64, np.random.default_rng(5), folder)
            half = sequences.sequence(image, truth, np.ones(3), "", 20, np.random.default_rng(5), folder)
        self.assertIsNone(none)
        self.assertLessEqual(max(half["image"].shape), 20)
        self.assertGreater(half["spacing"].max(), 1)
        at = tuple(np.round(half["marks"][0][1:4]).astype(int))
        self.assertTrue(half["truth"][at])

    def test_episodes_show_marks_and_field_in_their_boxes(self):
        parts = self.parts()
        bank = corrections.Bank(64, 1, len(parts["fields"]) + corrections.MOST_UPDATES, "cpu")
        bank.add(parts)
        pool = corrections.CorrectedEpisodes(32, [bank], [8], "cpu")
        for _ in range(4):
            for slot in range(8):
                now, truth = parts["fields"][pool.update[slot]] > 127, parts["truth"]
                whole = 2 * (now & truth).sum() / (now.sum() + truth.sum())
                if pool.cell[slot] * 32 > 40:  # the box contains the object
                    self.assertAlmostEqual(float(pool.dice_of_field()[slot]), whole, delta=0.08)
            marked = (pool.inside > 0.9) & pool.valid
            self.assertGreater(float((marked & pool.truth).sum() / marked.sum()), 0.75)
            self.assertEqual(pool.channels().shape, (8, network.CHANNELS + 1, 32, 32, 32))
            pool.click(pool.field)

    def test_network_of_nine_channels_starts_as_that_of_eight_and_the_field(self):
        model = network.Network().eval()
        wider = network.network_of(model.state_dict(), network.CHANNELS + 1).eval()
        x = torch.randn(1, network.CHANNELS + 1, 16, 16, 16)
        with torch.no_grad():
            torch.testing.assert_close(wider(x), model(x[:, :-1]) + network.FIELD_SHARE * x[:, -1:])


class Constant(torch.nn.Module):
    """Network that adds the same correction everywhere."""

    def __init__(self, correction):
        super().__init__()
        self.correction, self.share = correction, torch.nn.Parameter(torch.ones(1))

    def forward(self, x):
        return self.share * x[:, network.CHANNELS:] + self.correction


class CorrectedObjects(unittest.TestCase):
    def setUp(self):
        self.image, self.truth = two_balls()
        self.marks = [robot.seed_of(self.truth, np.ones(3)), robot.Mark(False, np.array([11, 17, 15]), 2.0), robot.Mark(True, np.array([22, 18, 15]), 1.5)]

    def subject(self, correction, **options):
        process = BallField("", self.image.shape)
        return process, fusion.CorrectedObject(process, segmenter.NetworkObject(Constant(correction), self.image, np.ones(3)), **options)

    def test_without_corrections_the_object_is_that_of_the_field(self):
        for near in (0, 3):
            process, subject = self.subject(0.0, near=near)
            for count in range(1, 4):
                before = BallField("", self.image.shape)
                before.update(self.marks[:count])
                mask = subject.segment(self.marks[:count])
                np.testing.assert_array_equal(mask, before.object())
                np.testing.assert_array_equal(process.object(), before.object())  # also the field that received the result

    def test_corrections_move_the_object_and_later_ones_only_near_the_mark(self):
        field_alone, _ = self.subject(0.0)
        for near in (0, 2):
            process, subject = self.subject(-6.0, share=0.5, near=near)
            self.assertLess(subject.segment(self.marks[:1]).sum(), 0.5 * (field_alone.update(self.marks[:1]) > 0.5).sum())
            mask = subject.segment(self.marks[:2])
            alone = field_alone.update(self.marks[:2]) > 0.5
            far = np.sqrt(((np.argwhere(alone) - self.marks[1].index) ** 2).sum(1)) > 16
            share = mask[alone][far].mean()
            self.assertTrue(share < 0.5 if near == 0 else share > 0.99, (near, share))
            if near:
                self.assertGreater(process.object()[mask].mean(), 0.95)  # without filled holes
            else:
                np.testing.assert_array_equal(process.object(), alone)


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

    def test_training_continues_with_sequences(self):
        image, truth = two_balls()
        with tempfile.TemporaryDirectory() as folder:
            sequenced = Path(folder) / "sequences" / "synthetic"
            sequenced.mkdir(parents=True)
            with mock.patch.object(field, "Field", BallField):
                parts = sequences.sequence(image, truth, np.ones(3), "", 64, np.random.default_rng(5), folder)
            for number in range(2):
                sequences.save(sequenced / f"{number}.npz", {**parts, "kind": "synthetic", "group": "synthetic"})
            out = Path(folder) / "net"
            self.run_training(out, "--seconds", "1000000", "--steps", "8", "--sizes", "16", "--batches", "2", "--log-every", "1", "--sequences",
                              str(sequenced.parent), "--counts", "2,0", "--most", "4,0", "--fewest", "2")
            lines = [json.loads(line) for line in Path(f"{out}.jsonl").read_text().splitlines()]
            self.assertEqual(lines[-1]["sequences"], [2])
            self.assertTrue(lines[-1]["field"])
            self.assertEqual(torch.load(f"{out}.weights.pt")["f0.c.weight"].shape[1], network.CHANNELS + 1)

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
