"""An elastic column under its own weight at finite strain (M5), exact with Lambert's W:

    F(Y) = exp(-W(s)),   y(Y) = (M / rho g) [(W + W^2 / 2)(S) - (W + W^2 / 2)(s)],   s = rho g (L - Y) / M,  S = s(0)
    sigma_yy = -rho g (L - Y),   sigma_xx = nu / (1 - nu) sigma_yy

on a base between smooth walls, M = lambda + 2 mu, rho that of the stress-free column. 32 cells high. Relaxed with
damped nodes; elasticity forgets the way there.
"""

import numpy as np

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
    from scipy.special import lambertw  # slow to import

    modulus, weight = law.density * law.wave_speed() ** 2, law.density * G

    def potential(Y):
        w = lambertw(weight * (length - Y) / modulus).real
        return w + 0.5 * w**2
    return modulus / weight * (potential(0.0) - potential(Y))


def column(law, length, scheme, offset, angle, width=WIDTH, cells=CELLS, per_axis=2, free=False):
    """Column of one law that stands on a base under its own weight: returns (solver, base (2,) [m], axes (2, 2)).

    base: lower left corner; rows of axes: unit vectors along the base and up the column. length: height [m], of `cells`
    cells; width [cells]; per_axis: particles a cell and axis; scheme: `Scheme`.
    angle: None, or the angle [rad] by which column and gravity are turned. With None, base and walls are sides of the
    domain, `offset` cells from a node. Otherwise they are blocks, and `offset` has no effect.
    free: without walls, on a base that holds the column; for a turned one, and a law with nu = 0.
    """
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
    """Advance the solver with damped nodes until the column of `length` [m] rests: 20 wave transits."""
    while solver.time < 20.0 * length / law.wave_speed():
        dt = solver.stable_dt()[0]
        solver.damping_factor = 1.0 - 0.1 * dt * law.wave_speed() / solver.dx
        solver.step(dt)


def settled_errors(law, length, scheme, offset=0.0, angle=None, **how):
    """Settle a `column` and compare it with the exact answer; further arguments go to `column`.

    Returns where its n particles were at first (n, 2) [cells from the lower left corner, along its axes].
    Returns besides errors of their heights (n,), over the settlement of the top, and errors of (sigma_yy, sigma_xx),
    (n, 2), over the largest pressure.
    """
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
    """Errors of a settled `column`, all relative: largest of a height, largest and root mean square of the stresses.

    A height is relative to the settlement, a stress to the largest pressure (`settled_errors`).
    """
    _, height, off = settled_errors(law, length, scheme, offset, angle, cells=cells, per_axis=per_axis)
    return np.abs(height).max(), np.abs(off).max(), np.sqrt((off**2).mean())
