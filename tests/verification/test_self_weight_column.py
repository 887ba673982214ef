"""An elastic column under its own weight at finite strain (M5), exact with Lambert's W:

    F(Y) = exp(-W(s)),   y(Y) = (M / rho g) [(W + W^2 / 2)(S) - (W + W^2 / 2)(s)],   s = rho g (L - Y) / M,  S = s(0)
    sigma_yy = -rho g (L - Y),   sigma_xx = nu / (1 - nu) sigma_yy

on a base between smooth walls, M = lambda + 2 mu, rho that of the stress-free column. 32 cells high. Relaxed with
damped nodes; elasticity forgets the way there.
"""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import lambertw

from snowmpm.materials import Elastic
from snowmpm.mpm.solver import MpmSolver
from snowmpm.population import Population
from tests.verification.particle_states import ParticleStates
from tests.verification.rigid_walls import block
from tests.verification.schemes import APIC, FLIP, lattice

G, CELLS, WIDTH = 9.81, 32, 4
CUBIC = replace(APIC, kernel="cubic")
SNOW = Elastic(density=250.0, youngs_modulus=3e6, poisson_ratio=0.3)  # settles by 0.3 %
SOFT = Elastic(density=80.0, youngs_modulus=1e4, poisson_ratio=0.0)  # by 23 % at 10 m, by half at 50 m


def exact_height(law, length, Y):
    modulus, weight = law.density * law.wave_speed() ** 2, law.density * G
    def potential(Y):
        w = lambertw(weight * (length - Y) / modulus).real
        return w + 0.5 * w**2
    return modulus / weight * (potential(0.0) - potential(Y))


def column(law, length, scheme, offset, angle, width=WIDTH):
    """-> solver, and the base and axes (2, 2) of the column. offset: of base and walls from a node [cells], for a
    column along the grid; angle: by which the set-up is turned, of walls that are blocks [rad]; None: sides of the
    domain. width: in cells."""
    dx = length / CELLS
    x, volumes = lattice([0.0, 0.0], [width * dx, length], dx)
    if angle is None:
        base, axes = np.full(2, offset * dx), np.eye(2)
        options = dict(lower=base, upper=base + np.array([width * dx, 1.1 * length]), origin=np.zeros(2),
                       sides=[["slip", "slip"], ["stick", "open"]])
    else:
        base = np.array([0.37, 0.61]) * dx
        axes = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        right, up = axes
        foot, half = base + 0.5 * width * dx * right, base + 0.5 * length * up
        walls = [block(foot, up, 3 * length, "slip"), block(half, right, 3 * length, "slip"),
                 block(half + width * dx * right, -right, 3 * length, "slip")]
        corners = base + x @ axes
        lower, upper = corners.min(axis=0) - 4 * dx, corners.max(axis=0) + 4 * dx
        options = dict(lower=lower, upper=upper, origin=dx * np.floor(lower / dx), obstacles=walls)
    solver = MpmSolver(Population(base + x @ axes, volumes, 0), [law], dx=dx, precision="f64", gravity=-G * axes[1],
                       **options, **scheme.options)
    return solver, base, axes


def settle(solver, law, length):
    while solver.time < 20.0 * length / law.wave_speed():
        dt = solver.stable_dt()[0]
        solver.keep = 1.0 - 0.1 * dt * law.wave_speed() / solver.dx
        solver.step(dt)


def errors(law, length, scheme, offset=0.0, angle=None):
    """Largest error of a height over the settlement, largest and root mean square errors of the stresses over the
    pressure at the base."""
    solver, base, axes = column(law, length, scheme, offset, angle)
    states = ParticleStates(solver)
    Y = ((states.reference - base) @ axes.T)[:, 1]
    settle(solver, law, length)
    exact = exact_height(law, length, Y)
    height = ((states.positions() - base) @ axes.T)[:, 1]
    tau = states.column("stress") / states.column("volume_ratio")
    sigma = np.einsum("ia,nab,jb->nij", axes, tau[:, [0, 3, 3, 1]].reshape(-1, 2, 2), axes)
    pressure, nu = law.density * G * (length - Y), law.poisson_ratio
    off = np.stack([sigma[:, 1, 1] + pressure, sigma[:, 0, 0] + nu / (1.0 - nu) * pressure]) / pressure.max()
    settlement = length - exact_height(law, length, length)
    return np.abs(height - exact).max() / settlement, np.abs(off).max(), np.sqrt((off**2).mean())


@pytest.mark.parametrize(("scheme", "law"), [(APIC, SNOW), (APIC, SOFT), (CUBIC, SOFT), (FLIP, SOFT)])
def test_settlement_and_stress(scheme, law):
    height, largest, typical = errors(law, 10.0, scheme)
    assert height < 0.001  # a tenth of what M5 asks
    assert largest < 0.02 and typical < 0.005


@pytest.mark.parametrize(("law", "offset", "angle"), [
    (SNOW, 1 / 3, None), (SOFT, 1 / 3, None), (SNOW, 0.0, np.pi / 2)])
def test_wherever_the_column_lies_in_the_grid(law, offset, angle):
    height, largest, typical = errors(law, 10.0, APIC, offset, angle)
    assert height < 0.002
    assert largest < 0.025 and typical < 0.005  # largest: at the foot of a wall


def test_settlement_turned_by_thirty_degrees():
    """Of the top of a column 12 cells wide. At an inner corner of oblique walls the test functions, which vanish on a
    wall in the mean over a cell only, are cut: an error of the force there, of which the top feels less the wider the
    column (2.0 % at 4 cells)."""
    length = 10.0
    solver, base, axes = column(SNOW, length, APIC, 0.0, np.pi / 6, width=12)
    states = ParticleStates(solver)
    Y = ((states.reference - base) @ axes.T)[:, 1]
    settle(solver, SNOW, length)
    top = 0.95 * length < Y
    missed = (((states.positions() - base) @ axes.T)[:, 1] - exact_height(SNOW, length, Y))[top].mean()
    assert abs(missed) < 0.01 * (length - exact_height(SNOW, length, length))


@pytest.mark.xfail(strict=True, reason="inner corners of walls oblique to the grid: stress off by half of the pressure")
def test_stress_turned_by_thirty_degrees():
    _, largest, _ = errors(SNOW, 10.0, APIC, angle=np.pi / 6)
    assert largest < 0.02


def test_half_its_height():
    """L = 50 m: every particle crosses cells; the base is squeezed to 0.18."""
    height, largest, typical = errors(SOFT, 50.0, CUBIC)
    assert exact_height(SOFT, 50.0, 50.0) == pytest.approx(24.2330658728, rel=1e-10)
    assert height < 0.001 and typical < 0.02 and largest < 0.1
