# SPDX-License-Identifier: Apache-2.0
"""A server of `simplexseg-cli serve`, a phantom, and what a client holds, for tests of the protocol."""
from __future__ import annotations

import gzip
import os
import re
import select
import signal
import struct
import subprocess
import tempfile
import time
import unittest
from pathlib import Path
from typing import Any

from client import Client, Response, pack, unpack
from with_program import program

TYPES = {2: ("uint8", 1), 4: ("int16", 2), 8: ("int32", 4), 16: ("float32", 4), 512: ("uint16", 2)}
TOKEN = "a-token-of-the-tests-1234567890"
SIZE = 48


class Image:
    """Volume of a NIfTI file, as a client has it: axes k, j, i."""

    def __init__(self, path: Path) -> None:
        data = gzip.decompress(path.read_bytes())
        dim = struct.unpack_from("<8h", data, 40)
        self.shape = [dim[3], dim[2], dim[1]]
        self.spacing = list(reversed(struct.unpack_from("<4f", data, 76)[1:]))
        self.dtype, self.element = TYPES[struct.unpack_from("<h", data, 70)[0]]
        self.data = data[int(struct.unpack_from("<f", data, 108)[0]):]

    @property
    def count(self) -> int:
        """Number of voxels."""
        return self.shape[0] * self.shape[1] * self.shape[2]

    def values(self) -> list[int]:
        """Voxels."""
        code = {"uint8": "B", "int16": "h", "int32": "i", "float32": "f", "uint16": "H"}[self.dtype]
        return list(struct.unpack(f"<{self.count}{code}", self.data[:self.count * self.element]))

    def message(self, **options: Any) -> bytes:
        """Array of one channel."""
        return pack(self.dtype, [1, *self.shape], self.data[:self.count * self.element], element=self.element, **options)


class Target:
    """Buffer of a client, into which it writes the parts that it receives."""

    def __init__(self, shape: list[int]) -> None:
        self.shape = shape
        self.voxels = bytearray(shape[0] * shape[1] * shape[2])

    def offset(self, k: int, j: int, i: int) -> int:
        """Offset of a voxel."""
        return (k * self.shape[1] + j) * self.shape[2] + i

    def receive(self, response: Response) -> bool:
        """Applies a response; returns whether a prediction was run."""
        if response.status != 200:
            raise RuntimeError(f"{response.status} {response.body[:300]!r}")
        meta = response.meta
        if meta["bbox"] is not None:
            dtype, shape, data = unpack(response.body)
            (k0, k1), (j0, j1), (i0, i1) = meta["bbox"]
            if dtype != "uint8" or shape != [k1 - k0, j1 - j0, i1 - i0] or shape != meta["shape"]:
                raise RuntimeError(f"{dtype} {shape} {meta}")
            for k in range(k0, k1):
                for j in range(j0, j1):
                    row = ((k - k0) * shape[1] + j - j0) * shape[2]
                    at = self.offset(k, j, i0)
                    self.voxels[at:at + shape[2]] = data[row:row + shape[2]]
        return bool(meta["ran_prediction"])

    def dice(self, truth: set[int]) -> float:
        """Dice coefficient with a set of offsets."""
        mine = {v for v, one in enumerate(self.voxels) if one}
        return 2 * len(mine & truth) / max(1, len(mine) + len(truth))


class Serve:
    """Server with options, on an unused port."""

    def __init__(self, *options: str, token: str | None = TOKEN) -> None:
        environment = {k: v for k, v in os.environ.items() if k != "NN_INTERACTIVE_API_KEY"}
        if token:
            environment["NN_INTERACTIVE_API_KEY"] = token
        self.token = token
        self.process = subprocess.Popen([program(), "serve", "--port", "0", "--backend", "cpu", *options],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
        assert self.process.stdout is not None
        ready, _, _ = select.select([self.process.stdout], [], [], 60)
        line = self.process.stdout.readline() if ready else ""
        found = re.search(r":(\d+), ", line)
        if not found:
            self.process.kill()
            raise RuntimeError("the server does not start: " + line + str(self.process.communicate()))
        self.port = int(found.group(1))

    def client(self, **options: Any) -> Client:
        """Client with the token."""
        return Client(self.port, self.token, **options)

    def end(self, number: int = signal.SIGTERM) -> tuple[float, str, str]:
        """Ends the server; returns the time that it needed, s, and its output."""
        start = time.monotonic()
        self.process.send_signal(number)
        out, err = self.process.communicate(timeout=20)
        return time.monotonic() - start, out, err


def shared(folder: Path) -> tuple[Image, Image]:
    """Phantom and its truth."""
    subprocess.run([program(), "phantom", "two-spheres", str(folder / "image.nii.gz"), "--labels", str(folder / "truth.nii.gz"),
                    "--size", str(SIZE)], check=True, stdout=subprocess.DEVNULL)
    return Image(folder / "image.nii.gz"), Image(folder / "truth.nii.gz")


class ServeCase(unittest.TestCase):
    """A server and a phantom for all tests of a class."""
    options: tuple[str, ...] = ()
    server: Serve
    image: Image
    truth: set[int]
    folder: tempfile.TemporaryDirectory[str]

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        cls.image, labels = shared(Path(cls.folder.name))
        values = labels.values()
        cls.truth = {v for v, value in enumerate(values) if value == 1}
        cls.server = Serve(*cls.options)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.server.process.kill()
        cls.server.process.communicate()
        cls.folder.cleanup()

    def claimed(self) -> Client:
        """Client with the lease, which it releases after the test."""
        client = self.server.client()
        client.claim()
        self.addCleanup(client.post, "/release")
        return client

    def opened(self) -> tuple[Client, Target]:
        """Client with the image."""
        client = self.claimed()
        response = client.send("/set_image", self.image.message(), {"image_properties": {"spacing": self.image.spacing}})
        self.assertEqual(response.status, 200, response.body)
        self.assertEqual(response.json["original_image_shape"], [1, *self.image.shape])
        self.assertEqual(client.post("/set_target_buffer", {"shape": self.image.shape, "dtype": "uint8"}).json, {})
        return client, Target(self.image.shape)

    def centre(self) -> list[int]:
        """Middle of the true object."""
        places = [self.place(v) for v in self.truth]
        return [round(sum(p[a] for p in places) / len(places)) for a in range(3)]

    def place(self, offset: int) -> tuple[int, int, int]:
        """Indices of a voxel."""
        return offset // (self.image.shape[1] * self.image.shape[2]), offset // self.image.shape[2] % self.image.shape[1], \
            offset % self.image.shape[2]

    def drawn(self, voxels: set[tuple[int, int, int]]) -> tuple[bytes, list[list[int]]]:
        """Array with these voxels, and its interaction_bbox."""
        box = [[min(v[a] for v in voxels), max(v[a] for v in voxels) + 1] for a in range(3)]
        shape = [high - low for low, high in box]
        data = bytearray(shape[0] * shape[1] * shape[2])
        for k, j, i in voxels:
            data[((k - box[0][0]) * shape[1] + j - box[1][0]) * shape[2] + i - box[2][0]] = 1
        return pack("uint8", shape, bytes(data)), box

    def assert_refused(self, response: Response, status: int, part: str = "") -> None:
        """Checks a refusal: status, and a detail of one line."""
        self.assertEqual(response.status, status, response.body)
        detail = response.json["detail"]
        self.assertIn(part, detail)
        self.assertNotIn("\n", detail)
        self.assertTrue(detail)
