"""Largest stable step and error of the compact kernel beside those of the quadratic B-spline, without Taichi.

    python tests/benchmarks/compact_accuracy.py [-o FILE] [--cells N ...]

The compact kernel (Liu et al. 2024, arXiv:2412.10399) has two grids, a quarter of a cell before and behind, and on each
the products of K(x) = 1 - |x| + sin(2 pi |x|) / (2 pi), |x| <= 1, halved: 2^dim nodes of each grid, 16 in 3-D for 27.
Both together reproduce linear fields. Unlike that of a B-spline its second moment D depends on the place.

Linear elasticity (nu = 0.3) in a periodic box by moving least squares, L = sum_i v_i (x_i - x_p)^T D^-1, with APIC or
AFLIP (ratio 0.97). Columns: case, kernel, transfer, and

lone, dense: C, the largest c dt / dx at which no mode grows, of particles far from each other, and of lattices
with 2^dim a cell, the least over their places.
wave: in 3-D a pressure wave along the first axis over two periods, while all snow moves at an angle with 0.3 c. cells
of its length, particles along it, steps of 0.9 of the lone C, nodes of all grids over those of one grid of such cells;
error of the velocity over its amplitude. The quadratic grid has 4, 5 (so that the number of nodes is about the same) or
6 cells where the compact one has 4.
"""

import argparse
import csv
import itertools
from pathlib import Path

import numpy as np

TABLE = Path(__file__).parent / "figures" / "compact_accuracy.csv"
POISSON = 0.3
MODULI = (POISSON / (1 - POISSON), (1 - 2 * POISSON) / (2 * (1 - POISSON)))
"""Lame's, over that of a pressure wave; its speed, density and a cell are 1."""
GROWN = 1e3
"""Growth of a random state that no stable step reaches."""
SPEED, PERIODS = 0.3, 2
GRIDS = {"quadratic": (0.0,), "compact": (0.25, -0.25)}
"""Where the grids of each kernel begin [cells]."""
GRIDS_OF_WAVE = ("compact", 4), ("quadratic", 4), ("quadratic", 5), ("quadratic", 6)
"""Kernels, and their cells over a fixed length."""


def weights(kernel, x):
    """First node (n, dim), distance of the nodes along each axis (n, dim, width) and weights of positions on a grid."""
    if kernel == "quadratic":
        base = np.floor(x - 0.5)
        f = x - base
        w = [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1.0) ** 2, 0.5 * (f - 0.5) ** 2]
    else:
        base = np.floor(x)
        f = x - base
        upper = f - np.sin(2 * np.pi * f) / (2 * np.pi)
        w = [1.0 - upper, upper]
    return base.astype(int), np.stack([k - f for k in range(len(w))], -1), np.stack(w, -1)


class Box:
    """Periodic box of `shape` cells, its grids and particles at positions x (n, dim) [cells].

    nodes (n, k), w (n, k), arms (n, k, dim) from the particle: the stencils; inverse (n, dim, dim): D^-1.
    """

    def __init__(self, kernel, shape, x):
        self.dim, self.n_nodes = len(shape), len(GRIDS[kernel]) * int(np.prod(shape))
        nodes, w, arms = [], [], []
        for number, offset in enumerate(GRIDS[kernel]):
            base, along, part = weights(kernel, x - offset)
            for steps in itertools.product(range(part.shape[-1]), repeat=self.dim):
                place = tuple((base[:, a] + k) % shape[a] for a, k in enumerate(steps))
                nodes.append(np.ravel_multi_index(place, shape) + number * int(np.prod(shape)))
                w.append(np.prod([part[:, a, k] for a, k in enumerate(steps)], axis=0) / len(GRIDS[kernel]))
                arms.append(np.stack([along[:, a, k] for a, k in enumerate(steps)], -1))
        self.nodes, self.w, self.arms = np.stack(nodes, 1), np.stack(w, 1), np.stack(arms, 1)
        self.inverse = np.linalg.inv(np.einsum("pk,pka,pkb->pab", self.w, self.arms, self.arms))
        self.pull = np.einsum("pk,pka,pab->pkb", self.w, self.arms, self.inverse)
        self.mass = np.maximum(self.sum(self.w), 1e-12)

    def sum(self, values):
        """Of (n, k) numbers over the nodes."""
        return np.bincount(self.nodes.ravel(), values.ravel(), self.n_nodes)

    def step(self, state, dt, flip=0.0):
        """Velocity (n, dim), C and stress (n, dim, dim) after a step; a particle's mass and volume are 1."""
        v, C, stress = state
        given = self.w[..., None] * (v[:, None] + np.einsum("pab,pkb->pka", C, self.arms))
        push = -dt * np.einsum("pab,pkb->pka", stress, self.pull)
        before, change = (np.stack([self.sum(part[..., a]) for a in range(self.dim)], 1) / self.mass[:, None]
                          for part in (given, push))
        there = (before + change)[self.nodes]
        C = np.einsum("pka,pkb->pab", there, self.pull)
        strain = 0.5 * dt * (C + C.swapaxes(1, 2))
        trace = np.trace(strain, axis1=1, axis2=2)[:, None, None]
        smooth, gain = (np.einsum("pk,pka->pa", self.w, values) for values in (there, change[self.nodes]))
        return smooth + flip * (v + gain - smooth), C, stress + MODULI[0] * trace * np.eye(self.dim) + (
            2 * MODULI[1] * strain)


