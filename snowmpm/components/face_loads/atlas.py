"""Entries: surfaces that are tied to a prescribed motion by a penalty."""

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.scenes.schema import Scene
from snowmpm.study.atlas.entry import WORST, Entry

YOUNG, STRAIN = 1e6, 0.01
SNOW = {"kind": "elastic", "density": 300.0, "youngs_modulus": YOUNG, "poisson_ratio": 0.0}
"""Does not contract across: the stress of a pulled block is uniform, and E its stiffness against a plane wave."""
THICK = 4
"""Cells across a block."""
THROWS, EVERY, SPEED = 300, 10, 1.0
"""Steps of a throw, those after which energies are asked for, and its speed [m/s]."""


def _block(cells, forces, **solver):
    """Simulation of a block of cells x THICK cells of 1 m in the air, off the grid by a third of one."""
    from snowmpm.running.simulation import Simulation  # it builds a scene, which most entries do not

    low = 1.0 / 3.0
    return Simulation(Scene.model_validate({
        "name": "tied", "dimension": 2, "end_time": 1.0, "gravity": 0.0, "output": {"interval": 1.0},
        "solver": {"dx": 1.0, "precision": "f64", **solver}, "materials": {"snow": SNOW},
        "domain": {"min": [-4.0, -4.0], "max": [cells + 5.0, THICK + 5.0]},
        "bodies": [{"name": "block", "material": "snow",
                    "shape": {"kind": "box", "min": [low, low], "max": [low + cells, low + THICK]},
                    "velocity": [0.0, 0.0] if solver.get("method") else [SPEED, 0.3 * SPEED]}],
        "forces": forces}))


def _tie(name, x, way, penalty, contact="stick"):
    return {"kind": "displacement", "name": name, "body": "block", "value": [way, 0.0], "penalty": penalty,
            "contact": contact, "within": {"min": [x, -9.0], "max": [x, 99.0]}}


def pulled(stiffness, cells, ends):
    """Error of the reaction of a block that is pulled by STRAIN, one of its ends or both on ties; stiffness: penalty
    times cells along the block."""
    low, penalty = 1.0 / 3.0, stiffness / cells
    held = _tie("held", low, 0.0, penalty if ends == 2 else 1e4 * penalty)
    sim = _block(cells, [held, _tie("drawn", low + cells, STRAIN * cells, penalty)], method="implicit",
                 implicit={"time": "quasi_static", "dt": 1.0})
    sim.step(until=1.0)
    nominal = YOUNG * np.log(1.0 + STRAIN) / (1.0 + STRAIN)
    return sim.audit()["drawn_force_x"] / (THICK * nominal) - 1.0


def thrown(share, penalty):
    """Most that a block gains in energy which is thrown against its tie, whose springs can only store it; share: step
    over the longest that is stable by the program's bound, of waves and ties."""
    sim = _block(4, [_tie("held", 1.0 / 3.0, 0.0, penalty)])
    solver, start = sim.solver, sim.audit()["kinetic_energy"]
    dt, most = share * solver.critical_dt()[0], start
    try:
        for step in range(THROWS):
            solver.step(dt)
            if step % EVERY == 0:
                row = sim.audit()
                most = max(most, row["kinetic_energy"] + row["elastic_energy"])
    except SimulationError:
        return WORST
    return most / start - 1.0


ATLAS = {"contact": (
    Entry(
        name="soft_tie", title="A tie that gives way",
        scene="An elastic block four cells thick whose ends are drawn apart by 1 %, as a balance",
        seen="A tie gives way as a layer of dx / penalty of the body's own material would, so that the body is pulled,"
             " or pushed, by less than is prescribed. One tie takes dx / (penalty L) of a body of length L",
        cure="a higher penalty; with implicit steps it costs nothing", parameter="penalty times cells along the body",
        unit="", values=(5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0), fails="below",
        settings={"one end, 4 cells": {"cells": 4, "ends": 1}, "one end, 16 cells": {"cells": 16, "ends": 1},
                  "both ends, 16 cells": {"cells": 16, "ends": 2}},
        symptom="error of the reaction", limit=0.02, measure=pulled, shown="both ends, 16 cells"),
    Entry(
        name="long_step_tie", title="A step beyond that of a tie", scene="An elastic block thrown against its tie",
        seen="Particles swing on the springs of their tie, and faster than waves cross a cell. A step that is too long"
             " for that gives them energy",
        cure="the program's own step, which counts ties; a lower penalty, or implicit steps",
        parameter="step over the longest that the program takes for stable", unit="",
        values=(0.5, 1.0, 1.2, 1.4, 1.6, 2.0, 3.0),
        settings={f"penalty {penalty:g}": {"penalty": penalty} for penalty in (1.0, 10.0, 100.0, 1000.0)},
        symptom="energy gained", limit=0.05, measure=thrown, shown="penalty 100", resolution=0.1),
)}
