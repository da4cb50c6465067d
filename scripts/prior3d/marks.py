# SPDX-License-Identifier: Apache-2.0
"""Inputs of the network from image, marks and previous probability. All lengths are in cells."""
import functools

import torch


def ball(distance, radius):
    """Share of a cell in a ball, linear across its surface."""
    return (radius + 0.5 - distance).clamp(0, 1)


def wide(distance, radius):
    """Gaussian around a mark, so that deeper layers receive marks that are smaller than their cells."""
    return torch.exp(-distance * distance / (2 * (2 * radius + 2) ** 2))


@functools.lru_cache(maxsize=None)
def levels(device):
    return torch.tensor([0.01, 0.99], device=device)


def normalised(image, valid):
    """Image with the 1st percentile of its valid cells at 0 and the 99th at 1, limited to -0.25 to 1.25; 0 where it is not valid."""
    batch, cells = image.shape[0], image[0].numel()
    step = max(1, cells // 8192) | 1
    sample = image.flatten(1)[:, ::step].float()
    sample = torch.where(valid.flatten(1)[:, ::step], sample, torch.full_like(sample, float("nan")))
    low, high = torch.nan_to_num(torch.nanquantile(sample, levels(image.device), dim=1)).view(2, batch, 1, 1, 1, 1)
    return torch.where(valid, ((image - low) / (high - low + 1e-6)).clamp(-0.25, 1.25), torch.zeros_like(image))


def channels(image, valid, inside, outside, wide_inside, wide_outside, previous):
    """(batch, 8, n, n, n) from arrays of (batch, 1, n, n, n).

    The second channel is the image relative to mean and standard deviation inside the inside marks."""
    weight = inside * valid
    total = weight.flatten(1).sum(1).clamp(min=1e-3).view(-1, 1, 1, 1, 1)
    mean = (weight * image).flatten(1).sum(1).view(-1, 1, 1, 1, 1) / total
    deviation = ((weight * (image - mean) ** 2).flatten(1).sum(1).view(-1, 1, 1, 1, 1) / total).sqrt()
    relative = ((image - mean) / (2 * deviation + 0.05)).clamp(-3, 3) / 1.5 * valid
    return torch.cat([(image - 0.4) * 2 * valid, relative, inside, outside, wide_inside, wide_outside, previous, valid.to(image.dtype)], 1)
