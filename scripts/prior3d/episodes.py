# SPDX-License-Identifier: Apache-2.0
"""Objects that a robot user marks and corrects while a network learns (docs/clicks.md), a batch at a time on a device."""
import random

import torch
from torch.nn import functional

from . import marks
from .grids import distance_to, largest_component, per_sample, place_of, squared_depth, uniform, without_wait
from .scanner import cut_volume, scanned
from .shapes import chosen, log_uniform, synthetic

SEED_DEPTH, CLICK_DEPTH = 16, 7  # largest depths that are distinguished: cells of half resolution, cells
CLICKS = [0, 1, 1, 2, 2, 3, 3, 4, 5, 6, 8, 10]
FAR = 1e3


def make(batch, n, device, real=None, share=0.0):
    """Normalised images, masks and valid cells; each is real with probability `share`."""
    count = sum(random.random() < share for _ in range(batch)) if real is not None else 0
    parts = []
    if batch > count:
        image, truth = synthetic(batch - count, n, device)
        parts.append((scanned(image), truth, cut_volume(batch - count, n, device)))
    if count:
        image, truth, valid = real.sample(count, n)
        parts.append((scanned(image, 0.6), truth, valid & (cut_volume(count, n, device) | per_sample(chosen(0.7, (count,), device)))))
    image, truth, valid = (torch.cat(part) for part in zip(*parts))
    return marks.normalised(image, valid), truth & valid, valid


class Episodes:
    """Batch of objects in different states of correction. After each click the most advanced `renewed` objects are replaced."""

    def __init__(self, batch, n, renewed, maker, device):
        self.batch, self.n, self.renewed, self.maker, self.device = batch, n, renewed, maker, device
        shape = (batch, 1, n, n, n)
        self.image, self.inside, self.outside, self.wide_inside, self.wide_outside, self.previous = (
            torch.zeros(shape, device=device) for _ in range(6))
        self.truth, self.valid = (torch.zeros(shape, dtype=torch.bool, device=device) for _ in range(2))
        self.voxel = torch.ones(batch, device=device)  # size of a voxel of the volume, cells
        self.clicks, self.limit = [0] * batch, [0] * batch
        for first in range(0, batch, renewed):
            self.renew(range(first, min(first + renewed, batch)), start=True)

    def renew(self, slots, start=False):
        """New objects, each with a seed at its deepest place; a third of the seeds are smaller or off centre."""
        count, device, n = len(slots), self.device, self.n
        at = without_wait(torch.tensor(list(slots)), device)
        image, truth, valid = self.maker(count, n)
        half = truth[..., ::2, ::2, ::2]
        depth = squared_depth(half, SEED_DEPTH).float().flatten(1)
        place = 2 * place_of((depth + 1e-3 * torch.rand_like(depth)).argmax(1), half.shape[-1])
        radius = torch.where(truth, torch.full_like(image, FAR), distance_to(place, n)).flatten(1).min(1).values.clamp(1.0, 0.45 * n) * 0.999
        exact = chosen(0.65, (count,), device)
        radius = torch.where(exact, radius, radius * uniform(0.5, 1.2, (count,), device)).clamp(min=1)
        shift = functional.normalize(torch.randn(count, 3, device=device), dim=1) * (radius * 0.45 * torch.rand(count, device=device))[:, None]
        place = torch.where(exact[:, None], place, place + shift)
        distance, radius = distance_to(place, n), per_sample(radius)
        zero = torch.zeros_like(image)
        for state, value in ((self.image, image), (self.truth, truth), (self.valid, valid), (self.inside, marks.ball(distance, radius)),
                             (self.wide_inside, marks.wide(distance, radius)), (self.outside, zero), (self.wide_outside, zero),
                             (self.previous, zero), (self.voxel, log_uniform(0.3, 1.4, (count,), device))):
            state[at] = value
        for slot in slots:
            self.limit[slot] = random.choice(CLICKS)
            self.clicks[slot] = random.randrange(4) if start else 0

    def channels(self):
        return marks.channels(self.image, self.valid, self.inside, self.outside, self.wide_inside, self.wide_outside, self.previous)

    @torch.no_grad()
    def click(self, probability):
        """One click an object from the probability of the network, then new objects."""
        batch, n, device = self.batch, self.n, self.device
        result = (probability > 0.5) & self.valid
        result = (result | (self.inside > 0.6)) & ~(self.outside > 0.6)
        missing, surplus = self.truth & ~result, result & ~self.truth
        # Largest component of the error, at half resolution, and the deepest cell in it; sometimes any cell of the error.
        both = torch.cat([missing, surplus])
        cells = functional.avg_pool3d(both.float(), 2) * 8
        part, size = largest_component(cells > 0, cells)
        inside = size[:batch] >= size[batch:]
        select = per_sample(inside)
        error = torch.where(select, missing, surplus)
        part = torch.where(select, part[:batch], part[batch:]).repeat_interleave(2, 2).repeat_interleave(2, 3).repeat_interleave(2, 4)
        how = per_sample(torch.rand(batch, device=device))
        target = error & (part | (how > 0.8))
        depth = squared_depth(target, CLICK_DEPTH).float()
        jitter = torch.rand_like(depth)
        score = torch.where(how < 0.93, depth + 0.01 * jitter * target, target * jitter)
        any_error = per_sample(torch.maximum(size[:batch], size[batch:]) > 0)
        distance = distance_to(place_of(score.flatten(1).argmax(1), n), n)
        surface = torch.where(torch.where(select, result, ~result), distance, torch.full_like(distance, FAR)).flatten(1).min(1).values
        radius = per_sample(torch.minimum(torch.maximum(surface, self.voxel), 1.8 * self.voxel).clamp(min=0.8))
        ball, wide = marks.ball(distance, radius), marks.wide(distance, radius)
        added, removed = select & any_error, ~select & any_error
        self.inside, self.outside = (
            torch.where(added, torch.maximum(self.inside, ball), torch.where(removed, self.inside * (1 - ball), self.inside)),
            torch.where(removed, torch.maximum(self.outside, ball), torch.where(added, self.outside * (1 - ball), self.outside)))
        self.wide_inside = torch.where(added, torch.maximum(self.wide_inside, wide), self.wide_inside)
        self.wide_outside = torch.where(removed, torch.maximum(self.wide_outside, wide), self.wide_outside)
        self.previous = probability * self.valid
        self.clicks = [clicks + 1 for clicks in self.clicks]
        order = sorted(range(batch), key=lambda slot: self.limit[slot] - self.clicks[slot] + 0.5 * random.random())
        self.renew(order[:self.renewed])
