#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""serve_test.py PROGRAM: segmentation by `simplexseg-cli serve` for a client on the loopback: each kind of prompt, and undo."""
from __future__ import annotations

import ctypes
import os
import struct
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
sys.path.insert(0, str(Path(__file__).resolve().parent))
import client as wire  # noqa: E402
from client import Client, Response, pack  # noqa: E402
from serve_case import Image, ServeCase, Target  # noqa: E402
from with_program import main, skip  # noqa: E402


class Prompts(ServeCase):
    """Segmentation by prompts."""

    def point(self, client: Client, at: Any, include: bool = True, **more: Any) -> Response:
        """Sends a point."""
        return client.post("/add_point_interaction", {"coordinates": list(at), "include_interaction": include, **more})

    def test_capabilities(self) -> None:
        """Keys that the Python client of the protocol reads without a default."""
        capabilities = self.server.client().get("/capabilities").json
        for key in ("supported_interactions", "channel_mapping", "num_interaction_channels", "supports_initial_label",
                    "supports_zero_shot_label_refinement", "preferred_scribble_thickness", "interaction_decay",
                    "inference_session_version", "license", "supports_undo", "do_autozoom"):
            self.assertIn(key, capabilities)
        self.assertEqual(len(capabilities["preferred_scribble_thickness"]), 3)
        self.assertFalse(capabilities["supported_interactions"]["bbox3d"])

    def test_points_and_undo(self) -> None:
        """A point segments the object; undo restores the same bits, and the same point then gives the same object."""
        client, target = self.opened()
        self.assertTrue(target.receive(self.point(client, self.centre())))
        self.assertGreater(target.dice(self.truth), 0.9)
        first = bytes(target.voxels)
        outside = [2, 2, 2]
        self.assertTrue(target.receive(self.point(client, outside, False)))
        second = bytes(target.voxels)
        edge = next(self.place(v) for v in sorted(self.truth))
        self.assertTrue(target.receive(self.point(client, edge)))
        third = bytes(target.voxels)
        self.assertTrue(target.receive(client.post("/undo")))
        self.assertEqual(bytes(target.voxels), second)
        self.assertTrue(target.receive(self.point(client, edge)))
        self.assertEqual(bytes(target.voxels), third)
        for expected in (second, first, bytes(len(first))):
            self.assertTrue(target.receive(client.post("/undo")))
            self.assertEqual(bytes(target.voxels), expected)
        self.assertFalse(target.receive(client.post("/undo")))

    def test_reset(self) -> None:
        """After a reset, the same point gives the same object as the first time."""
        client, target = self.opened()
        target.receive(self.point(client, self.centre()))
        first = bytes(target.voxels)
        self.assertEqual(client.post("/reset_interactions").status, 200)
        self.assertFalse(Target(self.image.shape).receive(client.post("/undo")))
        again = Target(self.image.shape)
        again.receive(self.point(client, self.centre()))
        self.assertEqual(bytes(again.voxels), first)

    def test_background_waits_for_an_object(self) -> None:
        """A background point alone gives nothing, and counts as soon as there is an object."""
        client, target = self.opened()
        self.assertTrue(target.receive(self.point(client, [2, 2, 2], False)))
        self.assertEqual(sum(target.voxels), 0)
        self.assertFalse(target.receive(self.point(client, self.centre(), run_prediction=False)))
        self.assertEqual(sum(target.voxels), 0)
        self.assertTrue(target.receive(client.post("/predict")))
        self.assertGreater(target.dice(self.truth), 0.9)
        target.receive(client.post("/undo"))
        self.assertEqual(sum(target.voxels), 0)

    def test_box(self) -> None:
        """A box in each of the three orientations."""
        centre = self.centre()
        for axis in range(3):
            with self.subTest(axis=axis):
                client, target = self.opened()
                places = [p for p in map(self.place, self.truth) if p[axis] == centre[axis]]
                box = [[min(p[a] for p in places), max(p[a] for p in places) + 1] for a in range(3)]
                target.receive(client.post("/add_bbox_interaction", {"bbox_coords": box, "include_interaction": True}))
                self.assertGreater(target.dice(self.truth), 0.85)
                client.post("/release")

    def test_box_after_a_point(self) -> None:
        """Boxes of object and background as corrections."""
        client, target = self.opened()
        target.receive(self.point(client, self.centre()))
        centre = self.centre()
        places = [p for p in map(self.place, self.truth) if p[0] == centre[0]]
        box = [[min(p[a] for p in places), max(p[a] for p in places) + 1] for a in range(3)]
        target.receive(client.post("/add_bbox_interaction", {"bbox_coords": box, "include_interaction": True}))
        self.assertGreater(target.dice(self.truth), 0.9)
        target.receive(client.post("/add_bbox_interaction", {"bbox_coords": [[2, 3], [2, 12], [2, 12]],
                                                             "include_interaction": False}))
        self.assertGreater(target.dice(self.truth), 0.9)
        self.assertTrue(target.receive(client.post("/undo")))

    def test_scribble(self) -> None:
        """A scribble of two voxels, in a part of the image and in an array of its size."""
        centre = self.centre()
        voxels = {(centre[0], centre[1] + dj, centre[2] + di) for dj in range(2) for di in range(-4, 5)}
        array, box = self.drawn(voxels)
        client, target = self.opened()
        target.receive(client.send("/add_scribble_interaction", array, {"include_interaction": True, "interaction_bbox": box}))
        self.assertGreater(target.dice(self.truth), 0.9)
        part = bytes(target.voxels)
        client.post("/release")
        whole = bytearray(self.image.count)
        for k, j, i in voxels:
            whole[target.offset(k, j, i)] = 1
        client, target = self.opened()
        target.receive(client.send("/add_scribble_interaction", pack("uint8", self.image.shape, bytes(whole)),
                                   {"include_interaction": True, "interaction_bbox": None}))
        self.assertEqual(bytes(target.voxels), part)
        target.receive(client.send("/add_scribble_interaction", self.drawn({(2, 2, i) for i in range(2, 12)})[0],
                                   {"include_interaction": False, "interaction_bbox": [[2, 3], [2, 3], [2, 12]]}))
        self.assertGreater(target.dice(self.truth), 0.9)

    def test_lasso(self) -> None:
        """A filled lasso, and its outline of two voxels: both segment the object."""
        centre = self.centre()
        area = {p for p in map(self.place, self.truth) if p[0] == centre[0]}
        inner = {(k, j, i) for k, j, i in area
                 if all((k, j + dj, i + di) in area for dj in range(-2, 3) for di in range(-2, 3))}
        for name, voxels in (("filled", area), ("line", area - inner)):
            with self.subTest(lasso=name):
                array, box = self.drawn(voxels)
                client, target = self.opened()
                target.receive(client.send("/add_lasso_interaction", array, {"include_interaction": True, "interaction_bbox": box}))
                self.assertGreater(target.dice(self.truth), 0.85)
                client.post("/release")

    def test_background_that_encloses_nothing(self) -> None:
        """A lasso of the background that could not be applied later is refused at once, and does not block the object."""
        centre = self.centre()
        client, target = self.opened()
        array, box = self.drawn({(2, 2, 2)})
        self.assert_refused(client.send("/add_lasso_interaction", array, {"include_interaction": False, "interaction_bbox": box}), 400, "lasso")
        target.receive(self.point(client, centre))
        self.assertGreater(target.dice(self.truth), 0.9)

    def test_too_much_background(self) -> None:
        """Prompts that wait are limited, so that they and the first prompt of the object can be undone together."""
        client, target = self.opened()
        accepted = 0
        while (response := self.point(client, [2, 2, 2 + accepted % 40], False, run_prediction=False)).status == 200:
            accepted += 1
            self.assertLess(accepted, 500)
        self.assert_refused(response, 400, "object first")
        self.assertGreater(accepted, 100)
        target.receive(self.point(client, self.centre()))
        self.assertTrue(any(target.voxels))
        target.receive(client.post("/undo"))
        self.assertFalse(any(target.voxels))

    def test_initial_segmentation(self) -> None:
        """An initial segmentation is kept until a prompt changes it, and can be withdrawn."""
        client, target = self.opened()
        mask = bytearray(self.image.count)
        for v in self.truth:
            mask[v] = 1
        self.assertFalse(target.receive(client.send("/add_initial_seg_interaction", pack("uint8", self.image.shape, bytes(mask)))))
        target.voxels[:] = mask
        self.assertTrue(target.receive(self.point(client, [2, 2, 2], False)))
        self.assertGreater(target.dice(self.truth), 0.9)
        self.assertTrue(target.receive(client.post("/undo")))
        self.assertEqual(bytes(target.voxels), bytes(mask))
        self.assertTrue(target.receive(client.post("/undo")))
        self.assertEqual(sum(target.voxels), 0)
        self.assertTrue(target.receive(client.send("/add_initial_seg_interaction", pack("bool", self.image.shape, bytes(mask)),
                                                   {"run_prediction": True})))
        self.assertGreater(target.dice(self.truth), 0.9)

    def test_stored_chunks_and_types(self) -> None:
        """Uncompressed chunks, and other types of voxels, give the same object."""
        client, target = self.opened()
        target.receive(self.point(client, self.centre()))
        expected = bytes(target.voxels)
        values = self.image.values()
        for dtype, code in (("float32", "f"), ("float64", "d"), ("int32", "i"), ("float16", "e")):
            with self.subTest(dtype=dtype):
                data = struct.pack(f"<{len(values)}{code}", *values)
                array = pack(dtype, [1, *self.image.shape], data, chunk=wire.stored_chunk, element=struct.calcsize(code))
                self.assertEqual(client.send("/set_image", array).status, 200)
                target = Target(self.image.shape)
                target.receive(self.point(client, self.centre()))
                self.assertEqual(bytes(target.voxels), expected)

    def test_real_image(self) -> None:
        """A kidney of a CT image: a point, then points in the worst errors."""
        data = os.environ.get("SIMPLEXSEG_DATA")
        if not data or not (Path(data) / "ct_abdomen").exists():
            self.skipTest("SIMPLEXSEG_DATA names no folder with ct_abdomen")
        image = Image(Path(data) / "ct_abdomen/ct.nii.gz")
        truth = {v for v, value in enumerate(Image(Path(data) / "ct_abdomen/labels.nii.gz").values()) if value == 2}
        client = self.claimed()
        self.assertEqual(client.send("/set_image", image.message(), {"image_properties": {"spacing": image.spacing}}).status, 200)
        target = Target(image.shape)

        def deepest(voxels: set[int]) -> list[int]:
            """Voxel that remains longest when the border is removed again and again."""
            steps = (1, -1, image.shape[2], -image.shape[2], image.shape[1] * image.shape[2], -image.shape[1] * image.shape[2])
            while True:
                inner = {v for v in voxels if all(v + step in voxels for step in steps)}
                if not inner:
                    v = min(voxels)
                    return [v // (image.shape[1] * image.shape[2]), v // image.shape[2] % image.shape[1], v % image.shape[2]]
                voxels = inner

        target.receive(self.point(client, deepest(truth)))
        dices = [target.dice(truth)]
        for _ in range(4):
            mine = {v for v, one in enumerate(target.voxels) if one}
            missing, extra = truth - mine, mine - truth
            include = len(missing) >= len(extra)
            target.receive(self.point(client, deepest(missing if include else extra), include))
            dices.append(target.dice(truth))
        print("kidney, Dice after each point:", [round(d, 3) for d in dices], file=sys.stderr)
        self.assertGreater(dices[0], 0.6)
        self.assertGreater(max(dices[1:]), 0.8)


if __name__ == "__main__":
    try:
        ctypes.CDLL(wire.BLOSC)
    except OSError:
        skip("install libblosc1")
    main()
