"""The problem that all programs solve: a free elastic bar that swings along itself, without a wall (NumPy only).

L = 1 m, square or plane section of L / 5, E = 1 MPa, nu = 0, rho = 1000 kg/m3: waves run along the bar only, at
c = sqrt(E / rho), whatever the section. It starts unstrained with v = V cos(pi x / L) along itself and swings as

    v(x, t) = V cos(pi x / L) cos(pi c t / L),

V = 3e-3 c: strains of 0.1 %. Error: root mean square of the velocity after one period, T = 2 L / c, over that of the
start: damping and phase together.
"""

import json
import sys
import time

import numpy as np

LENGTH, SECTION = 1.0, 0.2  # m
YOUNGS_MODULUS, DENSITY = 1e6, 1000.0  # Pa, kg/m3
SPEED = np.sqrt(YOUNGS_MODULUS / DENSITY)
"""c [m/s]."""
PERIOD = 2.0 * LENGTH / SPEED
AMPLITUDE = 3e-3 * SPEED
"""V [m/s]."""
CELLS = (10, 20, 40)
"""Along the bar, of the grid; particles lie half as far apart."""


def lattice(spacing, dim):
    """Particles (n, dim) [m] of the bar, from the origin."""
    axes = [spacing * (np.arange(round(length / spacing)) + 0.5) for length in (LENGTH, *[SECTION] * (dim - 1))]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, dim)


def start(x):
    """Velocity along the bar (n,) [m/s] of particles that lie at `x` along it."""
    return AMPLITUDE * np.cos(np.pi * x / LENGTH)


def error(x, v):
    """x: along the bar at the start, v: velocity along it after one period."""
    return float(np.sqrt(np.mean((v - start(x)) ** 2) / np.mean(start(x) ** 2)))


class Clock:
    """Processor seconds of steps; the first ones, which compile, count as the median one."""

    def __init__(self):
        self.steps = []

    def step(self, call, *arguments):
        begun = time.process_time()
        call(*arguments)
        self.steps.append(time.process_time() - begun)

    @property
    def seconds(self):
        return float(np.median(self.steps[3:] or self.steps) * len(self.steps))


def tell(program, choice, dim, cells, particles, steps, seconds, found):
    """One line of JSON on stdout for the benchmark that called."""
    print("ROW " + json.dumps({"program": program, "choice": choice, "dimension": dim, "cells": cells,
                               "particles": particles, "steps": steps, "seconds": float(f"{seconds:.4g}"),
                               "error": float(f"{found:.4g}")}), flush=True)
    sys.stdout.flush()
