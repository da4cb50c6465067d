# SPDX-License-Identifier: Apache-2.0
"""Segmentation of a volume by the network: choice of the box, inputs, mask. Positions are voxel index times spacing, mm."""
import contextlib

import numpy as np
import torch
from scipy import ndimage
from torch.nn import functional

from . import marks as channels_of
from . import robot
from .corrections import field_channel
from .grids import grid
from .real import level_for, pyramid, sampled

SMALL, LARGE = 64, 96   # sides of a box, cells
FILL = 0.6              # of the box, by the object
FINEST = 0.75           # cell, smallest spacing of the volume
FIRST_BOX = 12          # side of the first box, radii of the seed
BOXES = 4               # most boxes in one update
OUTSIDE_LOGIT = -12.0   # of cells outside the volume


class NetworkObject:
    """Object of a volume (i, j, k) by the network, from marks. `previous`: probability on the voxels after the last update."""

    def __init__(self, network, image, spacing, device="cpu"):
        self.network, self.device, self.spacing, self.shape = network, device, np.asarray(spacing, float), image.shape
        self.levels = pyramid(torch.from_numpy(np.ascontiguousarray(image, np.float32)).to(device)[None, None], spacing)
        self.previous = self.bounds = None
        self.field = None  # probability of the field on the voxels, for a network that corrects it

    def vector(self, values):
        return torch.tensor(np.asarray(values, np.float32), device=self.device).view(3, 1, 1, 1)

    def logit(self, marks, centre, cell, n):
        """Logit (n, n, n) in the box around a centre."""
        x = grid(n, self.device)
        volume, spacing, first = level_for(self.levels, cell)
        image = sampled(volume, x * self.vector(cell / spacing) + self.vector((centre - first) / spacing))[None]
        index = x * self.vector(cell / self.spacing) + self.vector(centre / self.spacing)
        valid = torch.stack([(a > -0.5) & (a < size - 0.5) for a, size in zip(index, self.shape)]).all(0)[None, None]
        image = channels_of.normalised(image, valid)
        states = [torch.zeros_like(image) for _ in range(4)]  # inside, outside, wide inside, wide outside
        for mark in marks:
            distance = (x - self.vector((mark.index * self.spacing - centre) / cell)).pow(2).sum(0).sqrt()[None, None]
            radius = max(mark.radius / cell, 0.8)
            side = 0 if mark.inside else 1
            ball = channels_of.ball(distance, radius)
            states[side] = torch.maximum(states[side], ball)
            states[1 - side] = states[1 - side] * (1 - ball)
            states[2 + side] = torch.maximum(states[2 + side], channels_of.wide(distance, radius))
        before = torch.zeros_like(image) if self.previous is None else self.in_box(self.previous, index, cell) * valid
        inputs = channels_of.channels(image, valid, *states, before)
        if self.network.share is not None:
            inputs = torch.cat([inputs, field_channel(self.in_box(self.field, index, cell) * valid)], 1)
        inputs = inputs.contiguous(memory_format=torch.channels_last_3d)
        cuda = str(self.device).startswith("cuda")
        with torch.no_grad(), torch.autocast("cuda", dtype=torch.bfloat16) if cuda else contextlib.nullcontext():
            logit = self.network(inputs)
        return torch.where(valid, logit.float(), torch.full_like(image, OUTSIDE_LOGIT))[0, 0]

    def in_box(self, source, index, cell):
        """Probabilities on the voxels at voxel indices (3, n, n, n), mean over cells that are larger than voxels."""
        if cell > 1.6 * self.spacing.min():
            size = [max(1, round(s)) // 2 * 2 + 1 for s in cell / self.spacing]
            source = functional.avg_pool3d(source, size, 1, [s // 2 for s in size], count_include_pad=False)
        return sampled(source, index, padding="zeros")[None]

    def box_for(self, low, high):
        """Centre, cell and side of the box for an object with these bounds (mm)."""
        extent, finest = float((high - low).max()), FINEST * self.spacing.min()
        n = SMALL if extent <= FILL * SMALL * finest else LARGE
        return (low + high) / 2, max(finest, extent / (FILL * n)), n

    def update(self, marks):
        """Logit in the last box, its centre, and its cell (mm)."""
        balls = [(m.index * self.spacing - m.radius, m.index * self.spacing + m.radius) for m in marks]
        ball_low, ball_high = np.min([b[0] for b in balls], 0), np.max([b[1] for b in balls], 0)
        finest = FINEST * self.spacing.min()
        if self.bounds is None:
            centre, cell, n = marks[0].index * self.spacing, max(FIRST_BOX * marks[0].radius / SMALL, finest), SMALL
        else:
            centre, cell, n = self.box_for(np.minimum(ball_low, self.bounds[0]), np.maximum(ball_high, self.bounds[1]))
        for box in range(BOXES):
            logit = self.logit(marks, centre, cell, n)
            if box == BOXES - 1:
                break
            object_low, object_high = self.bounds_of(logit, marks, centre, cell)
            low, high = np.minimum(ball_low, object_low), np.maximum(ball_high, object_high)
            half = (n - 1) / 2 * cell
            volume = (np.array(self.shape) - 1) * self.spacing
            near = ((low - (centre - half) < 0.04 * n * cell) & (centre - half > 0)) | ((centre + half - high < 0.04 * n * cell) & (centre + half < volume))
            first = self.bounds is None
            extent = (high - low).max()
            if near.any():
                cell = max(1.35 * cell, extent / (0.7 * n))
                centre = (low + high) / 2
            elif first and (extent < 0.42 * n * cell and cell > 1.01 * finest or box == 0):
                wanted = self.box_for(low, high)
                if (wanted[2], round(wanted[1], 6)) == (n, round(cell, 6)) and (np.abs(wanted[0] - centre) < 0.12 * n * cell).all():
                    break
                centre, cell, n = wanted
            else:
                break
        return logit, centre, cell

    def bounds_of(self, logit, marks, centre, cell):
        """Bounds (mm) of the cells that are connected to inside marks; of the first mark without any."""
        positive = (logit > 0).cpu().numpy()
        n = positive.shape[0]
        labels, _ = ndimage.label(positive)
        kept = set()
        for mark in marks:
            at = np.clip(np.round((mark.index * self.spacing - centre) / cell + (n - 1) / 2).astype(int), 0, n - 1)
            if mark.inside:
                kept.add(labels[tuple(at)])
        at = np.argwhere(np.isin(labels, list(kept - {0})))
        if not len(at):
            return (marks[0].index * self.spacing,) * 2
        return centre + (at.min(0) - (n - 1) / 2) * cell, centre + (at.max(0) - (n - 1) / 2) * cell

    def at_places(self, logit, centre, cell, axes):
        """Values of a box at places with these coordinates (mm) along the axes; NaN outside the box."""
        n = logit.shape[0]
        index = [torch.from_numpy(((a - centre[i]) / cell + (n - 1) / 2).astype(np.float32)).to(logit.device) for i, a in enumerate(axes)]
        values = sampled(logit[None, None], torch.stack(torch.meshgrid(*index, indexing="ij")))[0]
        for i, along in enumerate(index):
            shape = [1, 1, 1]
            shape[i] = -1
            values = torch.where(((along < 0) | (along > n - 1)).view(shape), torch.full_like(values, float("nan")), values)
        return values

    def segment(self, marks):
        """Mask on the voxels: probability above one half, marks, connected to inside marks, without holes."""
        logit, centre, cell = self.update(marks)
        half = (logit.shape[0] - 1) / 2 * cell
        low = np.maximum(np.ceil((centre - half) / self.spacing), 0).astype(int)
        high = np.minimum(np.floor((centre + half) / self.spacing) + 1, self.shape).astype(int)
        axes = [np.arange(a, b) * s for a, b, s in zip(low, high, self.spacing)]
        probability = torch.sigmoid(torch.nan_to_num(self.at_places(logit, centre, cell, axes), nan=OUTSIDE_LOGIT)).cpu().numpy()
        inside, outside = balls_of(marks, axes, self.spacing)
        kept = connected(((probability > 0.5) | inside) & ~outside, inside, outside)
        box = tuple(slice(a, b) for a, b in zip(low, high))
        mask, values = np.zeros(self.shape, bool), np.zeros(self.shape, np.float32)
        mask[box] = kept
        values[box] = np.where(kept, np.maximum(probability, 0.5), np.where(probability > 0.5, 0, probability))
        self.take(values, mask)
        return mask

    def take(self, probability, mask):
        """Sets the result of an update: the previous probability of the next one, and the bounds of the object."""
        self.previous = torch.from_numpy(probability).to(self.device)[None, None]
        at = np.argwhere(mask)
        self.bounds = (at.min(0) * self.spacing, at.max(0) * self.spacing) if len(at) else None

    def brush(self, inside, voxel):
        return self.radius(inside, voxel)

    def radius(self, inside, voxel):
        return robot.brush_radius(self.previous[0, 0].cpu().numpy() >= 0.5, inside, voxel, self.spacing, self.spacing.min())


def balls_of(marks, axes, spacing):
    """Masks of inside and of outside marks on places with these coordinates (mm); later marks count more. Each has at least one voxel."""
    shape = tuple(len(a) for a in axes)
    inside, outside = np.zeros(shape, bool), np.zeros(shape, bool)
    for mark in marks:
        place = mark.index * spacing
        square = [(a - p) ** 2 for a, p in zip(axes, place)]
        ball = square[0][:, None, None] + square[1][None, :, None] + square[2][None, None, :] <= mark.radius ** 2
        ball[tuple(int(s.argmin()) for s in square)] = True
        here, there = (inside, outside) if mark.inside else (outside, inside)
        here |= ball
        there &= ~ball
    return inside, outside


def connected(mask, inside, outside):
    """Components of a mask that contain inside marks, with their holes filled but those with outside marks."""
    labels, _ = ndimage.label(mask)
    kept = np.isin(labels, np.setdiff1d(labels[inside], [0]))
    sides = outside.copy()
    for axis in range(3):
        for end in (0, -1):
            face = [slice(None)] * 3
            face[axis] = end
            sides[tuple(face)] = True
    labels, _ = ndimage.label(~kept)
    return ~np.isin(labels, np.setdiff1d(labels[sides & ~kept], [0]))
