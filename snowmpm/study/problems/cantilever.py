"""A cantilever in plane strain (M11): its first mode, and how far it hangs under its own weight.

EI = E' t^3 / 12, E' = E / (1 - nu^2). Slender beam: first frequency (1.875104^2 / 2 pi L^2) sqrt(E' t^2 / 12 rho), end
down by q L^4 / 8 EI, to which shear adds q L^2 / 2 k G A, k = 5/6.
"""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, lattice

LENGTH = 1.0
SMALL_LOAD, THICKNESS = 0.05, 0.1
"""q L^3 / EI, and thickness [m], of the small deflection."""


def beam(law, scheme, thickness, cells, gravity=0.0, velocity=None, per_axis=2):
    """Solver of a beam clamped half a cell off the nodes, `cells` of them through its thickness [m].

    velocity: of points (n, 2) from the clamp and the axis."""
    dx = thickness / cells
    positions, volumes = lattice([0.0, -0.5 * thickness], [LENGTH, 0.5 * thickness], dx, per_axis)
    population = Population(positions + np.array([0.5 * dx, 1.5]), volumes, 0, velocity and velocity(positions))
    return scheme.solver(population, [law], dx=dx, origin=np.zeros(2), lower=np.array([0.5 * dx, 0.0]),
                         upper=np.array([1.5, 2.0]), gravity=np.array([0.0, -gravity]),
                         sides=[["stick", "open"], ["open", "open"]])


def first_mode(x):
    """Deflection and slope of the first mode at x / L; amplitude 2 at the end."""
    k = 1.875104069
    share = (np.cosh(k) + np.cos(k)) / (np.sinh(k) + np.sin(k))
    z = k * x
    return (np.cosh(z) - np.cos(z) - share * (np.sinh(z) - np.sin(z)),
            k * (np.sinh(z) + np.sin(z) - share * (np.cosh(z) - np.cos(z))))


def law():
    """Of a slender beam that hangs: no contraction across."""
    return Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=0.0)


def hang(load, thickness, scheme=APIC, cells=6, per_axis=2):
    """Way of the end, in and up, over L, under q L^3 / EI = `load`; critically damped."""
    gravity = load * 1e6 * thickness**2 / (12.0 * 1000.0 * LENGTH**3)
    solver = beam(law(), scheme, thickness, cells, gravity, per_axis=per_axis)
    states = ParticleStates(solver)
    omega = 1.875104069**2 / LENGTH**2 * np.sqrt(1e6 * thickness**2 / 12.0 / 1000.0)
    while solver.time < 12.0 / omega:
        dt = solver.stable_dt()[0]
        solver.damping_factor = 1.0 - 2.0 * omega * dt
        solver.step(dt)
    last = np.abs(states.reference[:, 0] - states.reference[:, 0].max()) < 1e-9
    return (states.positions() - states.reference)[last].mean(axis=0) / LENGTH


def small_deflection():
    """Of the end under SMALL_LOAD over L, by bending and shear (nu = 0)."""
    bending = SMALL_LOAD / 8.0
    return bending + bending * 4.0 * (THICKNESS**2 / 12.0) * 2.0 / (5.0 / 6.0)
