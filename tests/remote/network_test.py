#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""network_test.py PROGRAM: start from a network on a stand-in server, and one line for every fault of a server."""
from __future__ import annotations

import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "support"))
from with_program import main, program  # noqa: E402

SIZE = (30, 26, 22)           # along i, j, k
SPACING = (2.0, 3.0, 2.5)     # mm
ORIGIN = (40.0, -30.0, 10.0)  # RAS
CENTRE, RADIUS = (17, 11, 9), 14.0


def world(index: tuple[int, ...]) -> tuple[float, ...]:
    """LPS position of a voxel. The axis i of the image points to the left in RAS, k to the front, j to the head."""
    ras = (ORIGIN[0] - SPACING[0] * index[0], ORIGIN[1] + SPACING[2] * index[2], ORIGIN[2] + SPACING[1] * index[1])
    return -ras[0], -ras[1], ras[2]


def is_inside(i: int, j: int, k: int) -> bool:
    """Whether a voxel belongs to the ball."""
    return math.dist(world((i, j, k)), world(CENTRE)) < RADIUS


def write_image(path: Path) -> None:
    """Writes a bright ball as NIfTI, with an invented name in the text fields that must not be sent."""
    head = bytearray(352)
    struct.pack_into("<i", head, 0, 348)
    struct.pack_into("<8h", head, 40, 3, *SIZE, 1, 1, 1, 1)
    struct.pack_into("<hh", head, 70, 4, 16)
    struct.pack_into("<8f", head, 76, 1, *SPACING, 0, 0, 0, 0)
    struct.pack_into("<ff", head, 108, 352, 1)
    head[123] = 2
    head[148:160] = b"Secretperson"
    struct.pack_into("<hh", head, 252, 0, 1)
    struct.pack_into("<12f", head, 280, -SPACING[0], 0, 0, ORIGIN[0], 0, 0, SPACING[2], ORIGIN[1], 0, SPACING[1], 0, ORIGIN[2])
    head[344:348] = b"n+1\0"
    voxels = [1000 if is_inside(i, j, k) else (i * 7 + j * 3 + k) % 20 for k in range(SIZE[2]) for j in range(SIZE[1]) for i in range(SIZE[0])]
    path.write_bytes(bytes(head) + struct.pack(f"<{len(voxels)}h", *voxels))


class NetworkTest(unittest.TestCase):
    """Calls of the program with an image and a stand-in server."""

    def setUp(self) -> None:
        temporary = tempfile.TemporaryDirectory(prefix="simplexseg-network-")
        self.addCleanup(temporary.cleanup)
        self.folder = Path(temporary.name)
        self.image = self.folder / "Secretperson.nii"
        write_image(self.image)
        self.environment = {name: value for name, value in os.environ.items() if name.lower() != "no_proxy"}
        # A proxy must not see what is sent to this machine: this one does not exist.
        self.environment.update(XDG_CONFIG_HOME=str(self.folder / "config"), http_proxy="http://127.0.0.1:9", all_proxy="http://127.0.0.1:9")

    def serve(self, *arguments: str) -> Any:
        from stand_in import StandIn
        server = StandIn(*arguments)
        self.addCleanup(server.stop)
        return server

    def call(self, *arguments: object, status: int = 0, timeout: float = 120) -> Any:
        done = subprocess.run([program(), *map(str, arguments)], capture_output=True, text=True, env=self.environment, timeout=timeout, check=False)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    def segment(self, server: Any, *options: object, status: int = 0) -> Any:
        seed = ",".join(map(str, world(CENTRE)))
        return self.call("segment", self.image, self.folder / "labels.nii", f"--seed={seed}", "--radius", 4, "--name", "ball", "--backend", "cpu",
                         "--network", getattr(server, "url", server), *options, status=status)

    def fault(self, protocol: str, fault: str, *options: object, status: int = 1) -> str:
        """The one line that the program prints for a fault, after its notes."""
        server = self.serve(protocol, fault)
        done = self.segment(server, "--steps", 0, *options, status=status)
        lines = [line for line in done.stderr.splitlines() if not line.startswith("note: ")]
        self.assertEqual(len(lines), 1, done.stderr)
        self.assertFalse((self.folder / "labels.nii").exists())
        return lines[0]

    def dice(self) -> float:
        """Dice coefficient of the labels with the ball."""
        raw = (self.folder / "labels.nii").read_bytes()
        step = struct.unpack_from("<h", raw, 72)[0] // 8
        start = int(struct.unpack_from("<f", raw, 108)[0])
        common = total = 0
        for n, index in enumerate((i, j, k) for k in range(SIZE[2]) for j in range(SIZE[1]) for i in range(SIZE[0])):
            label, ball = raw[start + n * step] != 0, is_inside(*index)
            common, total = common + (label and ball), total + label + ball
        return 2 * common / total

    def meshes(self, folder: str) -> dict[str, bytes]:
        return {file.name: file.read_bytes() for file in (self.folder / folder).iterdir()}


