"""One return map, two methods: on a homogeneous deformation MPM and SPH give the stress path of `MaterialPoint`.

Every particle keeps the velocity G X that it starts with, so F(t) = I + t G, the same everywhere. A density of 1e24
kg/m3 keeps forces from changing that, and the laws know no density. SPH with the corrected gradient, which sees that
motion as it is at the free surface of the block too.
"""

import numpy as np
import pytest

from snowmpm.materials import CohesiveCamClay, DruckerPrager, Hypoplastic, MaterialPoint, pack
from snowmpm.mpm.solver import MpmSolver
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import solver_of

HEAVY = 1e24
LAWS = {name: law.model_copy(update={"density": HEAVY}) for name, law in {  # beyond what a scene may ask for
    "cohesive_cam_clay": CohesiveCamClay(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3, critical_slope=1.2,
                                         cohesion=0.3, hardening=1.0, p0=2e3),
    "drucker_prager": DruckerPrager(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.3, friction_angle=30.0),
    "hypoplastic": Hypoplastic(density=1000.0, youngs_modulus=20e6, poisson_ratio=0.2, friction_angle=30.0,
                               reference_pressure=1e5),
}.items()}
STEPS, TIME = 40, 1.0
RATE = {2: np.array([[-0.01, 0.02], [0.005, -0.03]]),
        3: np.array([[-0.01, 0.02, 0.0], [0.005, -0.03, 0.01], [0.0, -0.01, -0.02]])}
START = {"hypoplastic": -1e4 * np.eye(3)}


def sph(law, dim, stress):
    positions, volumes = lattice([0.0] * dim, [0.5] * dim, 0.1, 1)
    return solver_of(positions, volumes, law, dx=0.1, velocity=lambda x: x @ RATE[dim].T, stress=stress,
                     scheme={"viscosity": 0.0, "gradient": "corrected"})


def mpm(law, dim, stress):
    positions, volumes = lattice([0.0] * dim, [0.5] * dim, 0.1, 1)
    template = sph(law, dim, stress)
    order = np.argsort(template.particles.labels()[:, 1])
    elastic, tau = (template.particles.column(name)[order] for name in ("elastic", "stress"))
    solver = MpmSolver(Population(positions, volumes, 0, positions @ RATE[dim].T, elastic, tau), [law],
                       dx=0.2, precision="f64", origin=np.full(dim, -2.0), lower=np.full(dim, -2.0),
                       upper=np.full(dim, 3.0), gravity=np.zeros(dim))
    return solver


@pytest.mark.parametrize(("name", "dim", "make"), [
    ("cohesive_cam_clay", 2, sph), ("drucker_prager", 3, sph), ("hypoplastic", 2, sph), ("cohesive_cam_clay", 2, mpm),
    pytest.param("drucker_prager", 3, mpm, marks=pytest.mark.slow), ("hypoplastic", 2, mpm)])
def test_stress_path(name, dim, make):
    law, start = LAWS[name], START.get(name, np.zeros((3, 3)))
    F = np.tile(np.eye(3), (STEPS + 1, 1, 1))
    # Stiffness grows with pressure in hypoplasticity: less strain for the same digits
    time = 0.2 * TIME if name in START else TIME
    F[:, :dim, :dim] += np.linspace(0.0, time, STEPS + 1)[:, None, None] * RATE[dim]
    exact = MaterialPoint(law, dimension=dim).drive(F[:, :dim, :dim], time / STEPS, start if name in START else None)
    solver = make(law, dim, start)
    scale = np.abs(exact.kirchhoff).max()
    for n in range(1, STEPS + 1):
        if make is mpm:  # whose particles carry a gradient on from where they were, not where they are
            L = RATE[dim] @ np.linalg.inv(F[n - 1, :dim, :dim])
            ParticleStates(solver).set(affine=np.tile(L.ravel(), (solver.particles.count, 1)))
        solver.step(time / STEPS)
        tau = solver.particles.column("stress")
        assert np.abs(tau - pack(exact.kirchhoff[n], solver.dim)).max() < 1e-6 * scale
    assert scale > 100.0
