# SPDX-License-Identifier: Apache-2.0
"""Episodes from stored sequences (sequences.py): a network receives the field after each mark and corrects it. A batch on a device."""
import pathlib
import queue
import random
import threading
import time

import numpy as np
import torch
from torch.nn import functional

from . import marks
from .grids import grid, per_sample, uniform, without_wait
from .sequences import finished
from .shapes import chosen, log_uniform

MOST_UPDATES = 11
FIELD_LIMIT = 4.0       # of the logit of the field
FINEST = 0.75           # cell of a box, smallest spacing of the volume
FILL = (0.5, 0.8)       # of a box by object and marks, in use
ANY_FILL = (0.25, 1.5)  # in a third of the episodes
OTHER_FILLS = 0.35


def field_channel(probability):
    """Logit of the field, limited and in units of its limit; outside the box of the field its probability is 0."""
    p = probability.clamp(1e-4, 1 - 1e-4)
    return torch.log(p / (1 - p)).clamp(-FIELD_LIMIT, FIELD_LIMIT) / FIELD_LIMIT


class Bank:
    """Sequences on a device, each volume in the corner of a cube of `side` voxels."""

    def __init__(self, side, objects, updates, device):
        cube = (side, side, side)
        self.side, self.device, self.count, self.updates = side, device, 0, 0
        self.image = torch.zeros(objects, *cube, dtype=torch.float16, device=device)
        self.truth = torch.zeros(objects, *cube, dtype=torch.uint8, device=device)
        self.fields = torch.zeros(updates, *cube, dtype=torch.uint8, device=device)
        self.rows = []  # of objects: first update, number of updates, shape, spacing, marks, bounds

    def full(self):
        return self.count == len(self.image) or self.updates + MOST_UPDATES > len(self.fields)

    def add(self, parts):
        shape = parts["image"].shape
        at, first, number = self.count, self.updates, len(parts["fields"])
        a, b, c = shape
        for array, values in ((self.image[at], parts["image"]), (self.truth[at], parts["truth"].astype(np.uint8))):
            array[:a, :b, :c] = torch.from_numpy(values).to(self.device)
        self.fields[first:first + number, :a, :b, :c] = torch.from_numpy(parts["fields"]).to(self.device)
        self.rows.append((first, number, np.array(shape), parts["spacing"].astype(float), parts["marks"].astype(float), parts["bounds"].astype(float)))
        self.count, self.updates = at + 1, first + number


class Reader(threading.Thread):
    """Reads the sequences of a folder while they appear, but those of some kinds."""

    def __init__(self, folder, without):
        super().__init__(daemon=True)
        self.folder, self.without, self.found = pathlib.Path(folder), without, queue.Queue(32)

    def run(self):
        seen = set()
        while True:
            for file in finished(self.folder):
                if file.name in seen:
                    continue
                seen.add(file.name)
                with np.load(file) as stored:
                    parts = {name: stored[name] for name in stored.files}
                if str(parts["kind"]) not in self.without:
                    self.found.put(parts)
            time.sleep(1)

    def fill(self, bank, most):
        """Adds at most this many sequences to a bank."""
        for _ in range(most):
            if bank.full() or self.found.empty():
                break
            bank.add(self.found.get())


def directions(batch):
    """Orientations (batch, 3, 3): permuted and mirrored axes, in half of them turned by up to 30 degrees."""
    out = np.empty((batch, 3, 3))
    for one in out:
        one[:] = np.eye(3)[np.random.permutation(3)] * np.random.choice([-1, 1], 3)[:, None]
        if random.random() < 0.5:
            axis = np.random.normal(size=3)
            x, y, z = axis / np.linalg.norm(axis)
            k, angle = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), random.uniform(0, np.pi / 6)
            one[:] = (np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k) @ one
    return out


