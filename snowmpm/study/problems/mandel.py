"""Mandel's problem: a saturated block between rigid smooth plates, which drains to its sides.

A quarter of it, 0 <= x <= 1 m and 0 <= z <= TALL, between the planes of symmetry x = 0 and z = 0. Far from its end a
tall block is compressed as evenly as between plates, so it needs none (Saint-Venant): at z = 0 the end is felt by
exp(-2.1 TALL) (Papkovich and Fadle). All around it is under the pressure LOAD, which its water carries at the
start, p = LOAD. A uniform load beside Mandel's adds a uniform pressure at the start; what follows depends on that one
alone.

    p / p_0 = 2 sum_i sin a_i / (a_i - sin a_i cos a_i) (cos(a_i x) - cos a_i) exp(-a_i² T),   T = c t / 1 m²,
    tan a_i / a_i = (1 - nu) / (nu_u - nu),   nu_u = 1/2 (incompressible water and grains),   c = M K / mu,

times the undrained rise B (1 + nu_u) / 3 of twice the mean load, which is 1 here (Mandel 1953, doi:10.1680/geot.1953.
3.7.287; Abousleiman et al. 1996, doi:10.1680/geot.1996.46.2.187). The centre's pressure rises before it falls.
"""

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.study.problems.soaked_column import K_W, LOAD, PERMEABILITY, POROSITY, VISCOSITY, pores

TALL = 3.0
POISSON, MODULUS = 0.2, 1e7
"""nu, and M of confined compression [Pa]"""
YOUNG = MODULUS * (1.0 + POISSON) * (1.0 - 2.0 * POISSON) / (1.0 - POISSON)
C_V = PERMEABILITY / VISCOSITY / (1.0 / MODULUS + POROSITY / K_W)
"""[m2/s]"""


def mandel_scene(dx, water, solver):
    """`Scene` of the block; water, solver: further keys of these tables."""
    walls = {"x_min": "symmetric", "z_min": "symmetric"}
    return Scene.model_validate({
        "name": "mandel", "dimension": 2, "end_time": 1.0, "gravity": 0.0,
        "solver": {"dx": dx, "precision": "f64", **solver},
        "domain": {"min": [0.0, 0.0], "max": [1.0 + 4.0 * dx, TALL], "boundary": walls},
        "materials": {"soil": {"kind": "elastic", "density": 1600.0, "youngs_modulus": YOUNG,
                               "poisson_ratio": POISSON}},
        "bodies": [{"name": "block", "material": "soil",
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [1.0, TALL]}}],
        "forces": [{"kind": "pressure", "value": LOAD}],
        "water": pores(water)})


def mandel(dx=0.1, water=None, **solver):
    """`Simulation` of the block."""
    return Simulation(mandel_scene(dx, water or {}, solver))


def roots(count=200):
    """a_i, i < count."""
    from scipy.optimize import brentq  # slow to import

    ratio = (1.0 - POISSON) / (0.5 - POISSON)
    ends = [(i * np.pi + 1e-9, (i + 0.5) * np.pi - 1e-12) for i in range(count)]
    return np.array([brentq(lambda a: np.sin(a) - ratio * a * np.cos(a), *end) for end in ends])


def pressure(x, T):
    """p / p_0 (n,) at x (n,) [m]."""
    a = roots()
    size = 2.0 * np.sin(a) / (a - np.sin(a) * np.cos(a)) * np.exp(-(a**2) * T)
    return (np.cos(np.asarray(x)[:, None] * a) - np.cos(a)) @ size


def found(simulation, dx):
    """(x (n,), p / p_0 (n,)) of the cells along the plane of symmetry z = 0."""
    fields, cells = simulation.particles, round(1.0 / dx)
    x, z = fields["position"].T
    low = (z < dx) & (x < 1.0) & (fields["liquid_water"] > 0.0)  # grains beside water of its own have no pressure
    column = (x[low] / dx).astype(int)
    p = np.bincount(column, fields["pore_pressure"][low], cells) / np.bincount(column, minlength=cells) / LOAD
    return (np.arange(cells) + 0.5) * dx, p


def pressure_error(simulation, dx):
    """Largest |p - p_exact| / p_0 over these cells."""
    x, p = found(simulation, dx)
    return float(np.abs(p - pressure(x, C_V * simulation.time)).max())
