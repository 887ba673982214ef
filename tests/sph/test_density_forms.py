"""The four forms of density of Bui & Nguyen (2021), sections 2.2.1 and 2.4, on one state: why volumes follow J.

    rho = sum_j m_j W                                                       (2)
    drho/dt = sum_j m_j (v_i - v_j) . grad_i W                              (50)
    drho/dt = rho_i sum_j V_j (v_i - v_j) . grad_i W                        (51)
    drho/dt = sum_j m_j (v_i - v_j) . grad_i W / theta_i                    (52, 53: smoothing lengths that vary)

The third is what the trace of the plain and of the balanced velocity gradient integrates.
"""

import numpy as np
import pytest

from snowmpm.sph.smoothing import KERNELS
from tests.support.sph_sums import SCHEME, rms, stage

KERNEL, RADIUS = KERNELS[SCHEME["kernel"]], 2.0 * SCHEME["smoothing"]


def summed(solver, density):
    """(2), from the operators: sum V W times the mean of the neighbours."""
    ones = np.ones(len(density))
    whole = solver.operate("coverage", ones)[:, 0] + KERNEL.weight(0.0, RADIUS, 2)
    return whole * solver.operate("shepard", density)[:, 0]


def rates(solver, density, velocity):
    """-> (50) and (51), over the density [1/s]."""
    def divergence(field):
        return np.einsum("naa->n", solver.operate("gradient", field)) / solver.dx

    slope = solver.operate("gradient", density)[:, 0] / solver.dx
    by_masses = -(divergence(density[:, None] * velocity) - (velocity * slope).sum(axis=1)) / density
    return by_masses, -divergence(velocity)


@pytest.fixture(scope="module")
def layers():
    """Unit square of particles out of order, 8 times as heavy below as above, in uniform compression by 1 1/s."""
    solver, x, inner = stage(20, 0.1, rows=3)
    return solver, x, inner, np.where(x[:, 1] < 0.5, 800.0, 100.0), -0.5 * x


def test_masses_in_the_rate_mistake_the_density_of_one_layer_for_that_of_the_other(layers):
    solver, x, inner, density, velocity = layers
    by_masses, by_volumes = rates(solver, density, velocity)
    above = inner & (x[:, 1] > 0.5) & (x[:, 1] < 0.55)
    far = inner & (np.abs(x[:, 1] - 0.5) > 0.2)
    assert np.abs(by_volumes[above] - 1.0).max() < 0.2
    assert by_masses[above].min() > 2.5  # for 1
    np.testing.assert_allclose(by_masses[far], by_volumes[far], rtol=1e-9)


def test_the_sum_of_masses_loses_half_at_a_free_surface(layers):
    solver, x, _, density, _ = layers
    found = summed(solver, density) / density
    top = x[:, 1] > 1.0 + 2.4 / 20
    border = (x[:, 1] > 0.5) & (x[:, 1] < 0.55) & (np.abs(x[:, 0] - 0.5) < 0.4)
    middle = (np.abs(x[:, 0] - 0.5) < 0.4) & (x[:, 1] > 0.7) & (x[:, 1] < 1.0)
    assert np.median(found[top & (np.abs(x[:, 0] - 0.5) < 0.4)]) == pytest.approx(0.75, abs=0.1)
    assert np.median(found[border]) > 2.0  # the heavy layer reaches in
    assert rms(found[middle] - 1.0) < 0.05  # of positions a tenth of a spacing off


def test_the_factor_of_varying_lengths_stays_near_one():
    """theta = 1 - (sum m W - sum m r (-W') / d) / rho: within some percent of 1 but at a free surface, where both sums
    lack their half."""
    solver, x, inner = stage(20, 0.1, rows=3)
    ones = np.ones(len(x))
    trace = sum(solver.operate("gradient", x[:, a])[:, 0, a] for a in range(2)) / solver.dx
    theta = 1.0 - summed(solver, ones) + 0.5 * trace * KERNEL.lattice_moment(RADIUS, 2)
    assert rms(theta[inner] - 1.0) < 0.06