class Sessions(NetworkTest):
    """Complete sessions."""

    def test_mask_is_start_and_prior_and_the_server_is_not_needed_again(self) -> None:
        server = self.serve()
        outside = ",".join(map(str, world((2, 3, 4))))
        done = self.segment(server, "--steps", 0, "--save", self.folder / "start.json", f"--outside={outside}")
        self.assertGreater(self.dice(), 0.95)
        self.assertEqual(server.points, [([4, 3, 2], False), ([CENTRE[2], CENTRE[1], CENTRE[0]], True)])
        self.assertIn(f"note: sends the image (34.3 kB) and 2 points of 'ball' to {server.url} (nnInteractive); licence of its network: "
                      "CC BY-NC-SA 4.0 for tests\n", done.stderr)
        self.assertEqual([path.split()[1] for path in server.paths],
                         ["/healthz", "/capabilities", "/healthz", "/capabilities", "/claim", "/set_image", "/set_target_buffer",
                          "/add_point_interaction", "/add_point_interaction", "/release"])
        for received in server.received:
            self.assertNotIn(b"ecretperson", received)
        server.stop()
        # The work goes on without the server, and each run of the saved scene gives the same bits.
        for folder in "a", "b":
            self.call("run", self.folder / "start.json", "--backend", "cpu", "--steps", 60, "--meshes", self.folder / folder,
                      "--labels", self.folder / "labels.nii", "--save", self.folder / f"{folder}.json")
        self.assertEqual(self.meshes("a"), self.meshes("b"))
        self.assertGreater(self.dice(), 0.95)
        self.call("run", self.folder / "a.json", "--backend", "cpu", "--steps", 10)
        self.call("measure", self.folder / "a.json", self.folder / "report.pdf")
        if shutil.which("pdftotext"):
            report = subprocess.run(["pdftotext", "-layout", self.folder / "report.pdf", "-"], capture_output=True, text=True, check=True).stdout
            for stated in "mask of a network: nnInteractive", server.url, "licence of its weights: CC BY-NC-SA 4.0 for tests":
                self.assertIn(stated, report)

    def draw(self) -> Path:
        """Template scene with a seed in the ball, an inside stroke along j in it, and an outside stroke along i."""
        def stroke(kind: str, at: tuple[int, ...], to: tuple[int, ...]) -> dict[str, Any]:
            start, end = world(at), world(to)
            return {"mesh": "ball", "kind": kind, "position_mm": start, "radius_mm": 2, "path_mm": [[b - a for a, b in zip(start, end)]]}
        scene = {"simplexseg_scene": 1, "volume": str(self.image),
                 "meshes": [{"name": "ball", "sphere": {"centre_mm": world(CENTRE), "radius_mm": 4}}],
                 "points": [stroke("inside", (17, 9, 9), (17, 13, 9)), stroke("outside", (3, 2, 2), (9, 2, 2))]}
        path = self.folder / "strokes.json"
        path.write_text(json.dumps(scene), encoding="utf-8")
        return path

    def test_strokes_are_scribbles_where_the_server_takes_them(self) -> None:
        server = self.serve()
        done = self.segment(server, "--steps", 0, "--scene", self.draw())
        self.assertIn("and 1 point and 2 scribbles of 'ball'", done.stderr)
        self.assertEqual(server.points, [([CENTRE[2], CENTRE[1], CENTRE[0]], True)])
        self.assertEqual([inside for _, _, inside in server.scribbles], [False, True])
        for (box, voxels, _), path in zip(server.scribbles, ([(2, 2, i) for i in range(3, 10)], [(9, j, 17) for j in range(9, 14)])):
            sizes = [high - low for low, high in box]
            drawn = {(box[0][0] + n // (sizes[1] * sizes[2]), box[1][0] + n // sizes[2] % sizes[1], box[2][0] + n % sizes[2])
                     for n, voxel in enumerate(voxels) if voxel}
            self.assertLessEqual(set(path), drawn)
            for voxel in drawn:  # 2 voxels of the smallest spacing thick
                self.assertLessEqual(min(math.dist(world(voxel[::-1]), world(at[::-1])) for at in path), SPACING[0] + 1e-6)
        self.assertEqual(sum(path.endswith("/add_scribble_interaction") for path in server.paths), 2)
        self.assertGreater(self.dice(), 0.95)
        server = self.serve("nninteractive", "no scribbles")
        done = self.segment(server, "--steps", 0, "--scene", self.draw())
        self.assertIn("and 5 points of 'ball'", done.stderr)
        self.assertEqual(server.scribbles, [])

    def test_monai_label(self) -> None:
        server = self.serve("monai")
        done = self.segment(server, "--steps", 0)
        self.assertGreater(self.dice(), 0.95)
        self.assertEqual(server.points, [(list(CENTRE), True)])
        self.assertIn("(MONAI Label); licence of its network: not stated", done.stderr)
        self.assertEqual([path.split("?")[0] for path in server.paths][-3:], ["PUT /session/", "POST /infer/clicks", "DELETE /session/session-1"])
        for received in server.received:
            self.assertNotIn(b"ecretperson", received)

    def test_lost_lease_is_claimed_again(self) -> None:
        server = self.serve("nninteractive", "410 once")
        self.segment(server, "--steps", 0)
        self.assertGreater(self.dice(), 0.95)
        self.assertEqual(sum(path.endswith("/set_image") for path in server.paths), 2)

    def test_heartbeats_during_a_slow_prediction(self) -> None:
        server = self.serve("nninteractive", "slow prediction")
        self.segment(server, "--steps", 0)
        self.assertGreaterEqual(sum(path.endswith("/heartbeat") for path in server.paths), 2)

    def test_blosc_1(self) -> None:
        self.segment(self.serve("nninteractive", "blosc 1"), "--steps", 0)
        self.assertGreater(self.dice(), 0.95)

    def test_token_and_configured_server(self) -> None:
        server = self.serve("nninteractive", "", "sesame")
        self.assertIn("it requires credentials (401", self.segment(server, "--steps", 0, status=1).stderr)
        secret = self.folder / "secret"
        secret.write_text("bearer sesame\n", encoding="utf-8")
        secret.chmod(0o600)
        settings = self.folder / "config" / "simplexseg" / "networks.json"
        settings.parent.mkdir(parents=True)
        settings.write_text(f'{{"simplexseg_networks": 1, "servers": [{{"name": "gpu", "url": "{server.url}", "credentials_file": "{secret}"}}]}}',
                            encoding="utf-8")
        self.segment("gpu", "--steps", 0)
        self.assertGreater(self.dice(), 0.95)
        wrong = self.folder / "wrong"
        wrong.write_text("bearer guess", encoding="utf-8")
        wrong.chmod(0o600)
        message = self.segment("gpu", "--steps", 0, "--credentials-file", wrong, status=1).stderr
        self.assertIn("it rejected the credentials (401", message)
        self.assertNotIn("guess", message)
        self.assertIn("choose one of: gpu", self.segment("other", "--steps", 0, status=2).stderr)

    def test_credentials_are_not_sent_unencrypted(self) -> None:
        for host in "192.0.2.1", "127.example.org", "localhost.example.org", "[2001:db8::1]":
            self.assertIn("http would send its credentials unencrypted",
                          self.segment(f"http://{host}:1527", "--credentials-variable", "HOME", status=2).stderr)

    def test_a_password_in_an_address_is_not_printed(self) -> None:
        for address in "HTTPS://ann:secret@example.org", "http://ann:secret@127.0.0.1:1", "ann:secret@example.org/x", "x//ann:secret@a?b":
            message = self.segment(address, status=2).stderr
            self.assertIn("it contains a user or a password", message)
            self.assertNotIn("secret", message)


class Faults(NetworkTest):
    """One line for each fault."""

    def test_nninteractive(self) -> None:
        for fault, words, status in (
                ("410", "it ended the session three times (410)", 1), ("413", "the image is too large for it (413: image too large)", 1),
                ("503", "all its sessions are in use (503: server is at capacity (1 sessions))", 1), ("500", "it failed (500)", 1),
                ("400", "it rejected the request (400: coordinates are odd)", 1), ("shape", "its mask has not the shape of its region", 1),
                ("outside", "its region lies outside the image", 1), ("damaged", "its response is damaged", 1),
                ("page", "it does not begin with NNIA", 1), ("no meta", "it is not a JSON object", 1),
                ("cut", "the connection ended in the middle of its response", 1), ("no points", "its network does not accept points", 1),
                ("empty", "the mask of the network: it is empty", 2), ("elsewhere", "it does not contain the seed", 2)):
            with self.subTest(fault=fault):
                self.assertIn(words, self.fault("nninteractive", fault, status=status))

    def test_monai_label(self) -> None:
        for fault, words in (
                ("413", "the image is too large for it (413: too large)"), ("406", "it rejected the request (406: Session Feature is Not Enabled)"),
                ("500", "it failed (500: Failed to execute infer)"), ("grid", "its mask has another grid than the image"),
                ("damaged", "its mask cannot be read"), ("cut", "the connection ended in the middle of its response"),
                ("no models", "it has no network")):
            with self.subTest(fault=fault):
                self.assertIn(words, self.fault("monai", fault))
        self.assertIn("it has no network brain; choose one of: clicks, organs", self.fault("monai", "", "--network-name", "brain"))

    def test_timeout(self) -> None:
        for protocol in "nninteractive", "monai":
            self.assertIn("time-out: no data for 1 s", self.fault(protocol, "slow", "--timeout", 1))

    def test_no_server(self) -> None:
        server = self.serve()
        server.stop()
        self.assertIn("it refused the connection", self.segment(server, status=1).stderr)

    def test_another_server(self) -> None:
        server = self.serve("monai")
        self.assertIn("it is neither a server of nnInteractive nor of MONAI Label", self.segment(server.url + "/other", status=1).stderr)


if __name__ == "__main__":
    main(("blosc", "python3-blosc"))