def lattice(shape, counts, place):
    """counts (dim,) particles along the axes of a box, the lattice moved by `place` (dim,) of a spacing."""
    axes = [(np.arange(n) + at) * size / n for n, at, size in zip(counts, place, shape, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(shape))


def grows(box, dt, steps, rng):
    """Whether some mode of a random state does."""
    n, dim = len(box.w), box.dim
    state = rng.normal(size=(n, dim)), np.zeros((n, dim, dim)), np.zeros((n, dim, dim))
    for _ in range(steps):
        state = box.step(state, dt)
        if not np.abs(state[1]).max() < GROWN:
            return True
    return False


def largest_step(boxes, steps=600):
    """-> largest C at which APIC is stable, least over the boxes."""
    least = 2.0
    for seed, box in enumerate(boxes):
        if seed and not grows(box, least, steps, np.random.default_rng(seed)):
            continue
        low, high = 0.0, least
        while high - low > 0.003:
            middle = 0.5 * (low + high)
            grown = grows(box, middle, steps, np.random.default_rng(seed))
            low, high = (low, middle) if grown else (middle, high)
        least = low
    return least


def lone(kernel, dim):
    """One box of particles that share no node, at many places of their cells."""
    places = 5 * np.stack(np.meshgrid(*[np.arange(5)] * dim, indexing="ij"), -1).reshape(-1, dim) + 2.0
    places[1:] += np.random.default_rng(0).random((len(places) - 1, dim))
    return [Box(kernel, (25,) * dim, places + 0.5 * (kernel == "compact"))]


def dense(kernel, dim):
    """Boxes of 2^dim particles a cell: in the middle of their quarters, and elsewhere."""
    shape = (6,) * dim if dim == 2 else (4,) * dim
    for seed in range(4 if dim == 2 else 2):
        place = np.random.default_rng(seed).random(dim) if seed else np.full(dim, 0.5)
        yield Box(kernel, shape, lattice(shape, [2 * n for n in shape], place))


def wave(kernel, flip, shape, counts, C):
    """Error of the velocity, and steps, of a wave as long as the box."""
    cells = shape[0]
    x = lattice(shape, counts, np.full(3, 0.5))
    drift, k = SPEED * np.array([0.7, 0.6, 0.15**0.5]), 2 * np.pi / cells
    steps = int(np.ceil(PERIODS * cells / C))
    dt = PERIODS * cells / steps
    v, C_of, stress = np.zeros((len(x), 3)), np.zeros((len(x), 3, 3)), np.zeros((len(x), 3, 3))
    v[:, 0], C_of[:, 0, 0] = np.cos(k * x[:, 0]), -k * np.sin(k * x[:, 0])
    for a in range(3):  # of the middle of the step to the next velocity
        stress[:, a, a] = -(MODULI[0] if a else 1.0) * np.cos(k * (x[:, 0] - 0.5 * dt))
    state = v, C_of, stress
    for _ in range(steps):
        state = Box(kernel, shape, x % np.array(shape)).step(state, dt, flip)
        x = x + dt * drift
    return float(np.sqrt(2.0 * ((state[0] - v) ** 2).sum(1).mean())), steps


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    parser.add_argument("--cells", type=int, nargs="+", default=[8, 16, 32], help="of a wave on the compact grid")
    options = parser.parse_args()
    rows, largest = [], {}
    for kernel, dim, (case, boxes) in itertools.product(GRIDS, (2, 3), (("lone", lone), ("dense", dense))):
        largest[kernel, case, dim] = largest_step(boxes(kernel, dim))
        rows.append({"case": f"{case} {dim}-D", "kernel": kernel, "transfer": "apic",
                     "C": round(largest[kernel, case, dim], 3)})
        print(rows[-1], flush=True)
    for cells, (kernel, finer), (transfer, flip) in itertools.product(
            options.cells, GRIDS_OF_WAVE, (("apic", 0.0), ("aflip", 0.97))):
        shape = (cells * finer // 4, finer, finer)
        C = 0.9 * largest[kernel, "lone", 3]
        error, steps = wave(kernel, flip, shape, (2 * cells, 8, 8), C)
        rows.append({"case": "wave", "kernel": kernel, "transfer": transfer, "C": round(C, 3), "cells": shape[0],
                     "particles": 2 * cells, "steps": steps, "error": f"{error:.4g}",
                     "nodes": len(GRIDS[kernel]) * (finer / 4) ** 3})
        print(rows[-1], flush=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[-1])
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main()
