"""BM-1: a column of grains collapses against an upright wall, stiff or flexible, with two ways of coupling.

The sizes are those of the case: soil 200 x 100 mm against the left side, a wall of 10 x 100 mm, 100 mm away, sides and
floor that stick; soil of Mohr-Coulomb, rubber of 1 MPa. One body: soil and wall share the grid's velocities, so that
they stick to each other wherever they come near. Parts: the wall is a structure that the snow may leave.
"""

import time

import numpy as np

from snowmpm import Simulation
from snowmpm.scenes.schema import Scene

SOIL = {"kind": "mohr_coulomb", "density": 2650.0, "youngs_modulus": 8.4e5, "poisson_ratio": 0.3,
        "friction_angle": 19.8, "cohesion": 0.0, "dilation_angle": 0.0}
RUBBER = {"kind": "elastic", "density": 1100.0, "youngs_modulus": 1e6, "poisson_ratio": 0.0}
THICK, HIGH, FACE = 0.01, 0.1, 0.3
EVERY, AT, LATE = 2e-3, 0.5, 0.8
"""Times [s]: between readings, of gap and mass, from which on the late mean is taken."""


def wall(modulus=1e6, **more):
    """The wall as a structure."""
    return {"name": "wall", "foot": [FACE + 0.5 * THICK, 0.0], "top": [FACE + 0.5 * THICK, HIGH], "width": THICK,
            "youngs_modulus": modulus, "density": 1100.0, "segments": 10, "damping": 0.0, "contact": "separate",
            "friction": 0.5, "coupling": "strong", **more}


def scene(dx, one_body, end_time=1.0, modulus=1e6, per_cell=4, **more):
    """`Scene` on a grid of dx [m]; one_body: the wall is a body that sticks; modulus of the wall [Pa]."""
    bodies = [{"name": "soil", "material": "soil",
               "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.2, 0.1]}}]
    if one_body:
        bodies.append({"name": "wall", "material": "rubber",
                       "shape": {"kind": "box", "min": [FACE, 0.0], "max": [FACE + THICK, HIGH]}})
    materials = {"soil": SOIL, "rubber": {**RUBBER, "youngs_modulus": modulus}}
    return Scene.model_validate({
        "name": "column_against_wall", "dimension": 2, "end_time": end_time, "gravity": 9.81,
        "output": {"interval": 0.005}, "solver": {"dx": dx, "precision": "f64", "particles_per_cell": per_cell},
        "domain": {"min": [0.0, 0.0], "max": [0.6, 0.2], "boundary": {"x_min": "stick", "z_min": "stick"}},
        "materials": materials if one_body else {"soil": SOIL}, "bodies": bodies,
        "structures": [] if one_body else [wall(modulus)], **more})


def measure(dx, one_body, until=1.0, **more):
    """Times [s] and displacements of the tip [m], and the numbers of the table, in m, s and kg/m."""
    began = time.process_time()
    simulation = Simulation(scene(dx, one_body, until, **more))
    soil = simulation.numbers_of_body(0)
    start = _places(simulation)
    tip = _top_row(simulation, start, dx) if one_body else None
    times, found, row = [0.0], [0.0], {}
    while simulation.time < until - 1e-9:
        wanted = times[-1] + EVERY
        while simulation.time < wanted - 1e-9:
            simulation.step(until=wanted)
        times.append(simulation.time)
        if one_body:
            found.append(float((_places(simulation)[tip] - start[tip])[:, 0].mean()))
        else:
            found.append(simulation.solver.adapters["structures"].row()["wall_top_x"])
        if abs(simulation.time - AT) < 0.5 * EVERY:
            row = at_half(simulation, start, soil, one_body)
    rods = None if one_body else simulation.solver.adapters["structures"].rods
    row.update(coupling="one body" if one_body else "parts", dx=dx, particles=simulation.n_particles,
               steps=simulation.solver.steps, unsettled=rods.unsettled if rods else 0, **of_tip(times, found),
               seconds=time.process_time() - began)
    return np.array(times), np.array(found), row


def of_tip(times, found):
    """First peak, late mean, half range and period of the tip's displacement."""
    times, found = np.array(times), np.array(found)
    smooth = np.convolve(found, np.ones(5) / 5.0, "same")
    tops = np.flatnonzero((smooth[1:-1] > smooth[:-2]) & (smooth[1:-1] >= smooth[2:])) + 1
    tops = tops[smooth[tops] > 0.3 * smooth.max()]
    first = tops[0] if len(tops) else int(smooth.argmax())
    after = times > times[first]
    swing = found[after] - np.convolve(found, np.ones(101) / 101.0, "same")[after]
    down = np.flatnonzero((swing[1:] < 0.0) & (swing[:-1] >= 0.0))
    return {"first_peak": float(found[max(0, first - 3) : first + 4].max()),
            "late": float(found[times > LATE].mean()) if times[-1] > LATE else np.nan,
            "half_range": float(np.ptp(found[after]) / 2.0),
            "period": float(np.diff(times[after][down]).mean()) if len(down) > 1 else np.nan}


def at_half(simulation, start, soil, one_body):
    """Gap between soil and wall, in the lower 20 mm, and the mass in the upper left that moved."""
    now, mass = _places(simulation), simulation.particles["mass"][np.argsort(simulation.particles["id"])]
    own = slice(*soil)
    spacing = float(np.sqrt(simulation.model.population.volumes[0]))
    low = (now[own, 1] < 0.02)
    front = now[own][low, 0].max() + 0.5 * spacing
    if one_body:
        wall = now[soil[1]:]
        face = wall[wall[:, 1] < 0.02, 0].min() - 0.5 * spacing
    else:
        rod = simulation.solver.adapters["structures"].rods.rods[0].rod
        face = float(np.interp(0.01, rod.x[:, 2], rod.x[:, 0])) - 0.005
    moved = np.linalg.norm(now[own] - start[own], axis=1) > 0.005
    left = (start[own, 0] < 0.1) & (start[own, 1] > 0.5 * HIGH)
    return {"gap": float(face - front), "upper_left": float(mass[own][moved & left].sum())}


def _places(simulation):
    particles = simulation.particles
    return particles["position"][np.argsort(particles["id"])][:, [0, -1]]


def _top_row(simulation, start, dx):
    wall = np.arange(len(start)) >= simulation.numbers_of_body(1)[0]
    return np.flatnonzero(wall & (start[:, 1] > HIGH - 0.6 * dx))
