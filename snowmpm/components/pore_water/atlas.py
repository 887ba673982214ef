"""Entries: pore water whose step, or whose coupling, is wrong for it."""

import numpy as np

from snowmpm.components.pore_water.step import FilledPores
from snowmpm.errors import SimulationError
from snowmpm.study.atlas.entry import WORST, Entry
from snowmpm.study.problems.soaked_column import E_OED, LOAD, pressure_error, soaked_column

STEPS, DRAINED = 200, 0.05
"""Steps of a column whose motion is watched, and the time [s] of one whose pressure is."""
JOLT = LOAD / np.sqrt(E_OED * 2000.0)
"""Speed [m/s] that the load, put on at once, gives to dry soil."""


def _motion(simulation, dt):
    """Fastest speed in STEPS steps of dt [s], over JOLT."""
    most, solver = 0.0, simulation.solver
    try:
        for _ in range(STEPS):
            solver.step(dt)
            most = max(most, solver.extremes.speed / JOLT)
            if most > WORST:
                break
    except SimulationError:
        return WORST
    return float(most)


def _water(simulation):
    return next(one for one in simulation.solver.adapters if isinstance(one, FilledPores))


def undrained(size, split):
    """Motion of a sealed column by steps of `size`, over the one that undrained waves allow."""
    limit = soaked_column(split="explicit", surface="sealed").solver.critical_dt()[0]
    simulation = soaked_column(split=split, surface="sealed", pressure=0.9 * LOAD)
    return _motion(simulation, size * limit)


def stabilised(share, transfer):
    """Motion of a sealed column whose s_0 is `share` of the usual one, by steps of 0.9 of the critical one."""
    simulation = soaked_column(transfer, surface="sealed", pressure=0.9 * LOAD)
    _water(simulation).share *= share
    return _motion(simulation, 0.9 * simulation.solver.critical_elastic_dt())


def delayed(size, transfer):
    """Error of the pressure of a column that drained for DRAINED, by steps of `size` of the critical one."""
    simulation = soaked_column(transfer)
    solver = simulation.solver
    n = int(np.ceil(DRAINED / (size * solver.critical_elastic_dt())))
    try:
        for _ in range(n):
            solver.step(DRAINED / n)
    except SimulationError:
        return WORST
    return pressure_error(simulation)


def passes_of(alpha, split):
    """Passes of the coupling of a column between walls in a step of 1 ms; alpha: over 1 / E_oed."""
    at_rest = {"implicit": {"time": "quasi_static", "dt": 1e-3}}
    # In the plane K_dr is half of E_oed here
    simulation = soaked_column(solver=at_rest, split=split, alpha=0.5 * alpha, tolerance=1e-4)
    try:
        simulation.solver.step(1e-3)
    except SimulationError:
        return WORST
    return _water(simulation).passes


TRANSFERS = {"apic": {"transfer": "apic"}, "pic": {"transfer": "pic"}}

ATLAS = {"water in the pores": (
    Entry(
        name="undrained_step", title="A step beyond that of undrained waves, with the explicit split",
        scene="A sealed column of ten cells, whose water carries 0.9 of a load",
        seen="Water hardly gives way: a wave in undrained soil is 20 times as fast as in drained soil. A longer step"
             " blows up",
        cure='water.split = "semi_implicit", or a step below this border', parameter="dt over the undrained limit",
        unit="", values=(0.5, 0.8, 1.0, 1.5, 2.0, 4.0, 10.0),
        settings={"explicit": {"split": "explicit"}, "semi_implicit": {"split": "semi_implicit"}},
        symptom="speed over that of a jolt", limit=3.0, measure=undrained, shown="explicit", cured="semi_implicit",
        resolution=0.05),
    Entry(
        name="weak_stabilisation", title="Too small a share of the stabilising flux of pore water",
        scene="A sealed column of ten cells, whose water carries 0.9 of a load; steps of 0.9 of the critical one",
        seen="The pressure acts a step late. Without enough of the flux that makes up for it the column shakes ever"
             " faster", cure="the usual share, which the program takes", parameter="s_0 over the usual", unit="",
        values=(0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 2.0), settings=TRANSFERS, symptom="speed over that of a jolt", limit=3.0,
        measure=stabilised, shown="apic", fails="below", resolution=0.05),
    Entry(
        name="soaked_step", title="A step near the critical one, with water in the pores",
        scene="Terzaghi's column of ten cells, after 0.05 s",
        seen="The stabilising flux grows with the square of the step, and smooths the pressure over a cell or more",
        cure="solver.cfl at half of the critical one, which the program takes by itself",
        parameter="dt over the critical step", unit="", values=(0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.95),
        settings=TRANSFERS, symptom="error of the pressure", limit=0.03, measure=delayed, shown="apic",
        resolution=0.05),
    Entry(
        name="weak_alpha", title="Too small an alpha of the fixed-stress split",
        scene="Terzaghi's column of ten cells between walls, one implicit step of 1 ms at rest",
        seen="The skeleton answers a change of pressure by more than the split assumed: passes overshoot, and below"
             " half of the true answer they run away", cure='water.split = "monolithic", or a larger water.alpha',
        parameter="alpha over 1 / E_oed", unit="", values=(0.3, 0.5, 0.6, 0.8, 1.0, 1.5, 2.0),
        settings={"fixed_stress": {"split": "fixed_stress"}, "monolithic": {"split": "monolithic"}},
        symptom="passes to 1e-4", limit=40.0, measure=passes_of, shown="fixed_stress", cured="monolithic",
        fails="below", resolution=0.05),
)}
