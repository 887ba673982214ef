"""Steps are short while bonds of a weak layer break, and long before and after."""

import numpy as np
import pytest

from snowmpm.materials import AnticrackCamClay, DruckerPrager
from snowmpm.stepping.time_step import BREAKING_CFL, BREAKING_SHARE, usual_cfl

WEAK = AnticrackCamClay(density=100.0, youngs_modulus=0.5e6, poisson_ratio=0.3, critical_slope=1.0, cohesion=0.3,
                        hardening=0.5, p0=1.8e3, softening=9.0)
DX = 0.1


def squeezed(make_solver, law=WEAK, **options):
    """A block that is squeezed flat, its top at 1 m/s."""
    return make_solver(2, DX, [0.0, 0.0], [0.4, 0.4], law=law, velocity=lambda x: np.array([0.0, -2.5 * x[1]]),
                       **options)


def test_a_step_is_short_while_bonds_break_and_long_before_and_after(make_solver):
    solver, seen = squeezed(make_solver), []
    long, short = solver.cfl * DX / WEAK.wave_speed(), BREAKING_CFL * DX / WEAK.wave_speed()
    while solver.time < 0.3:
        dt, cause = solver.stable_dt()
        assert cause in ("elastic", "breaking")
        assert dt == pytest.approx(short if cause == "breaking" else long, rel=0.02)  # elastic strain: a per cent
        assert (cause == "breaking") == (solver.extremes.breaking > BREAKING_SHARE * solver.particles.count)
        seen.append(cause)
        solver.step(dt)
    assert seen[0] == seen[-1] == "elastic" and "breaking" in seen


def test_only_what_yields_and_has_bonds_left_counts(make_solver):
    solver = squeezed(make_solver)
    while solver.extremes.breaking == 0:
        solver.step(solver.stable_dt()[0])
    zeta, collapsed = solver.particles.column("state").T
    assert 0 < solver.extremes.breaking <= ((zeta < WEAK.initial_zeta) & (collapsed == 0.0)).sum()


@pytest.mark.parametrize(("beyond", "breaks"), [(1e-6, False), (0.01, True)])
def test_what_creeps_at_its_yield_stress_does_not_break(make_solver, beyond, breaks):
    """beyond: share by which the pressure of a block passes that of yield in one step."""
    law = WEAK.model_copy(update={"softening": 1.0})  # one that does not snap back
    solver = make_solver(2, DX, [0.0, 0.0], [0.4, 0.4], law=law)
    table = solver.particles.table()
    h = np.expm1(-2.0 / 3.0 * law.p0 / law.bulk_modulus * (1.0 + beyond))
    table[:, solver.particles.layout.columns("elastic")] = [h, h, h, 0.0]
    solver.particles.overwrite(table)
    solver.step(1e-9)
    assert solver.n_plastic == solver.particles.count
    assert solver.extremes.breaking == (solver.particles.count if breaks else 0)


def test_a_cfl_of_the_scene_is_that_of_every_step(make_solver):
    solver = squeezed(make_solver, cfl=0.4)
    while solver.extremes.breaking == 0:
        solver.step(solver.stable_dt()[0])
    dt, cause = solver.stable_dt()
    assert cause == "elastic" and dt == pytest.approx(0.4 * DX / WEAK.wave_speed(), rel=0.02)


def test_a_scheme_of_a_short_critical_step_never_goes_beyond_it(make_solver):
    solver = squeezed(make_solver, transfer="pic", gradient="shape")
    assert solver.breaking_cfl <= solver.cfl == usual_cfl(solver.critical_cfl)


@pytest.mark.parametrize(("softening", "breaks"), [(0.05, True), (None, False)])
def test_grains_that_keep_their_cohesion_have_no_bonds_to_lose(make_solver, softening, breaks):
    law = DruckerPrager(density=100.0, youngs_modulus=0.5e6, poisson_ratio=0.3, friction_angle=30.0, cohesion=10.0,
                        softening_strain=softening)
    solver = squeezed(make_solver, law)
    for _ in range(10):
        solver.step(solver.stable_dt()[0])
    assert solver.n_plastic > 0
    assert (solver.extremes.breaking > 0) == breaks
