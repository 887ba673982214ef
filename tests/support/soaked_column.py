"""Terzaghi's column (P1) as a scene: saturated, loaded on its top, drained there; and its closed form."""

import numpy as np

from snowmpm.scenes.schema import Scene

DX, HEIGHT, LOAD = 0.025, 1.0, 1e4
E_OED, POROSITY, K_W, VISCOSITY = 1e7, 0.4, 2.2e9, 1.792e-3
PERMEABILITY = 1e-3 * VISCOSITY / (1000.0 * 9.81)
C_V = PERMEABILITY / VISCOSITY / (1.0 / E_OED + POROSITY / K_W)
"""[m2/s], for a hydraulic conductivity of 1e-3 m/s"""


def column(dx=DX, dimension=2, wide=4, water=None, solver=None, **changes):
    """`Scene` of a column `wide` cells wide, whose pore water carries the whole load at the start."""
    side = wide * dx
    lower, upper = [0.0] * dimension, [side] * (dimension - 1) + [HEIGHT + 0.2]
    plan = "x" if dimension == 2 else "xy"
    walls = {f"{axis}_{end}": "slip" for axis in plan for end in ("min", "max")}
    tables = {
        "name": "terzaghi", "dimension": dimension, "end_time": 1.0, "gravity": 0.0,
        "solver": {"dx": dx, "precision": "f64", **(solver or {})},
        "domain": {"min": lower, "max": upper, "boundary": {**walls, "z_min": "slip"}},
        "materials": {"soil": {"kind": "elastic", "density": 1600.0, "youngs_modulus": E_OED, "poisson_ratio": 0.0}},
        "bodies": [{"name": "column", "material": "soil", "shape": {
            "kind": "box", "min": lower, "max": [*upper[:-1], HEIGHT]}}],
        "forces": [{"kind": "pressure", "value": LOAD}],
        "water": {"permeability": PERMEABILITY, "porosity": POROSITY, "pressure": LOAD, **(water or {})}}
    return Scene.model_validate({**tables, **changes})


def terzaghi(depth, T):
    """p / p_0 at depth z / h below the drained top: 4/pi sum_m sin(m pi z / 2 h) exp(-m² pi² T / 4) / m, m odd."""
    m = np.arange(1, 400, 2)
    return 4.0 / np.pi * (np.sin(0.5 * np.pi * m * np.asarray(depth)[:, None]) / m
                          * np.exp(-(m**2) * np.pi**2 * T / 4.0)).sum(axis=1)


def consolidation(T):
    """Degree of consolidation: 1 - mean of p / p_0."""
    m = np.arange(1, 400, 2)
    return 1.0 - 8.0 / np.pi**2 * (np.exp(-(m**2) * np.pi**2 * T / 4.0) / m**2).sum()


def pressure_error(particles, T, dx=DX):
    """Largest |p - p_exact| / p_0 over the cells."""
    n = round(HEIGHT / dx)
    row = np.minimum((particles["position"][:, -1] / dx).astype(int), n - 1)
    p = np.bincount(row, particles["pore_pressure"], n) / np.bincount(row, minlength=n) / LOAD
    return np.abs(p - terzaghi(1.0 - (np.arange(n) + 0.5) / n, T)).max()


def settlement(particles):
    """How far the top has come down [m], by the volume that was lost."""
    start = particles["volume"] / particles["J"]
    return HEIGHT * (1.0 - particles["volume"].sum() / start.sum())
