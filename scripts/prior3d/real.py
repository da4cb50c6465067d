# SPDX-License-Identifier: Apache-2.0
"""Objects of real volumes, warped, turned and recoloured, on a device."""
import random

import numpy as np
import torch
from torch.nn import functional

from .grids import grid, noise, per_sample, rotations, uniform, without_wait
from .shapes import LARGEST, SMALLEST, chosen
from .volumes import mask_of, read_nifti, training_objects

LEVELS = 4            # resolutions of a volume
FEWEST_VOXELS = 150   # of an object
MOST_LABELS = 256


def pyramid(volume, spacing):
    """Volumes (1, 1, i, j, k) of decreasing resolution with their spacing and the position of their first voxel, mm."""
    spacing, first = np.array(spacing, float), np.zeros(3)
    levels = [(volume, spacing.copy(), first.copy())]
    while len(levels) < LEVELS:
        factor = np.where(spacing < 1.5 * spacing.min(), 2, 1)
        if min(volume.shape[2:] // factor) < 3:
            break
        volume = functional.avg_pool3d(volume, factor.tolist(), factor.tolist(), ceil_mode=True, count_include_pad=False)
        first = first + (factor - 1) / 2 * spacing
        spacing = spacing * factor
        levels.append((volume, spacing.copy(), first.copy()))
    return levels


def level_for(levels, cell):
    """Coarsest level that is as fine as cells of this size (mm)."""
    at = 0
    while at + 1 < len(levels) and levels[at + 1][1].min() <= 1.05 * cell:
        at += 1
    return levels[at]


def sampled(volume, index, mode="bilinear", padding="border"):
    """Values (channels, n, n, n) of a volume (1, channels, i, j, k) at voxel indices (3, n, n, n)."""
    scaled = [2 * x / max(size - 1, 1) - 1 for x, size in zip(index, volume.shape[2:])]
    place = torch.stack(scaled[::-1], -1)[None]
    return functional.grid_sample(volume, place, mode=mode, padding_mode=padding, align_corners=True)[0]


class RealObjects:
    """Objects of training_objects() but those of some kinds."""

    def __init__(self, device, without=()):
        self.device = device
        volumes, self.classes = {}, {}
        for kind, name, image_file, label_file, label in training_objects():
            if kind in without:
                continue
            if image_file not in volumes:
                image, spacing = read_nifti(image_file)
                low, high = np.percentile(image[::2, ::2, ::2], [0.5, 99.5])
                image = np.clip((image - low) / (high - low + 1e-6), -0.2, 1.3).astype(np.float32)
                volumes[image_file] = pyramid(torch.from_numpy(image).to(device)[None, None], spacing), spacing
            if label_file not in volumes:
                labels, _ = read_nifti(label_file)
                labels = labels.astype(np.int16)
                several = torch.from_numpy(labels.astype(np.float32)).to(device)[None, None] if labels.max() > 3 else None
                volumes[label_file] = labels, several
            (levels, spacing), (labels, several) = volumes[image_file], volumes[label_file]
            mask = mask_of(labels, label)
            at = np.argwhere(mask)
            if len(at) < FEWEST_VOXELS:
                continue
            low, high = np.maximum(at.min(0) - 2, 0), np.minimum(at.max(0) + 3, mask.shape)
            crop = mask[tuple(slice(a, b) for a, b in zip(low, high))].astype(np.float32)
            self.classes.setdefault(name, []).append({
                "levels": levels, "labels": several, "spacing": spacing, "extent": float(((high - low - 4).clip(1) * spacing).max()),
                "centre": (at.min(0) + at.max(0)) / 2 * spacing,
                "mask": [(volume, cell, first + low * spacing) for volume, cell, first in pyramid(torch.from_numpy(crop).to(device)[None, None], spacing)]})
        self.names = sorted(self.classes)

    def sample(self, batch, n):
        """Images, masks and valid cells of random objects, of equal share for each class."""
        device = self.device
        turns = rotations(batch, "cpu").numpy()
        warp = noise(batch, 3, n, 5, device) * per_sample(uniform(0, 0.025 * n, (batch,), device) * chosen(0.6, (batch,), device))
        items, rows = [], []
        for turn in turns:
            item = random.choice(self.classes[random.choice(self.names)])
            ratio = random.uniform(0.35, 0.85) if random.random() < 0.5 else SMALLEST * (LARGEST / SMALLEST) ** random.random()
            cell = max(item["extent"] / (ratio * n), item["spacing"].min() * random.uniform(0.5, 1.0)) * random.uniform(0.9, 1.1)
            if random.random() < 0.5:  # along the axes of the volume
                turn = np.eye(3)[np.random.permutation(3)] * np.random.choice([-1, 1], 3)[:, None]
            turn = turn @ np.diag(np.exp(np.random.randn(3) * 0.1)) * cell
            centre = item["centre"] + np.random.uniform(-0.15, 0.15, 3) * min(n * cell, 1.5 * item["extent"])
            image, masks = level_for(item["levels"], cell), level_for(item["mask"], cell)
            items.append((item, image[0], masks[0]))
            rows.append([np.c_[turn / spacing[:, None], (centre - first) / spacing] for _, spacing, first in (image, masks, (None, item["spacing"], 0))])
        rows = without_wait(torch.from_numpy(np.array(rows, np.float32)), device)
        images, truths, valids = [], [], []
        for (item, volume, mask), row, shift in zip(items, rows, warp):
            x = grid(n, device) + shift
            index = torch.einsum("lik,kxyz->lixyz", row[..., :3], x) + row[..., 3].view(3, 3, 1, 1, 1)
            image = sampled(volume, index[0])
            truth = sampled(mask, index[1], padding="zeros") > 0.5
            shape = item["levels"][0][0].shape[2:]
            valids.append(torch.stack([(x > -0.5) & (x < size - 0.5) for x, size in zip(index[2], shape)]).all(0, keepdim=True))
            truths.append(truth)
            images.append(recoloured(image, truth, item["labels"], index[2]))
        images, truths, valids = torch.stack(images), torch.stack(truths), torch.stack(valids)
        return images, truths & valids, valids


def recoloured(image, truth, labels, index):
    """Image with other intensities: a random curve, random intensities of structures, an offset of the object, inverted."""
    device = image.device
    if random.random() < 0.6:
        curve = torch.rand(8, device=device)
        x = ((image + 0.1) / 1.3 * 7).clamp(0, 6.999)
        low = x.long()
        share = random.random() ** 0.5
        image = (1 - share) * image + share * (curve[low] + (curve[low + 1] - curve[low]) * (x - low))
        if labels is not None and random.random() < 0.5:
            here = sampled(labels, index, "nearest").long().clamp(0, MOST_LABELS - 1)
            share = random.uniform(0.4, 1)
            image = torch.where(here > 0, share * torch.rand(MOST_LABELS, device=device)[here] + (1 - share) * image, image)
    if random.random() < 0.3:
        image = image + random.uniform(-0.35, 0.35) * truth
    return -image if random.random() < 0.3 else image
