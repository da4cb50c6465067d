# SPDX-License-Identifier: Apache-2.0
"""Defects of scanners: shading, blur, thick slices, low resolution, noise, stripes, cut volumes."""
import random

import torch
from torch.nn import functional

from .grids import blurred, grid, noise, per_sample, uniform
from .shapes import chosen


def resampled(image, size):
    low = functional.interpolate(image, size=size, mode="area")
    return functional.interpolate(low, size=image.shape[2:], mode="trilinear", align_corners=False)


def scanned(image, strength=1.0):
    """Image of a scanner; intensities keep their unit. strength: less for images that come from one."""
    device, batch, n = image.device, image.shape[0], image.shape[-1]
    scale = image.flatten(1).std(1) + 1e-6
    image = image * torch.exp(per_sample(uniform(0, 0.35, (batch,), device) * chosen(0.5, (batch,), device)) * noise(batch, 1, n, 3, device))
    level = per_sample((torch.randn(batch, device=device) * 0.35 * strength).abs() * chosen(0.8, (batch,), device) * scale * uniform(0.1, 1, (batch,), device))
    before = per_sample(chosen(0.5, (batch,), device))  # noise before or after blur and resampling
    image = image + before * 1.7 * level * torch.randn_like(image)
    image = blurred(image, torch.where(chosen(0.7, (batch,), device), uniform(0.3, 1.5 * strength, (batch,), device), uniform(0.05, 0.3, (batch,), device)))
    if random.random() < 0.8:  # thick slices, up to 8 times the size of a pixel
        size = [n, n, n]
        size[random.randrange(3)] = max(4, round(n / random.choice([2, 3, 4, 5, 6, 8])))
        image = torch.where(per_sample(chosen(0.4, (batch,), device)), resampled(image, size), image)
    if random.random() < 0.7:
        image = torch.where(per_sample(chosen(0.3, (batch,), device)), resampled(image, [round(n * random.choice([0.4, 0.5, 0.6, 0.75]))] * 3), image)
    rice = per_sample(chosen(0.2, (batch,), device))  # magnitude images
    added = image + ~before * level * torch.randn_like(image)
    second = level * torch.randn_like(image)
    image = torch.where(rice, (added.pow(2) + second.pow(2)).sqrt(), added)
    if random.random() < 0.3:  # slices of unequal brightness
        shape = [batch, 1, 1, 1, 1]
        shape[2 + random.randrange(3)] = n
        image = image + per_sample(scale * uniform(0, 0.25, (batch,), device) * chosen(0.3, (batch,), device)) * torch.randn(shape, device=device)
    return torch.where(per_sample(chosen(0.08, (batch,), device)), -image, image)


def cut_volume(batch, n, device):
    """Cells that lie in the volume; each of its sides may cut the box."""
    valid = torch.ones(batch, 1, n, n, n, dtype=torch.bool, device=device)
    for axis in range(3):
        along = grid(n, device)[axis][None, None]
        limit = per_sample(uniform(0.22, 0.5, (batch,), device) * n)
        sign = per_sample(chosen(0.5, (batch,), device).float() * 2 - 1)
        valid = valid & ((along * sign < limit) | per_sample(chosen(0.82, (batch,), device)))
    return valid
