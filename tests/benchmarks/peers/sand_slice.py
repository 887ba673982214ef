"""A slice of dry sand that collapses down a slope: the same law, walls and sizes for programs with plasticity (NumPy).

0.2 m long and 0.15 m high, four cells wide, on a slope of 10 degrees that holds it, against a smooth wall at x = 0;
the sides are smooth. E = 1 MPa, nu = 0.3, rho = 1000 kg/m3; Drucker-Prager's cone without cohesion or dilation,
q = p (q: 3/2 of the deviator's square, its root), which is sqrt(1/2 s : s) = tan(30) p. After 1.4 s it is at rest.

This is a test of matter (`CollapseTest.DruckerPrager*`: its front lies at 0.56 m), in a thinner slice.
"""

import json

import numpy as np

LENGTH, HEIGHT, ACROSS = 0.2, 0.15, 4  # m, m, cells
TIME = 1.4  # s
YOUNGS_MODULUS, POISSON_RATIO, DENSITY = 1e6, 0.3, 1000.0  # Pa, -, kg/m3
SLOPE, GRAVITY = 10.0, 9.81  # degrees, m/s2
CELLS = (6, 9, 15)
"""Over the height; eight particles a cell."""


def lattice(dx):
    """Particles (n, 3) [m]: along the slope, away from it, across."""
    axes = [0.5 * dx * (np.arange(round(2 * length / dx)) + 0.5) for length in (LENGTH, HEIGHT, ACROSS * dx)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def tell(program, choice, cells, particles, steps, seconds, x):
    """One line of JSON for the benchmark that called; x: along the slope (n,) [m] at the end."""
    print("ROW " + json.dumps({"program": program, "choice": choice, "cells": cells, "particles": particles,
                               "steps": steps, "seconds": float(f"{seconds:.4g}"), "middle": float(f"{x.mean():.5g}"),
                               "front": float(f"{np.quantile(x, 0.99):.5g}")}), flush=True)