class CorrectedEpisodes:
    """Batch of sequences in different states, of several banks; `counts`: number of slots of each bank."""

    def __init__(self, n, banks, counts, device):
        self.n, self.banks, self.counts, self.device, self.batch = n, banks, counts, device, sum(counts)
        self.bank_of = [k for k, count in enumerate(counts) for _ in range(count)]
        shape = (self.batch, 1, n, n, n)
        self.image, self.inside, self.outside, self.wide_inside, self.wide_outside, self.previous, self.field = (
            torch.zeros(shape, device=device) for _ in range(7))
        self.truth, self.valid = (torch.zeros(shape, dtype=torch.bool, device=device) for _ in range(2))
        self.place = torch.zeros(self.batch, n, n, n, 3, device=device)  # in the cube of the bank, -1 to 1
        self.object, self.update, self.last = [0] * self.batch, [0] * self.batch, [0] * self.batch
        self.axes = np.zeros((self.batch, 3, 3))  # of a box: directions in its rows, unit cell
        self.centre, self.cell = np.zeros((self.batch, 3)), np.ones(self.batch)
        self.renew(list(range(self.batch)))
        for slot in range(self.batch):  # episodes end at different times
            self.last[slot] = random.randint(0, self.last[slot])
        self.set_state()

    @property
    def clicks(self):
        return self.update

    def sent(self, values, kind=np.float32):
        return without_wait(torch.from_numpy(np.array(values, kind)), self.device)

    def row(self, slot):
        return self.banks[self.bank_of[slot]].rows[self.object[slot]]

    def renew(self, slots):
        """Other objects in new boxes, before their first mark."""
        turns = directions(len(slots))
        rows, shapes = [], []
        for slot, turn in zip(slots, turns):
            bank = self.banks[self.bank_of[slot]]
            self.object[slot], self.update[slot] = random.randrange(bank.count), 0
            _, number, shape, spacing, places, bounds = self.row(slot)
            self.last[slot] = number - 1
            at = random.randrange(number)
            low, high = bounds[at] * spacing
            extent = max((high - low).max(), 4 * spacing.min())
            centre = (low + high) / 2
            if random.random() < OTHER_FILLS:
                fill = ANY_FILL[0] * (ANY_FILL[1] / ANY_FILL[0]) ** random.random()
                if fill > FILL[1]:
                    centre = places[random.randrange(number), 1:4] * spacing
            else:
                fill = random.uniform(*FILL)
            cell = max(FINEST * spacing.min(), extent / (fill * self.n)) * random.uniform(0.95, 1.1)
            self.axes[slot], self.cell[slot] = turn, cell
            self.centre[slot] = centre + np.random.uniform(-0.08, 0.08, 3) * min(extent, self.n * cell)
            rows.append(np.c_[turn * cell / spacing[:, None], self.centre[slot] / spacing])
            shapes.append(shape)
        device, n = self.device, self.n
        which = self.sent(slots, np.int64)
        rows, shapes = self.sent(rows), self.sent(shapes)
        index = torch.einsum("bik,kxyz->bxyzi", rows[:, :, :3], grid(n, device)) + rows[:, None, None, None, :, 3]
        valid = ((index > -0.5) & (index < shapes[:, None, None, None] - 0.5)).all(-1)[:, None]
        side = self.sent([self.banks[self.bank_of[slot]].side for slot in slots]).view(-1, 1, 1, 1, 1)
        place = 2 * torch.minimum(index.clamp(min=0), shapes[:, None, None, None] - 1) / (side - 1) - 1
        self.place[which], self.valid[which] = place.flip(-1), valid
        count = len(slots)
        image = self.sampled(slots, "image", self.object.__getitem__)
        power, sign = per_sample(log_uniform(0.6, 1.6, (count,), device)), per_sample(1 - 2 * chosen(0.3, (count,), device).float())
        image = sign * ((image + 0.5).clamp(0, 2) / 2) ** power
        level = per_sample(uniform(0, 0.04, (count,), device) * chosen(0.4, (count,), device))
        self.image[which] = marks.normalised(image + level * torch.randn_like(image), valid)
        self.truth[which] = (self.sampled(slots, "truth", self.object.__getitem__) > 0.5) & valid
        for state in (self.inside, self.outside, self.wide_inside, self.wide_outside, self.previous):
            state[which] = 0

    def sampled(self, slots, name, number):
        """Values (slots, 1, n, n, n) of the cubes `name` of the banks in the boxes of slots; number: of the cube of a slot."""
        parts, begin = [], 0
        for k, bank in enumerate(self.banks):
            own = [slot for slot in slots if self.bank_of[slot] == k]
            if not own:
                continue
            assert own == slots[begin:begin + len(own)]
            cubes = getattr(bank, name)[self.sent([number(slot) for slot in own], np.int64)][:, None].float()
            parts.append(functional.grid_sample(cubes, self.place[self.sent(own, np.int64)], padding_mode="border", align_corners=True))
            begin += len(own)
        return torch.cat(parts)

    def set_state(self):
        """The newest mark of each slot, and the field after it."""
        n, newest = self.n, []
        for slot in range(self.batch):
            _, _, _, spacing, places, _ = self.row(slot)
            inside, *index, radius = places[self.update[slot]]
            at = self.axes[slot].T @ (np.array(index) * spacing - self.centre[slot]) / self.cell[slot]
            newest.append([inside, *(at + (n - 1) / 2), max(radius / self.cell[slot], 0.8)])
        newest = self.sent(newest)
        centred = (newest[:, 1:4] - (n - 1) / 2).view(-1, 3, 1, 1, 1)
        distance = (grid(n, self.device)[None] - centred).pow(2).sum(1, keepdim=True).sqrt()
        radius, inside = per_sample(newest[:, 4]), per_sample(newest[:, 0] > 0.5)
        ball, wide = marks.ball(distance, radius), marks.wide(distance, radius)
        none = torch.zeros_like(ball)
        self.inside = torch.where(inside, torch.maximum(self.inside, ball), self.inside * (1 - ball))
        self.outside = torch.where(inside, self.outside * (1 - ball), torch.maximum(self.outside, ball))
        self.wide_inside = torch.maximum(self.wide_inside, torch.where(inside, wide, none))
        self.wide_outside = torch.maximum(self.wide_outside, torch.where(inside, none, wide))
        self.field = self.sampled(list(range(self.batch)), "fields", lambda slot: self.row(slot)[0] + self.update[slot]) / 255 * self.valid

    def channels(self):
        usual = marks.channels(self.image, self.valid, self.inside, self.outside, self.wide_inside, self.wide_outside, self.previous)
        return torch.cat([usual, field_channel(self.field)], 1)

    def dice_of_field(self):
        """Dice of the field in each box."""
        now, truth = (self.field > 0.5).flatten(1), self.truth.flatten(1)
        return 2 * (now & truth).sum(1) / (now.sum(1) + truth.sum(1)).clamp(min=1)

    @torch.no_grad()
    def click(self, probability):
        """The next mark of each sequence; other objects for sequences that ended."""
        self.previous = probability * self.valid
        ended = [slot for slot in range(self.batch) if self.update[slot] >= self.last[slot]]
        for slot in range(self.batch):
            self.update[slot] += 1
        if ended:
            self.renew(ended)
        self.set_state()
