# SPDX-License-Identifier: Apache-2.0
"""Synthetic volumes: random shapes in random surroundings, made on a device.

An object and four neighbours are skeletons with a radius: chains, tubes, trees, plates, and shells of those, whole or cut open. They are
warped, lobed, cut by other structures, separated by walls or not at all. Every structure receives random intensities."""
import random

import torch
from torch.nn import functional

from .grids import grid, largest_component, noise, per_sample, rotations, uniform

NEIGHBOURS = 4
NODES = 10         # of a skeleton
BACKGROUNDS = 7    # structures behind the objects
THINNEST = 0.9     # radius of a skeleton, cells of half resolution
SMALLEST, LARGEST = 0.12, 1.3  # object to side of the volume


def chosen(share, shape, device):
    return torch.rand(shape, device=device) < share


def log_uniform(low, high, shape, device):
    return low * (high / low) ** torch.rand(shape, device=device)


def extents(batch, device):
    """Extent of the object relative to the side of the volume: half as in use, half over the whole range."""
    return torch.where(chosen(0.5, (batch,), device), uniform(0.4, 1.0, (batch,), device), log_uniform(SMALLEST, LARGEST, (batch,), device))


def skeletons(extent, centre, n):
    """Implicit shapes, negative inside, in radii of the shape: (batch, shapes, n, n, n); and the radius in cells (batch, shapes).

    extent: (batch, shapes) cells; centre: (batch, shapes, 3) cells from the middle."""
    device, (batch, shapes) = extent.device, extent.shape
    style = torch.rand(batch, shapes, device=device)
    tube, tree, plate = style < 0.14, (style >= 0.14) & (style < 0.26), (style >= 0.26) & (style < 0.36)
    radius = extent * (0.05 + 0.45 * torch.rand_like(extent).sqrt())
    radius = torch.where(chosen(0.25, radius.shape, device), extent * uniform(0.08, 0.25, radius.shape, device), radius)
    radius = torch.where(tube | tree, extent * uniform(0.035, 0.12, radius.shape, device), radius)
    radius = radius.clamp(min=THINNEST)
    step = uniform(0.5, 1.2, radius.shape, device) * radius
    step = torch.where(tube | tree, extent * uniform(0.10, 0.22, radius.shape, device), step)
    last = ((extent - 2 * radius) / step).clamp(0, NODES - 1).round()
    last = torch.where(tube | tree, torch.full_like(last, NODES - 1), last)
    curl = torch.where(tube, uniform(0.1, 0.5, radius.shape, device), uniform(0, 0.9, radius.shape, device))[..., None]
    direction = functional.normalize(torch.randn(batch, shapes, 3, device=device), dim=2)
    places, directions, parents = [torch.zeros(batch, shapes, 3, device=device)], [direction], [None]
    for node in range(1, NODES):
        parent = torch.full((batch, shapes), node - 1, device=device)
        parent = torch.where(tree, (torch.rand(batch, shapes, device=device) ** 0.7 * node).long().clamp(max=node - 1), parent)
        at = parent[..., None, None].expand(-1, -1, 1, 3)
        from_place = torch.stack(places, 2).gather(2, at)[:, :, 0]
        direction = torch.stack(directions, 2).gather(2, at)[:, :, 0] + curl * torch.randn(batch, shapes, 3, device=device)
        direction = functional.normalize(direction, dim=2)
        places.append(from_place + direction * step[..., None])
        directions.append(direction)
        parents.append(from_place)
    places = torch.stack(places, 2)
    active = torch.arange(NODES, device=device).view(1, 1, NODES) <= last[..., None]
    middle = (places * active[..., None]).sum(2) / active.sum(2)[..., None]
    shift = (centre - middle)[:, :, None]
    radii = radius[..., None] * torch.exp(0.22 * torch.randn(batch, shapes, NODES, device=device))
    turn = rotations(batch * shapes, device).view(batch, shapes, 3, 3)
    scale = torch.exp(0.3 * torch.randn(batch, shapes, 3, device=device))
    scale[..., 0] = torch.where(plate, torch.minimum(uniform(2.5, 6.0, plate.shape, device), radius / THINNEST), scale[..., 0])  # flat along one axis
    scale = scale / torch.where(plate, torch.ones_like(radius), scale.prod(2) ** (1 / 3))[..., None]
    turn = turn.transpose(2, 3) @ (turn * scale[..., None])
    warp = noise(batch, 3, n, 5, device) * per_sample(uniform(0, 0.10, (batch,), device) * extent[:, 0])
    warp = warp + noise(batch, 3, n, 11, device) * per_sample(uniform(0, 0.03, (batch,), device) * extent[:, 0])
    x = torch.einsum("bjik,bkxyz->bjixyz", turn, grid(n, device)[None] + warp)
    square = chosen(0.2, (batch, shapes, 1, 1, 1), device)
    total = torch.zeros(batch, shapes, n, n, n, device=device)
    for node in range(NODES):
        at = torch.einsum("bjik,bjk->bji", turn, places[:, :, node] + shift[:, :, 0])
        d = x - at[..., None, None, None]
        if node:
            line = torch.einsum("bjik,bjk->bji", turn, parents[node] - places[:, :, node])
            along = (d * line[..., None, None, None]).sum(2) / (line.pow(2).sum(2) + 1e-6)[..., None, None, None]
            d = d - along.clamp(0, 1)[:, :, None] * line[..., None, None, None]
        d = d.pow(2)
        distance = torch.where(square, d.pow(2).sum(2).sqrt(), d.sum(2)).sqrt()
        q = distance / radii[:, :, node, None, None, None] - 1
        total += torch.exp(-6 * q.clamp(-1, 3)) * active[:, :, node, None, None, None]
    return -torch.log(total + 1e-9) / 6, radius


