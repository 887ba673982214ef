"""SPH on snow and sand: a slab that slides off over its own grains (M15), an oedometer with a moving wall (M17).

The slab by default, with three times the viscosity, without the damping of disorder, and with a narrower kernel.
"""

import numpy as np
import pytest

from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Sph
from snowmpm.sph.solver import SphSolver
from snowmpm.study.problems.granular_slab import STEEP, G, exact_acceleration, gained, granular, pressed
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import lattice
from tests.support.pressed_column import EXACT, HEIGHT, SET_A, SET_C, WIDTH
from tests.support.sph_block import solver_of


def slab_acceleration(sine, **scheme):
    law, depth, dx = granular(np.arcsin(sine)), 0.4, 0.02
    positions, volumes = lattice([0.0, 0.0], [8 * dx, depth], dx, 1)
    state, ratio = pressed(law, positions[:, 1], depth, STEEP)
    solver = SphSolver(Population(positions, volumes, 0, **state), [law], dx=dx, precision="f64", origin=np.zeros(2),
                       lower=np.zeros(2), upper=np.array([8 * dx, 2 * depth]),
                       gravity=G * np.array([np.sin(STEEP), -np.cos(STEEP)]),
                       sides=[["periodic", "periodic"], ["stick", "open"]], scheme=Sph(**scheme))
    return gained(solver, ratio, positions[:, 1] > depth - 2 * dx, np.array([1.0, 0.0]))


@pytest.mark.slow
@pytest.mark.parametrize(("sine", "scheme"), [
    (0.5, {}), (0.5867 / np.sqrt(3.0), {}), (0.5, {"viscosity": 0.3}), (0.5, {"disorder_damping": 0.0}),
    (0.5, {"viscosity": 0.3, "smoothing": 1.2})], ids=str)
def test_slab_on_rough_ground(sine, scheme):
    assert slab_acceleration(sine, **scheme) == pytest.approx(exact_acceleration(sine), rel=0.03)


@pytest.mark.parametrize(("name", "law"), [("A", SET_A), pytest.param("C", SET_C, marks=pytest.mark.slow)])
def test_oedometer_by_a_moving_wall(name, law):
    c, dx = law.wave_speed(), 1 / 40
    piston = block([WIDTH / 2, HEIGHT], [0.0, -1.0], 2.0, "separate", velocity=[0.0, -1e-3 * c], ramp=4 * HEIGHT / c)
    positions, volumes = lattice([0.0, 0.0], [WIDTH, HEIGHT], dx, 1)
    solver = solver_of(positions, volumes, law, dx=dx, lower=[0.0, 0.0], upper=[WIDTH, 1.5 * HEIGHT],
                       sides=[["slip", "slip"], ["slip", "open"]], obstacles=[piston])

    def way():
        return piston.motion.start_centre[1] - piston.motion.pose(solver.time).centre[1]

    for strain, (axial, p, q) in EXACT[name].items():
        goal, start = HEIGHT * (1.0 - np.exp(-strain)), None
        while way() < goal:
            solver.step(solver.stable_dt()[0])
            if start is None and way() > 0.985 * goal:
                start = solver.time, solver.obstacle_totals[0, 1]
        force = (solver.obstacle_totals[0, 1] - start[1]) / (solver.time - start[0]) / WIDTH
        stress = solver.particles.column("stress") / solver.particles.column("volume_ratio")
        assert -force == pytest.approx(axial, rel=0.02)
        assert stress[:, 1].mean() == pytest.approx(axial, rel=0.02)
        assert stress[:, 0].mean() == pytest.approx(-(p - q / 3.0) * np.exp(strain), rel=0.03)
