"""Snow pressed by a piston between smooth walls (M17), against the exact path of cohesive Cam-Clay in uniaxial strain.

Reference (validation T1.3; integrated to 1e-11): at the strain x = -ln J, Cauchy stress along the axis and mean
Kirchhoff pressure p and q, of which the lateral Cauchy stress is -(p - q / 3) e^x. A column of 0.5 m x 0.2 m, 20 cells
high; the piston goes at 1e-3 c_p, a tenth of which would change nothing that is measured here.
"""

import numpy as np
import pytest

from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import APIC, FLIP, lattice
from tests.support.pressed_column import EXACT, HEIGHT, SET_A, SET_C, WIDTH

DX, SPEED = 1 / 40, 1e-3


def press(law, scheme, strains):
    """At each strain: Cauchy stresses (n, 4) of the particles, and the piston's mean stress over its last 1.5 %."""
    c = law.wave_speed()
    piston = block([WIDTH / 2, HEIGHT], [0.0, -1.0], 2.0, "separate", velocity=[0.0, -SPEED * c], ramp=4 * HEIGHT / c)
    positions, volumes = lattice([0.0, 0.0], [WIDTH, HEIGHT], DX)
    solver = MpmSolver(Population(positions, volumes, 0), [law], dx=DX, precision="f64", origin=np.zeros(2),
                       lower=np.zeros(2), upper=np.array([WIDTH, 1.5 * HEIGHT]), gravity=np.zeros(2),
                       sides=[["slip", "slip"], ["slip", "open"]], obstacles=[piston], **scheme.options)
    states = ParticleStates(solver)

    def way():
        return piston.motion.start_centre[1] - piston.motion.pose(solver.time).centre[1]

    for strain in strains:
        goal, start = HEIGHT * (1.0 - np.exp(-strain)), None
        while way() < goal:
            dt, left = solver.stable_dt()[0], (goal - way()) / (SPEED * c)
            solver.step(min(dt, max(left, 1e-3 * dt)))  # to end at the goal, not up to a step beyond
            if start is None and way() > 0.985 * goal:
                start = solver.time, solver.obstacle_totals[0, 1]
        force = (solver.obstacle_totals[0, 1] - start[1]) / (solver.time - start[0]) / WIDTH
        yield strain, states.column("stress") / states.column("volume_ratio"), force, solver.unconverged


@pytest.mark.parametrize(("name", "law", "scheme"), [("A", SET_A, APIC), ("A", SET_A, FLIP), ("C", SET_C, APIC)])
def test_stress_of_the_path(name, law, scheme):
    for strain, stress, force, unconverged in press(law, scheme, EXACT[name]):
        axial, p, q = EXACT[name][strain]
        lateral = -(p - q / 3.0) * np.exp(strain)
        assert stress[:, 1].mean() == pytest.approx(axial, rel=0.002)
        np.testing.assert_allclose(stress[:, 1], axial, rtol=0.03)  # rows of particles beside the walls
        assert stress[:, 0].mean() == pytest.approx(lateral, rel=0.005)
        assert -force == pytest.approx(axial, rel=0.01)  # the area stays: nominal and Cauchy stress are one
        assert unconverged == 0
