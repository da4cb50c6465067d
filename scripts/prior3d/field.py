# SPDX-License-Identifier: Apache-2.0
"""Evidence field of the program as a process (tests/benchmarks/field_server)."""
import os
import subprocess

import numpy as np


class Field:
    """Field of one image. Arrays are [i, j, k]."""

    def __init__(self, image_file, shape, networks="", threads=1):
        program = os.environ.get("FIELD_SERVER", "field_server")
        self.shape = tuple(shape)
        self.process = subprocess.Popen([program, str(image_file), str(threads)] + ([str(networks)] if networks else []),
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def send(self, text):
        self.process.stdin.write((text + "\n").encode())
        self.process.stdin.flush()

    def line(self):
        line = self.process.stdout.readline().decode().split()
        if not line:
            raise RuntimeError("the process of the field ended; its message is above")
        return line[1:]

    def read(self, count, kind):
        return np.frombuffer(self.process.stdout.read(count * np.dtype(kind).itemsize), kind, count)

    def update(self, marks):
        """Solves the field: probabilities on its cells, first cell, size of a cell in voxels, expected Dice."""
        self.send(f"update {len(marks)}")
        for mark in marks:
            self.send(" ".join(["inside" if mark.inside else "outside", *(repr(float(x)) for x in mark.index), repr(float(mark.radius))]))
        words = self.line()
        self.first, self.size = np.array(words[:3], int), tuple(int(word) for word in words[3:6])
        self.cell, self.expected = np.array(words[6:9], float), float(words[9])
        self.probability = self.read(int(np.prod(self.size)), "f4").reshape(self.size, order="F")
        return self.probability

    def restore(self, probability):
        """Replaces the field by these probabilities on the same cells."""
        self.process.stdin.write(b"restore\n" + probability.astype("f4").tobytes(order="F"))
        self.process.stdin.flush()
        return self.line() == ["1"]

    def set_prior(self, log_odds, first, step, share):
        """Adds a prior to that of the next updates: log odds of places whose first has the voxel index `first`, `step` voxels apart."""
        numbers = " ".join([*(repr(float(x)) for x in first), *map(str, log_odds.shape), *(repr(float(x)) for x in step), repr(float(share))])
        self.process.stdin.write(f"prior {numbers}\n".encode() + log_odds.astype("f4").tobytes(order="F"))
        self.process.stdin.flush()

    def object(self):
        self.send("object")
        return self.read(int(np.prod(self.shape)), "u1").reshape(self.shape, order="F") != 0

    def brush(self, inside, voxel):
        self.send(" ".join(["brush", "inside" if inside else "outside", *(repr(float(x)) for x in voxel)]))
        return float(self.line()[0])

    def segment(self, marks):
        self.update(marks)
        return self.object()

    def segment_restored(self, marks):
        """Like segment(), but the field is then replaced by its own result, which the next update finds as the previous one."""
        self.restore(self.update(marks))
        return self.object()

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()

    def index_of_cells(self):
        """Voxel index of the centres of the cells along each axis: centre of cell c is (c + 0.5) cell - 0.5."""
        return [(np.arange(first, first + size) + 0.5) * cell - 0.5 for first, size, cell in zip(self.first, self.size, self.cell)]
