"""Choices of [solver.sph] that are no default: what goes wrong without each, and that it is right with it."""

import numpy as np
import pytest

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.scenes.numerics import Sph
from snowmpm.sph.solver import SphSolver
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import lattice
from tests.support.sph_block import ICE, solver_of

DX = 0.1
AROUND = [["periodic", "periodic"]] * 2


@pytest.mark.parametrize(("form", "quiet"), [("density", False), ("volume", True)])
def test_unlike_densities_under_one_pressure(form, quiet):
    """Snow on ice, eight times as heavy: a uniform pressure pushes nothing. Squared densities let it push the particles
    at the border, by p / (rho dx) of the light ones."""
    snow, pressure = ICE.model_copy(update={"density": ICE.density / 8.0}), 100.0
    positions, volumes = lattice([0.0, 0.0], [16 * DX, 16 * DX], DX, 1)
    material = (positions[:, 1] > 8 * DX).astype(int)
    stress = -pressure * np.tile([1.0, 1.0, 1.0, 0.0], (len(positions), 1))
    elastic = ICE.h_from_stress(-pressure * np.eye(3))[0, 0] * np.array([1.0, 1.0, 1.0, 0.0])
    solver = SphSolver(Population(positions, volumes, material, None, np.tile(elastic, (len(positions), 1)), stress),
                       [ICE, snow], dx=DX, precision="f64", origin=np.zeros(2), lower=np.zeros(2),
                       upper=np.full(2, 16 * DX), gravity=np.zeros(2), sides=AROUND, scheme=Sph(momentum=form))
    dt = 1e-6
    solver.step(dt)
    pushed = np.abs(solver.particles.column("velocity")).max() / (dt * pressure / (snow.density * DX))
    assert pushed < 1e-8 if quiet else pushed > 0.3


@pytest.mark.parametrize(("beta", "holds"), [(0.0, False), (2.0, True)])
def test_particles_that_fly_into_each_other(beta, holds):
    """Two soft bars that meet at once their sound speed: without the quadratic viscosity their particles end up in each
    other."""
    from scipy.spatial import cKDTree

    soft = Elastic(density=300.0, youngs_modulus=1e4, poisson_ratio=0.3)
    positions, volumes = lattice([-20 * DX, 0.0], [20 * DX, 4 * DX], DX, 1)
    speed = 0.5 * soft.wave_speed()
    solver = solver_of(positions, volumes, soft, dx=DX, lower=[-80 * DX, 0.0], upper=[80 * DX, 4 * DX],
                       velocity=lambda x: np.stack([-speed * np.sign(x[:, 0]), 0.0 * x[:, 0]], axis=1),
                       sides=[["open", "open"], ["slip", "slip"]],
                       scheme={"quadratic_viscosity": beta, "disorder_damping": 0.0})
    least = 1.0
    while solver.time < 10 * DX / speed:
        for _ in range(5):
            solver.step(solver.stable_dt()[0])
        tree = cKDTree(solver.particles.positions())
        least = min(least, tree.query(tree.data, k=2)[0][:, 1].min())
    assert (least > 0.25 * DX) == holds, least / DX


@pytest.mark.parametrize(("kind", "left"), [("none", (0.9, 1.1)), ("diffusion", (0.0, 0.05))])
def test_stress_that_alternates_from_particle_to_particle(kind, left):
    """Of a sign that changes like the squares of a chessboard: forces do not feel it, and it stays for ever."""
    positions, volumes = lattice([0.0, 0.0], [16 * DX, 16 * DX], DX, 1)
    sign = (-1.0) ** np.round(positions / DX - 0.5).sum(axis=1)
    solver = solver_of(positions, volumes, dx=DX, stress=10.0 * sign[:, None, None] * np.eye(3), lower=[0.0, 0.0],
                       upper=[16 * DX, 16 * DX], sides=AROUND, scheme={"regularisation": kind})
    states = ParticleStates(solver)
    for _ in range(100):
        solver.step(solver.stable_dt()[0])
    share = (states.column("stress")[:, 1] * sign).mean() / 10.0
    assert left[0] < share < left[1]


@pytest.mark.parametrize("dim", [2, 3])
def test_artificial_stress_takes_nothing_from_a_uniform_tension(dim):
    """Half of a bar in tension gains what the section through its middle carries; on a lattice that is all of it."""
    tension, across = 10.0, 8
    positions, volumes = lattice([0.0] * dim, [12 * DX, *[across * DX] * (dim - 1)], DX, 1)
    stress = np.zeros((3, 3))
    stress[0, 0] = tension
    lower, upper = np.zeros(dim), np.full(dim, across * DX)
    lower[0], upper[0] = -12 * DX, 24 * DX
    solver = solver_of(positions, volumes, dx=DX, stress=stress, lower=lower, upper=upper,
                       sides=[["open", "open"], *[["periodic", "periodic"]] * (dim - 1)],
                       scheme={"artificial_stress": 0.5})
    solver.step(1e-6)
    left = solver.particles.positions()[:, 0] < 6 * DX
    momentum = solver.particles.masses()[left] @ solver.particles.column("velocity")[left, 0]
    assert momentum / (1e-6 * tension * (across * DX) ** (dim - 1)) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize(("volumes", "seen"), [("follow", 1.5), ("constant", 1.0)])
def test_volumes_in_sums(volumes, seen):
    """Of particles that have grown by half and stayed where they are: what others see of them."""
    positions, volume = lattice([0.0, 0.0], [8 * DX, 8 * DX], DX, 1)
    solver = solver_of(positions, volume, dx=DX, scheme={"volumes": volumes})
    solver.sort()
    before = solver.operate("coverage", positions[:, 0])
    table = solver.particles.table()
    table[:, solver.particles.layout.columns("volume_ratio")] = 1.5
    solver.particles.overwrite(table)
    solver.sort()
    np.testing.assert_allclose(solver.operate("coverage", positions[:, 0]), seen * before, rtol=1e-12)


def test_lengths_follow_no_constant_volumes():
    with pytest.raises(ValueError, match='must be "constant" where volumes are'):
        Sph(volumes="constant", lengths="mean")