def opened(shape, centre, radius, n):
    """Cuts shapes of (batch, 1, n, n, n) by one plane (bowls, stumps) or two (rings)."""
    device, batch = shape.device, shape.shape[0]
    direction = functional.normalize(torch.randn(batch, 3, device=device), dim=1)
    height = ((grid(n, device)[None] - centre.view(batch, 3, 1, 1, 1)) * direction.view(batch, 3, 1, 1, 1)).sum(1, keepdim=True) / per_sample(radius)
    offset = per_sample(uniform(-0.2, 0.8, (batch,), device))
    one, two = (per_sample(chosen(share, (batch,), device)) for share in (0.5, 0.5))
    cut = torch.maximum(shape, height - offset)
    cut = torch.where(two, torch.maximum(cut, -height - uniform(0.1, 0.8, (batch, 1, 1, 1, 1), device)), cut)
    return torch.where(one, cut, shape)


def synthetic(batch, n, device):
    """Images (batch, 1, n, n, n) in arbitrary units and masks of their objects."""
    half = n // 2
    extent = n * extents(batch, device)
    centre = uniform(-0.13, 0.13, (batch, 3), device) * n
    direction = functional.normalize(torch.randn(batch, NEIGHBOURS, 3, device=device), dim=2)
    others = (extent[:, None] * torch.exp(0.4 * torch.randn(batch, NEIGHBOURS, device=device))).clamp(5, 1.2 * n)
    distance = (extent[:, None] + others) / 2 * uniform(0.35, 1.05, (batch, NEIGHBOURS), device)
    centres = torch.cat([centre[:, None], centre[:, None] + direction * distance[..., None]], 1)
    shape, radius = skeletons(torch.cat([extent[:, None], others], 1) / 2, centres / 2, half)  # at half resolution
    shape = functional.interpolate(shape, size=(n,) * 3, mode="trilinear", align_corners=False)
    radius = 2 * radius
    lobes = [per_sample(uniform(0, most, (batch,), device)) * (radius[:, :1] > 0.12 * extent[:, None]).view(batch, 1, 1, 1, 1).float()
             for most in (0.18, 0.10)]
    shape = shape + noise(batch, 1 + NEIGHBOURS, n, 7, device) * lobes[0] + noise(batch, 1 + NEIGHBOURS, n, 16, device) * lobes[1]
    own_shape, (other_shape, other) = shape[:, :1], shape[:, 1:].min(1, keepdim=True)
    other_shape = torch.where(per_sample(chosen(0.25, (batch,), device)), other_shape + 0.4, other_shape)
    # Shells around a cavity.
    shell = per_sample(chosen(0.16, (batch,), device) & (radius[:, 0] > 4))
    thickness = per_sample(torch.maximum(uniform(0.12, 0.4, (batch,), device), 1.6 / radius[:, 0]))
    cavity = shell & (own_shape < -thickness)
    own_shape = torch.where(shell, torch.maximum(own_shape, -own_shape - thickness), own_shape)
    cut_open = per_sample(chosen(0.5, (batch,), device)) & shell | per_sample(chosen(0.08, (batch,), device))
    own_shape = torch.where(cut_open, opened(own_shape, centre, radius[:, 0], n), own_shape)
    own = (own_shape < 0) & (own_shape <= other_shape)
    gap = per_sample(torch.where(chosen(0.4, (batch,), device), uniform(0, 0.12, (batch,), device), torch.zeros(batch, device=device)))
    wall = (torch.minimum(own_shape, other_shape) < 0.02) & ((own_shape - other_shape).abs() < gap) & (torch.maximum(own_shape, other_shape) < 0.25)
    coarse, fine = random.choice([3, 4, 6, 9, 13]), 2 * random.choice([4, 6, 9])
    background = noise(batch, BACKGROUNDS, n, coarse, device) + uniform(0, 0.6, (batch, 1, 1, 1, 1), device) * noise(batch, BACKGROUNDS, n, fine, device)
    background = background.argmax(1, keepdim=True)
    # Some objects end along another structure.
    cells = noise(batch, 4, n, random.choice([4, 5, 6, 8]), device).argmax(1, keepdim=True)
    at = (centre + (n - 1) / 2).round().long().clamp(0, n - 1)
    here = per_sample(cells[torch.arange(batch, device=device), 0, at[:, 0], at[:, 1], at[:, 2]])
    own = torch.where(per_sample(chosen(0.2, (batch,), device)), own & (cells == here), own) & ~wall
    own = largest_component(own)[0]
    labels = torch.where(other_shape < 0, BACKGROUNDS + other, background)
    wall_label, cavity_label, core = BACKGROUNDS + NEIGHBOURS, BACKGROUNDS + NEIGHBOURS + 1, BACKGROUNDS + NEIGHBOURS + 2
    labels = torch.where(wall, wall_label, labels)
    labels = torch.where(cavity & ~own, cavity_label, labels)
    rim = per_sample(torch.where(chosen(0.25, (batch,), device), uniform(0.08, 0.3, (batch,), device), torch.zeros(batch, device=device)))
    inner = torch.where(own_shape > -rim, core + 1, core)
    spots = (noise(batch, 1, n, random.choice([5, 8, 12]), device) > 1.1) & per_sample(chosen(0.35, (batch,), device))
    labels = torch.where(own, torch.where(spots, core + 2, inner), labels)
    return coloured(labels, core), own


