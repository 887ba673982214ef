"""Saw tests S1 to S4 with the weak layer resolved by cells, and as an interface on coarse and fine ones."""

import time
from dataclasses import dataclass

import numpy as np

import snowmpm
from snowmpm.saw_test.result import crack_speed
from snowmpm.study.problems.elastic_saw_test import WEAK_LAYER

W3 = {"kind": "anticrack_cam_clay", "density": 100.0, "youngs_modulus": 5e5, "poisson_ratio": 0.3,
      "critical_slope": 1.0, "cohesion": 0.3, "hardening": 0.5, "p0": 1.8e3, "softening": 0.5}
"""The card gaume_weak_layer."""
W2 = {**W3, "hardening": 1.0, "p0": 3.0e3}
STRONG_IN_SHEAR = {**W3, "critical_slope": 1.8}
BRITTLE_IN_SHEAR = {**W3, "p0": 4.8e3, "cohesion": 0.05, "softening": 2.0}
THICKNESS = 0.05  # m
AFTER = 0.03  # s after the crack has come through
POINT = 0.0078
"""Least distance of points [m]: 4 % of a critical length."""


@dataclass(frozen=True)
class Case:
    """A saw test: material of the weak layer, keys of `saw_test`, which number is compared."""

    law: dict
    slope_angle: float = 0.0
    length: float = 4.0
    more: tuple = ()
    last: float = 0.0
    """x between which and 0.6 of it the speed is the median [m]; 0: that of the result"""


CASES = {
    "S2 arrest": Case(W2),
    "S2 runs": Case(W3, length=6.0),
    "S3 flat": Case(STRONG_IN_SHEAR),
    "S3 up": Case(STRONG_IN_SHEAR, 35.0),
    "S3 down": Case(STRONG_IN_SHEAR, -35.0),
    "S4": Case(BRITTLE_IN_SHEAR, 45.0, 20.0, (("notch", 0.3), ("saw_start", 0.0), ("saw_speed", 10.0),
                                              ("saw_length", 1.5))),
}


def points_on(dx):
    """Points a cell, at most `POINT` apart, two at least."""
    return max(2, round(dx / POINT))


def scene_of(case, dx, interface, stress="geostatic", points=None):
    """pst_2d with the layer as an interface, of `points` a cell and direction (none: `points_on`), or drawn two cells
    thick. stress: "settle" begins at rest; without, waves from the ends of the column shake the layer while the saw
    comes."""
    layer = {"interface": points or points_on(dx)} if interface else {"cells": 2}
    return snowmpm.load_scene("pst_2d", {
        "solver.dx": dx, "materials.weak_layer": case.law, "saw_test.ends": "normal", "initial.stress": stress,
        "saw_test.length": case.length, "saw_test.slope_angle": case.slope_angle, "end_time": 0.45,
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": THICKNESS, **layer},
        **{f"saw_test.{key}": value for key, value in case.more}})


def cracked(case, dx, interface, stress="geostatic", points=None):
    """Results of a case by name, with `seconds` of processor time of its steps, `steps`, `particles` and, of the energy
    that the crack took, the share that the scheme lost, `remainder`."""
    scene = scene_of(case, dx, interface, stress, points)
    simulation, end = snowmpm.Simulation(scene), 0.45
    simulation.step()
    start = time.process_time()
    while simulation.time < end:
        simulation.step()
        if simulation.crack.rows["tip"][-1] >= case.length - 1e-9:
            end = min(end, simulation.time + AFTER)
    seconds = time.process_time() - start
    found, audit = simulation.crack.result(), simulation.audit()
    values = simulation.crack.values()
    return {**found, "seconds": seconds, "steps": simulation.solver.steps, "particles": simulation.n_particles,
            "remainder": audit["energy_remainder"] / max(audit["plastic_work"], 1e-30),
            "momentum_residual": audit["momentum_residual"],
            "ahead": float(values["tip"][-1] - values["saw"][-1]),
            "onset": _onset(values)}


def _onset(values):
    """Cut [m] at which the tip is for good 0.15 m ahead of the saw: of resolved and interface layers alike, whatever
    their bins."""
    ahead = values["tip"] - values["saw"]
    late = np.flatnonzero(ahead < 0.15)
    last = late[-1] if len(late) else 0
    if last >= len(ahead) - 1:
        return None
    share = (0.15 - ahead[last]) / (ahead[last + 1] - ahead[last])
    return float(values["saw"][last] + share * (values["saw"][last + 1] - values["saw"][last]))


def fast_speed(values, begin, end):
    """Median speed [m/s] of a crack between two x [m]."""
    x, speed = crack_speed(values["x"], values["arrival"], 2.0)
    return float(np.nanmedian(speed[(x > begin) & (x < end)]))


def settled(dx, cut, slope_angle, interface, length=2.0):
    """Potential energy [J/m] and deflection of the free end [m] of S1: an elastic layer, cut from the start."""
    layer = {"interface": points_on(dx)} if interface else {}
    scene = snowmpm.load_scene("pst_2d", {
        "solver.dx": dx, "materials.weak_layer": WEAK_LAYER, "initial.stress": "geostatic",
        "saw_test.length": length, "saw_test.notch": cut, "saw_test.saw_length": cut, "saw_test.ends": "normal",
        "saw_test.slope_angle": slope_angle,
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": THICKNESS, **layer}})
    simulation = snowmpm.Simulation(scene)
    solver = simulation.solver
    omega = 0.6 * 3.516 * np.sqrt(3e6 / 0.91 * 0.5**2 / 12.0 / 250.0) / (cut + 0.3) ** 2
    solver.damp(0.999)  # no FLIP: it would keep what the grid does not see
    peak, kinetic = 0.0, np.inf
    while solver.time < 3.0 / omega or kinetic > 1e-6 * peak:
        dt, _ = solver.stable_dt()
        solver.damping_factor = 1.0 - 2.0 * omega * dt
        simulation.step()
        if solver.steps % 50 == 0:
            kinetic = float(solver.particles.masses() @ (solver.particles.column("velocity") ** 2).sum(axis=1))
            peak = max(peak, kinetic)
    particles = simulation.particles
    order = np.argsort(particles["id"])
    start = simulation.model.population.positions
    moved = particles["position"][order] - start
    elastic = solver.materials.elastic_energy(particles["material"], particles.kirchhoff(), particles.state(),
                                              particles["volume"] / particles["J"])
    energy = elastic - float(particles["mass"][order] @ (moved @ solver.gravity))
    middle = THICKNESS + 0.25
    row = (np.abs(start[:, 1] - middle) < 1.01 * scene.solver.spacing(2)) & (particles["body"][order] == 1)
    near = row & (start[:, 0] < 0.6 * 0.5 + scene.solver.spacing(2))
    return energy, float(np.polyfit(start[near, 0], -moved[near, 1], 2)[-1])
