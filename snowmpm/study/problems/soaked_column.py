"""Terzaghi's column: saturated, loaded on its top, drained there or sealed, in a few cells."""

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

HEIGHT, CELLS, LOAD = 1.0, 10, 1e4
E_OED, POROSITY, K_W, VISCOSITY = 1e7, 0.4, 2.2e9, 1.792e-3
PERMEABILITY = 1e-3 * VISCOSITY / (1000.0 * 9.81)
"""[m2]: a hydraulic conductivity of 1e-3 m/s"""
C_V = PERMEABILITY / VISCOSITY / (1.0 / E_OED + POROSITY / K_W)
"""[m2/s]"""
DX, WIDE = HEIGHT / CELLS, 4


def soaked_column(transfer="apic", solver=None, **water):
    """`Simulation` of the column in plane strain; water: keys of its table `[water]`, solver: more of its solver's."""
    corner = [WIDE * DX, HEIGHT]
    walls = dict.fromkeys(("x_min", "x_max", "z_min"), "slip")
    return Simulation(Scene.model_validate({
        "name": "soaked_column", "dimension": 2, "end_time": 1.0, "gravity": 0.0,
        "solver": {"dx": DX, "precision": "f64", "transfer": transfer, **(solver or {})},
        "domain": {"min": [0.0, 0.0], "max": [WIDE * DX, HEIGHT + 2.0 * DX], "boundary": walls},
        "materials": {"soil": {"kind": "elastic", "density": 1600.0, "youngs_modulus": E_OED, "poisson_ratio": 0.0}},
        "bodies": [{"name": "column", "material": "soil",
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": corner}}],
        "forces": [{"kind": "pressure", "value": LOAD}],
        "water": pores(water)}))


def pores(water):
    """Table `[water]` of saturated soil whose water carries the load; water: further keys."""
    solid = {"grain_density": 1600.0 / (1.0 - POROSITY)} if water.get("scheme") == "v_w" else {"porosity": POROSITY}
    return {"permeability": PERMEABILITY, "pressure": LOAD, **solid, **water}


def terzaghi(depth, T):
    """p / p_0 at depth z / h below the drained top: 4/pi sum_m sin(m pi z / 2 h) exp(-m² pi² T / 4) / m, m odd."""
    m = np.arange(1, 400, 2)
    return 4.0 / np.pi * (np.sin(0.5 * np.pi * m * np.asarray(depth)[:, None]) / m
                          * np.exp(-(m**2) * np.pi**2 * T / 4.0)).sum(axis=1)


def pressure_error(simulation):
    """Largest |p - p_exact| / p_0 over the cells of a column that drained since the start."""
    fields = simulation.particles
    z = fields["position"][:, -1]
    inside = (z < HEIGHT) & (fields["liquid_water"] > 0.0)  # grains beside water of its own have no pressure
    row = (z[inside] / DX).astype(int)
    p = np.bincount(row, fields["pore_pressure"][inside], CELLS) / np.bincount(row, minlength=CELLS) / LOAD
    depth = 1.0 - (np.arange(CELLS) + 0.5) / CELLS
    return float(np.abs(p - terzaghi(depth, C_V * simulation.time)).max())
