"""A saturated cantilever under a load on its top (Nøst 2019, section 8.2; after Li, Schulgasser & Cederbaum 1998).

1 m long, 0.3 m high, held at x = 0, E = 10 MPa, nu = 0, hydraulic conductivity 1e-4 m/s; 54 kPa on it, downwards, from
x = 0.05 m on. Water leaves through the end that is held; the other faces are sealed, where the source drains both ends,
since the free surface of a scene is either. Bending equalises across the beam (0.09 s), not along it (1 s and more).

The load acts on all of a section ("axis", as in the theory of beams), or on the row of particles at the top alone
("top", eq. 4.25 of the source), which moves outwards as the beam turns, and bends it by a seventh more.
"""

import numpy as np

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.study.problems.soaked_column import E_OED, K_W, PERMEABILITY, POROSITY

LENGTH, HEIGHT, PRESSURE, UNLOADED = 1.0, 0.3, 5.4e4, 0.05
DENSITY = 1600.0 + 1000.0 * POROSITY


def soaked_beam(dx=0.05, dt=1e-5, split="monolithic", ramp=0.0, on="axis"):
    """`Simulation` of it, by implicit steps of dt [s] in balance; ramp: time [s] in which the load grows."""
    skin = 0.5 * dx if on == "top" else HEIGHT
    pull = PRESSURE / (DENSITY * skin)
    value = f"-{pull!r} * min(t / {ramp!r}, 1)" if ramp else -pull
    beam = [("root", [0.0, HEIGHT - skin], [UNLOADED, HEIGHT]), ("loaded", [UNLOADED, HEIGHT - skin], [LENGTH, HEIGHT])]
    if on == "top":
        beam.append(("below", [0.0, 0.0], [LENGTH, HEIGHT - skin]))
    return Simulation(Scene.model_validate({
        "name": "soaked_beam", "dimension": 2, "end_time": 1.2, "gravity": 0.0,
        "solver": {"dx": dx, "precision": "f64", "gradient": "shape", "implicit": {"time": "quasi_static", "dt": dt}},
        "domain": {"min": [0.0, -0.6], "max": [1.2, 0.6], "boundary": {"x_min": "stick"}},
        "materials": {"soil": {"kind": "elastic", "density": 1600.0, "youngs_modulus": E_OED, "poisson_ratio": 0.0}},
        "bodies": [{"name": name, "material": "soil", "shape": {"kind": "box", "min": lower, "max": upper}}
                   for name, lower, upper in beam],
        "forces": [{"kind": "acceleration", "body": "loaded", "value": [0.0, value]}],
        "water": {"permeability": 0.1 * PERMEABILITY, "porosity": POROSITY, "bulk_modulus": K_W, "split": split,
                  "surface": "sealed", "sides": {"x_min": "drained"}}}))


def deflection(simulation):
    """How far the axis of the free end has sunk [m]."""
    x, start = simulation.particles["position"], _starts(simulation)
    end = start[:, 0] > LENGTH - simulation.solver.dx
    near = end & (np.abs(start[:, 1] - 0.5 * HEIGHT) < 0.6 * simulation.solver.dx)
    return float((start[near, 1] - x[near, 1]).mean())


def pressures(simulation):
    """Mean pore pressure [Pa] of the upper and of the lower quarter of the beam's first half."""
    fields, start = simulation.particles, _starts(simulation)
    first = (start[:, 0] > 0.1 * LENGTH) & (start[:, 0] < 0.5 * LENGTH)
    p = fields["pore_pressure"]
    return (float(p[first & (start[:, 1] > 0.75 * HEIGHT)].mean()),
            float(p[first & (start[:, 1] < 0.25 * HEIGHT)].mean()))


def _starts(simulation):
    """Where each particle was (n, 2) [m]."""
    return simulation.model.population.positions[simulation.particles["id"]]