def coloured(labels, core):
    """Intensities of structures. Labels: backgrounds, neighbours, wall, cavity, then core, rim and spots of the object."""
    device, batch, n = labels.device, labels.shape[0], labels.shape[-1]
    count = core + 3
    own = uniform(0.05, 0.95, (batch, 1), device)
    mean = torch.rand(batch, count, device=device)
    alike = own + 0.03 * torch.randn(batch, count, device=device)
    mean = torch.where(torch.rand(batch, count, device=device) < 0.12 * torch.rand(batch, 1, device=device), alike, mean)
    near = slice(BACKGROUNDS, BACKGROUNDS + NEIGHBOURS)
    mean[:, near] = torch.where(chosen(0.45, (batch, 1), device), alike[:, near], mean[:, near])
    mean[:, core] = own[:, 0]
    for part, share, spread in ((core + 1, 0.4, 0.10), (core + 2, 0.3, 0.12)):
        mean[:, part] = torch.where(chosen(share, (batch,), device), mean[:, part], own[:, 0] + spread * torch.randn(batch, device=device))
    contrast = torch.where(chosen(0.35, (batch, 1), device), uniform(0.15, 0.6, (batch, 1), device), torch.ones(batch, 1, device=device))
    mean = own + (mean - own) * contrast
    if random.random() < 0.5:  # air
        mean[:, 0] = torch.where(chosen(0.5, (batch,), device), torch.zeros(batch, device=device), mean[:, 0])
    texture = (0.06 * torch.randn(batch, count, device=device)).abs() * contrast
    flat = labels.flatten(1)
    grain = noise(batch, 1, n, random.choice([9, 15, 24, 32]), device) * per_sample(uniform(0, 1.5, (batch,), device))
    grain = grain + torch.randn(batch, 1, n, n, n, device=device) * per_sample(uniform(0, 1, (batch,), device))
    return mean.gather(1, flat).view(labels.shape) + texture.gather(1, flat).view(labels.shape) * grain
