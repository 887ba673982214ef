"""Bars and notched plates that crack (F1; F2 by grips): the work that breaks them is the card's, on every grid.

A bar of 0.2 m, E = 1 MPa, rho = 1000 kg/m3, f_t = 1 kPa, drawn apart by grips that are too heavy to slow down; one row
of cells in its middle is 2 % weaker. Waves cross it a hundred times meanwhile. Its force is what the grips lose in
momentum, so neither the stress nor the damage of a particle enters the work. Plates: `support/notched_plate.py`.
"""

from functools import cache

import numpy as np
import pytest

from snowmpm.materials import CohesiveCrack
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import AFLIP, APIC, free_solver, lattice
from tests.support import notched_plate

LENGTH, GRIP, WIDE = 0.2, 3, 3  # m, cells
BAR = CohesiveCrack(density=1e3, youngs_modulus=1e6, poisson_ratio=0.0, strength=1e3, fracture_energy=0.5)
STRONG = BAR.model_copy(update={"strength": 1.5e3, "fracture_energy": 2.0})
HEAVY = BAR.model_copy(update={"density": 1e12, "strength": 1e9, "fracture_energy": 1e12})
PULL, SECONDS, SAMPLES = 1.3, 1.2, 400
"""Opening at the end over that at which no cohesion is left, time it takes, and how often the force is read."""


@cache
def draw(cells, f_bar, scheme=APIC, per_axis=2):
    """Opening of the grips [m], force over the section [Pa], damage (particles,), and the particles' columns."""
    dx, law = LENGTH / cells, BAR.on_grid(LENGTH / cells)
    x, volumes = lattice([-LENGTH / 2 - GRIP * dx, 0.0], [LENGTH / 2 + GRIP * dx, WIDE * dx], dx, per_axis)
    grips, weak = np.abs(x[:, 0]) > LENGTH / 2, (x[:, 0] > 0.0) & (x[:, 0] < dx)
    material = np.where(grips, 3, np.where(np.abs(x[:, 0]) > LENGTH / 4, 2, np.where(weak, 1, 0)))
    weaker = law.model_copy(update={"strength": 0.98 * law.strength})
    end = PULL * law.complete_opening + law.strength / law.youngs_modulus * LENGTH
    rate = end / LENGTH / SECONDS
    velocity = np.stack([rate * np.clip(x[:, 0], -LENGTH / 2, LENGTH / 2), 0.0 * x[:, 0]], axis=1)
    solver = free_solver(x, volumes, [law, weaker, STRONG.on_grid(dx), HEAVY.on_grid(dx)], scheme, dx,
                         reach=2 * LENGTH, material=material, velocities=velocity, f_bar=f_bar)
    states = ParticleStates(solver)
    states.set(affine=np.where(grips[:, None], 0.0, [[rate, 0.0, 0.0, 0.0]]))

    def momentum():
        """Of a grip, mean of both, over the section."""
        along = states.column("velocity")[:, 0] * np.sign(x[:, 0])
        return 0.5 * (states.mass * along)[grips].sum() / (WIDE * dx)

    opened, force, before, then = [0.0], [0.0], momentum(), 0.0
    for time in np.linspace(0.0, SECONDS, SAMPLES + 1)[1:]:
        while solver.time < time - 1e-12:
            solver.step(min(solver.stable_dt()[0], time - solver.time))
        now = momentum()
        opened.append(rate * LENGTH * 0.5 * (solver.time + then))
        force.append((before - now) / (solver.time - then))
        before, then = now, solver.time
    return np.array(opened), np.array(force), states.column("state")[:, 0], np.round(x[:, 0] / dx, 2)


def work(*case, **options):
    """Of the grips over the fracture energy of the section."""
    opened, force, *_ = draw(*case, **options)
    return np.trapezoid(force, opened) / BAR.fracture_energy


GRIDS = (20, 30, 40)
asked = pytest.mark.xfail(strict=True, reason="with grad v of each particle its neighbours crack too: 1.29, 1.26, 1.23")


@pytest.mark.slow
@pytest.mark.parametrize("cells", GRIDS)
@pytest.mark.parametrize("f_bar", ["whole", pytest.param(False, marks=asked)])
def test_a_bar_takes_its_fracture_energy_on_every_grid(cells, f_bar):
    """F1. Asked 2 % of the card; a bar at a point, to 1 %, is in materials/test_cohesive_crack.py."""
    assert work(cells, f_bar) == pytest.approx(1.0, rel=0.02)
    *_, damage, column = draw(cells, f_bar)
    assert set(column[damage > 0.0]) == {0.25, 0.75} and damage.max() == 1.0


@pytest.mark.slow
@pytest.mark.parametrize("case", [{"per_axis": 3}, {"scheme": AFLIP}], ids=str)
def test_neither_the_filling_nor_the_transfer_matters(case):
    assert work(20, "whole", **case) == pytest.approx(1.0, rel=0.02)


PLATES = (0.01, 0.0075, 0.006)


@pytest.mark.slow
@pytest.mark.parametrize("case", ["drawn", "bent"])
def test_a_crack_from_a_notch_takes_its_energy_and_the_curve_is_that_of_every_grid(case):
    """F2 asks for curves within 5 % and G_f within 2 %, of a beam on rollers; here grips draw or bend the plate."""
    broken = [notched_plate.broken(dx, case) for dx in PLATES]
    for plate in broken:
        assert plate.work == pytest.approx(1.0, rel=0.02), plate.dx
        assert set(plate.cracked) == {0.25, 0.75}  # one row of cells, straight from the notch
    finest = broken[-1]
    for plate in broken[:-1]:
        off = np.abs(np.interp(finest.opened, plate.opened, plate.force) - finest.force)
        assert off.max() < 0.05 * finest.force.max(), plate.dx


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="without f_bar = whole the neighbours of the crack's row crack too: 1.4 to 1.5")
def test_the_same_without_shared_deformation():
    assert notched_plate.broken(0.01, "drawn", f_bar=False).work == pytest.approx(1.0, rel=0.02)
