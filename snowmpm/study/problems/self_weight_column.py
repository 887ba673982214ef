"""An elastic column under its own weight at finite strain (M5), exact with Lambert's W:

    F(Y) = exp(-W(s)),   y(Y) = (M / rho g) [(W + W^2 / 2)(S) - (W + W^2 / 2)(s)],   s = rho g (L - Y) / M,  S = s(0)
    sigma_yy = -rho g (L - Y),   sigma_xx = nu / (1 - nu) sigma_yy

on a base between smooth walls, M = lambda + 2 mu, rho that of the stress-free column. 32 cells high. Relaxed with
damped nodes; elasticity forgets the way there.
"""

import numpy as np
from scipy.special import lambertw

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.rigid_walls import block
from snowmpm.study.problems.schemes import lattice

G, CELLS, WIDTH = 9.81, 32, 4
SNOW = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)  # settles by 0.3 %
SOFT = Elastic(density=80.0, youngs_modulus=1e4, poisson_ratio=0.0)  # by 23 % at 10 m, by half at 50 m


def exact_height(law, length, Y):
    """Height [m] of the points that were Y [m] high without weight."""
    modulus, weight = law.density * law.wave_speed() ** 2, law.density * G

    def potential(Y):
        w = lambertw(weight * (length - Y) / modulus).real
        return w + 0.5 * w**2
    return modulus / weight * (potential(0.0) - potential(Y))


def column(law, length, scheme, offset, angle, width=WIDTH, cells=CELLS, per_axis=2, free=False):
    """-> solver, and the base and axes (2, 2) of the column. offset: of base and walls from a node [cells], for a
    column along the grid; angle: by which the set-up is turned, of walls that are blocks [rad]; None: sides of the
    domain. width: in cells. free: without walls, on a base that holds it, for a law with nu = 0 (turned only)."""
    dx = length / cells
    x, volumes = lattice([0.0, 0.0], [width * dx, length], dx, per_axis)
    if angle is None:
        base, axes = np.full(2, offset * dx), np.eye(2)
        options = dict(lower=base, upper=base + np.array([width * dx, 1.1 * length]), origin=np.zeros(2),
                       sides=[["slip", "slip"], ["stick", "open"]])
    else:
        base = np.array([0.37, 0.61]) * dx
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        right, up = axes
        foot, half = base + 0.5 * width * dx * right, base + 0.5 * length * up
        walls = [block(foot, up, 3 * length, "stick" if free else "slip")]
        if not free:
            walls += [block(half, right, 3 * length, "slip"),
                      block(half + width * dx * right, -right, 3 * length, "slip")]
        corners = base + x @ axes
        lower, upper = corners.min(axis=0) - 4 * dx, corners.max(axis=0) + 4 * dx
        options = dict(lower=lower, upper=upper, origin=dx * np.floor(lower / dx), obstacles=walls)
    solver = scheme.solver(Population(base + x @ axes, volumes, 0), [law], dx=dx, gravity=-G * axes[1], **options)
    return solver, base, axes


def settle(solver, law, length):
    """Damp the nodes until the column rests."""
    while solver.time < 20.0 * length / law.wave_speed():
        dt = solver.stable_dt()[0]
        solver.damping_factor = 1.0 - 0.1 * dt * law.wave_speed() / solver.dx
        solver.step(dt)


def settled_errors(law, length, scheme, offset=0.0, angle=None, **how):
    """Settle a `column`; -> where its particles were [cells from the foot on its left], errors of their heights over
    the settlement, and of (sigma_yy, sigma_xx) over the pressure at the base (n, 2)."""
    solver, base, axes = column(law, length, scheme, offset, angle, **how)
    states = ParticleStates(solver)
    place = (states.reference - base) @ axes.T
    settle(solver, law, length)
    height = ((states.positions() - base) @ axes.T)[:, 1]
    tau = states.column("stress") / states.column("volume_ratio")
    sigma = np.einsum("ia,nab,jb->nij", axes, tau[:, [0, 3, 3, 1]].reshape(-1, 2, 2), axes)
    pressure, nu = law.density * G * (length - place[:, 1]), law.poisson_ratio
    off = np.stack([sigma[:, 1, 1] + pressure, sigma[:, 0, 0] + nu / (1.0 - nu) * pressure], axis=1) / pressure.max()
    settlement = length - exact_height(law, length, length)
    return place / solver.dx, (height - exact_height(law, length, place[:, 1])) / settlement, off


def column_errors(law, length, scheme, offset=0.0, angle=None, cells=CELLS, per_axis=2):
    """Largest error of a height over the settlement, largest and root mean square errors of the stresses over the
    pressure at the base."""
    _, height, off = settled_errors(law, length, scheme, offset, angle, cells=cells, per_axis=per_axis)
    return np.abs(height).max(), np.abs(off).max(), np.sqrt((off**2).mean())
