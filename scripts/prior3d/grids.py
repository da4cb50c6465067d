# SPDX-License-Identifier: Apache-2.0
"""Arrays of (batch, channel, n, n, n) on a device: random fields, distances, connected components."""
import functools

import torch
from torch.nn import functional


def uniform(low, high, shape, device):
    return low + (high - low) * torch.rand(shape, device=device)


def per_sample(values):
    """(batch,) to (batch, 1, 1, 1, 1)."""
    return values.view(-1, 1, 1, 1, 1)


def without_wait(values, device):
    """Copy on a device. The copy of memory that is not pinned would wait for the work of the device."""
    return values.pin_memory().to(device, non_blocking=True) if torch.device(device).type == "cuda" else values.to(device)


def noise(batch, channels, n, nodes, device):
    """Smooth noise of standard deviation near 1: normal values at nodes^3 places, trilinear between them."""
    values = torch.randn(batch, channels, nodes, nodes, nodes, device=device)
    return functional.interpolate(values, size=(n,) * 3, mode="trilinear", align_corners=True)


@functools.lru_cache(maxsize=None)
def grid(n, device):
    """Cell positions relative to the centre: (3, n, n, n)."""
    t = torch.arange(n, device=device).float() - (n - 1) / 2
    return torch.stack(torch.meshgrid(t, t, t, indexing="ij"))


def place_of(index, n):
    """Cell (batch, 3) of flat indices (batch,)."""
    return torch.stack([index // (n * n), (index // n) % n, index % n], 1).float()


def distance_to(places, n):
    """Distance (batch, 1, n, n, n) of each cell to a place (batch, 3) in cells."""
    centred = (places - (n - 1) / 2).view(-1, 3, 1, 1, 1)
    return (grid(n, places.device)[None] - centred).pow(2).sum(1, keepdim=True).sqrt()


def rotations(batch, device):
    """Random rotations (batch, 3, 3)."""
    q = torch.randn(batch, 4, device=device)
    w, x, y, z = (q / q.norm(dim=1, keepdim=True)).unbind(1)
    rows = [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
            2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]
    return torch.stack(rows, 1).view(batch, 3, 3)


def squared_depth(mask, most):
    """Squared distance of each cell of a mask to the nearest cell outside it, at most most^2. The sides of the array are not outside.

    Exact lower envelope along each axis (Felzenszwalb and Huttenlocher 2012), by comparison with all neighbours up to `most`."""
    kind = torch.float16 if mask.is_cuda else torch.float32
    depth = mask.to(kind) * (most * most)
    for axis in (2, 3, 4):
        size, out = depth.shape[axis], depth.clone()
        for step in range(1, min(most, size - 1) + 1):
            near = size - step
            upper, lower = out.narrow(axis, step, near), out.narrow(axis, 0, near)
            torch.minimum(upper, depth.narrow(axis, 0, near) + step * step, out=upper)
            torch.minimum(lower, depth.narrow(axis, step, near) + step * step, out=lower)
        depth = out
    return depth


def components(mask, rounds=8):
    """6-connected components: (batch, n^3) int64, 0 outside the mask, else a number that the cells of a component share.

    Labels grow to the largest of neighbouring trees, which are then flattened (Shiloach and Vishkin 1982). Long curled components may
    remain in several pieces after a fixed number of rounds."""
    batch, cells = mask.shape[0], mask[0].numel()
    inside = mask.flatten(1)
    labels = torch.arange(1, cells + 1, device=mask.device).expand(batch, cells) * inside
    root = torch.zeros(batch, cells + 1, dtype=torch.long, device=mask.device)  # label of the cell with label l at index l
    root[:, 1:] = labels
    for _ in range(rounds):
        volume = labels.view(mask.shape)
        largest = volume.clone()
        for axis in (2, 3, 4):
            size = volume.shape[axis]
            upper, lower = largest.narrow(axis, 1, size - 1), largest.narrow(axis, 0, size - 1)
            torch.maximum(upper, volume.narrow(axis, 0, size - 1), out=upper)
            torch.maximum(lower, volume.narrow(axis, 1, size - 1), out=lower)
        largest = largest.flatten(1) * inside
        root.scatter_reduce_(1, labels, largest, reduce="amax")
        root[:, 0] = 0
        for _ in range(2):
            root = root.gather(1, root)
        labels = root.gather(1, labels)
    return labels


def largest_component(mask, weight=None):
    """Largest component of each mask by its cells or by the sum of weights: mask of the same shape, and its size (batch,)."""
    labels = components(mask)
    sizes = torch.zeros(mask.shape[0], mask[0].numel() + 1, device=mask.device)
    sizes.scatter_add_(1, labels, (mask.float() if weight is None else weight * mask).flatten(1))
    sizes[:, 0] = 0
    size, label = sizes.max(1)
    return ((labels == label[:, None]) & (size > 0)[:, None]).view(mask.shape), size


def blurred(x, sigma):
    """Gaussian of sigma (batch,) cells, at most 4 cells to each side. x: (batch, 1, n, n, n)."""
    batch = x.shape[0]
    t = torch.arange(-4, 5, device=x.device).float()
    kernel = torch.exp(-t * t / (2 * sigma[:, None].clamp(min=0.05) ** 2))
    kernel = kernel / kernel.sum(1, keepdim=True)
    y = x.transpose(0, 1)
    for axis in range(3):
        shape, pad = [batch, 1, 1, 1, 1], [0] * 6
        shape[2 + axis] = 9
        pad[2 * (2 - axis)] = pad[2 * (2 - axis) + 1] = 4
        y = functional.conv3d(functional.pad(y, pad, mode="replicate"), kernel.view(shape), groups=batch)
    return y.transpose(0, 1)
