# SPDX-License-Identifier: Apache-2.0
"""Robot user `mark` of docs/clicks.md, rules 1 to 5, on the voxels of a volume. A test compares it with simplexseg-cli clicks."""
from typing import NamedTuple

import numpy as np
from scipy import ndimage

SEED_SHARE = 0.999            # of the depth: excludes the voxels at exactly that distance, which are outside
BRUSH, SMALLEST_BRUSH = 1.8, 1.0  # EvidenceSettings::brush, smallest_brush: radius of a mark, cells


class Mark(NamedTuple):
    inside: bool
    index: np.ndarray  # voxel
    radius: float      # mm


def largest_part(mask):
    """Largest 6-connected component (the first of equal ones, i fastest) of a mask, and its number of voxels."""
    labels, count = ndimage.label(mask.T)  # numbered in the order of voxels in memory
    if count == 0:
        return np.zeros_like(mask), 0
    sizes = np.bincount(labels.ravel())
    sizes[0] = 0
    return (labels == sizes.argmax()).T, int(sizes.max())


def deepest_voxel(part, spacing):
    """Voxel of a mask farthest from all others (the first of equal ones), and that distance in mm. The grid's sides are not outside."""
    at = np.argwhere(part)
    low, high = np.maximum(at.min(0) - 1, 0), np.minimum(at.max(0) + 2, part.shape)
    inner = part[tuple(slice(a, b) for a, b in zip(low, high))]
    depth = np.full(inner.shape, np.inf) if inner.all() else ndimage.distance_transform_edt(inner, sampling=spacing)
    depth = np.where(inner, depth, -1).astype(np.float32).T
    at = np.array(np.unravel_index(depth.argmax(), depth.shape))[::-1]
    return at + low, float(depth.T[tuple(at)])


def worst_error(truth, now):
    """Largest component of the missing or of the surplus voxels, and whether they are missing; None without an error."""
    missing, most_missing = largest_part(truth & ~now)
    surplus, most_surplus = largest_part(now & ~truth)
    if most_missing == most_surplus == 0:
        return None
    return (missing, True) if most_missing >= most_surplus else (surplus, False)


def seed_of(truth, spacing):
    voxel, depth = deepest_voxel(truth, spacing)
    return Mark(True, voxel, SEED_SHARE * depth)


def brush_radius(now, inside, voxel, spacing, cell):
    """Radius of a mark: distance to the nearest voxel on the other side of the surface, from 1 to 1.8 cells. cell: smallest side, mm."""
    radius = BRUSH * cell
    low = np.maximum(np.floor(voxel - radius / spacing).astype(int), 0)
    high = np.minimum(np.ceil(voxel + radius / spacing).astype(int) + 1, now.shape)
    near = now[tuple(slice(a, b) for a, b in zip(low, high))]
    axes = [((np.arange(a, b) - v) * s) ** 2 for a, b, v, s in zip(low, high, voxel, spacing)]
    square = axes[0][:, None, None] + axes[1][None, :, None] + axes[2][None, None, :]
    nearest = np.where(near == inside, square, np.inf).min()  # the click is on the wrong side
    return max(min(np.sqrt(nearest), radius), min(SMALLEST_BRUSH * cell, radius))


def dice(a, b):
    total = int(a.sum()) + int(b.sum())
    return 2 * int((a & b).sum()) / total if total else 1.0


def run(truth, spacing, subject, clicks=10):
    """Marks and Dice after each. subject: segment(marks) returns a mask; brush(inside, voxel) the radius of a mark in mm."""
    truth = largest_part(truth)[0]
    low = np.argwhere(truth).min(0)
    high = np.argwhere(truth).max(0) + 1
    marks, scores = [seed_of(truth, spacing)], []
    while True:
        now = subject.segment(marks)
        at = np.argwhere(now)
        if len(at):  # box of all that matters
            low, high = np.minimum(low, at.min(0)), np.maximum(high, at.max(0) + 1)
        first = np.maximum(low - 1, 0)
        box = tuple(slice(a, b) for a, b in zip(first, np.minimum(high + 1, truth.shape)))
        scores.append(dice(truth[box], now[box]))
        error = worst_error(truth[box], now[box])
        if len(marks) > clicks or error is None:
            return marks, scores
        part, inside = error
        voxel = deepest_voxel(part, spacing)[0] + first
        marks.append(Mark(inside, voxel, subject.brush(inside, voxel)))
