"""Flow through material cells in a skeleton at rest (P3): steady states and consolidation against closed forms."""

import numpy as np
import pytest

from snowmpm.water.cells import MaterialCells
from snowmpm.water.diffusion import diffuse
from snowmpm.water.flux import TwoPointFlux, solve
from tests.support.soaked_column import C_V, E_OED, K_W, POROSITY, consolidation, terzaghi

MOBILITY = 1e-3 / 9810.0
STORAGE = 1.0 / E_OED + POROSITY / K_W


def column(n):
    """Cells of a column of n, and which border faces are its top."""
    cells = MaterialCells(np.stack([np.zeros(n, int), np.arange(n)], axis=1))
    return cells, (cells.border_axis == 1) & (cells.border_sign > 0)


def consolidated(n, dt, time):
    """Excess pressure over its start at the cell centres of Terzaghi's column, 1 m high, and the water that left over
    what it held too much."""
    cells, top = column(n)
    dx, p, out = 1.0 / n, np.ones(n), 0.0
    for _ in range(round(time / dt)):
        p, flux = diffuse(cells, dx, p, dt, volume=np.full(n, dx**2), capacity=STORAGE, conductivity=MOBILITY, held=top)
        out += dt * flux.sum()
    return p, out / (STORAGE * dx)


def error(n, dt, time):
    depth = 1.0 - (np.arange(n) + 0.5) / n
    return np.abs(consolidated(n, dt, time)[0] - terzaghi(depth, C_V * time)).max()


@pytest.mark.parametrize(("n", "dt", "time", "known"), [
    (40, 1e-3, 0.1, 0.0015), (40, 1e-2, 0.1, 0.0136), (10, 1e-3, 0.1, 0.0045), (10, 1e-2, 0.1, 0.0165),
    (40, 1e-3, 0.02, 0.0079), (40, 1e-2, 0.02, 0.068), (40, 1e-4, 0.1, 0.0003), (40, 1e-4, 0.02, 0.0017)])
def test_consolidation_without_deformation(n, dt, time, known):
    """Errors are those of an independent one-dimensional program, to their last digit."""
    digit = 10.0 ** -(4 if known < 0.05 else 3)
    assert error(n, dt, time) == pytest.approx(known, abs=0.6 * digit)


def test_table_of_terzaghi():
    """Pressures at T = .1, .5 and the degree of consolidation, from the table of the case."""
    for T, pressures, U in ((0.1, (0.1769, 0.4238, 0.7357, 0.9013, 0.9493), 0.3568),
                            (0.5, (0.0580, 0.1419, 0.2622, 0.3426, 0.3708), 0.7640)):
        np.testing.assert_allclose(terzaghi([0.1, 0.25, 0.5, 0.75, 1.0], T), pressures, atol=5e-5)
        p, out = consolidated(40, T / C_V / 400, T / C_V)
        depth = 1.0 - (np.arange(40) + 0.5) / 40
        np.testing.assert_allclose(p, terzaghi(depth, T), atol=2e-3)
        assert consolidation(T) == pytest.approx(U, abs=5e-5)
        assert out == pytest.approx(U, abs=1e-3) and out == pytest.approx(1.0 - p.mean(), rel=1e-12)


def test_orders():
    """Of second order in space, of first in time."""
    fine = [np.log2(error(n, 0.4 / n**2, 0.1) / error(2 * n, 0.1 / n**2, 0.1)) for n in (8, 16)]
    assert fine == pytest.approx([2.0, 2.0], abs=0.1)
    late = np.log2(error(64, 2e-2, 0.1) / error(64, 1e-2, 0.1))
    assert late == pytest.approx(1.0, abs=0.1)


def test_layers_in_series():
    """A steady flow through layers is dp / sum (d / c), exactly."""
    cells, top = column(6)
    conductivity, dx = np.array([1.0, 1.0, 0.01, 5.0, 5.0, 0.2]), 0.5
    bottom = (cells.border_axis == 1) & (cells.border_sign < 0)
    _, flux = diffuse(cells, dx, np.zeros(6), 1e12, volume=np.full(6, dx**2), capacity=1.0, conductivity=conductivity,
                      held=top | bottom, value=np.where(bottom, 3.0, 0.0))
    expected = 3.0 / (dx / conductivity).sum() * dx
    assert flux[top].sum() == pytest.approx(expected, rel=1e-9)
    assert flux[bottom].sum() == pytest.approx(-expected, rel=1e-9)


def test_heat_of_a_source():
    """Sunlight in a layer between cold ends: u = s z (h - z) / (2 c), off by s dx² / (8 c); all heat leaves."""
    n, dx, c, s = 16, 0.05, 0.3, 40.0
    cells, _ = column(n)
    ends = cells.border_axis == 1
    u, flux = diffuse(cells, dx, np.full(n, -5.0), 1e12, volume=np.full(n, dx**2), capacity=6e5, conductivity=c,
                      held=ends, source=s)
    z = dx * (np.arange(n) + 0.5)
    np.testing.assert_allclose(u, s * z * (n * dx - z) / (2.0 * c) + s * dx**2 / (8.0 * c), rtol=1e-6)
    assert flux.sum() == pytest.approx(s * n * dx**2, rel=1e-6)


def harmonic_error(n):
    """Largest error of u = sin(pi x) sinh(pi z) / sinh(pi), harmonic, on the unit square."""
    index = np.stack(np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), axis=-1).reshape(-1, 2)
    cells, dx = MaterialCells(index), 1.0 / n

    def u(x):
        return np.sin(np.pi * x[:, 0]) * np.sinh(np.pi * x[:, 1]) / np.sinh(np.pi)

    centre = dx * (cells.coordinates + 0.5)
    face = centre[cells.border].copy()
    face[np.arange(len(face)), cells.border_axis] += 0.5 * dx * cells.border_sign
    found, _ = diffuse(cells, dx, np.zeros(n * n), 1e12, volume=np.full(n * n, dx**2), capacity=1.0, conductivity=1.0,
                       held=np.ones(len(face), bool), value=u(face))
    return np.abs(found - u(centre)).max()


def test_steady_flow_in_a_square():
    errors = [harmonic_error(n) for n in (16, 32, 64)]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders[0] < orders[1] == pytest.approx(2.0, abs=0.1)


def test_matrix_is_symmetric_and_positive():
    rng = np.random.default_rng(1)
    cells = MaterialCells(np.unique(rng.integers(0, 6, (60, 3)), axis=0))
    flux = TwoPointFlux(cells, 0.3)
    conductivity = 10.0 ** rng.uniform(-6.0, 2.0, len(cells))
    border = np.where(rng.random(len(cells.border)) < 0.3, flux.border_conductances(conductivity), 0.0)
    inner = flux.conductances(conductivity)
    matrix = flux.matrix(np.full(len(cells), 1e-3), inner, border)
    assert abs(matrix - matrix.T).max() == 0.0
    off = matrix.toarray() - np.diag(matrix.diagonal())
    assert (off <= 0.0).all() and np.linalg.eigvalsh(matrix.toarray()).min() > 0.0
    u = rng.normal(size=len(cells))
    outflow = flux.outflow(inner * (u[cells.first] - u[cells.second]), border * u[cells.border])
    np.testing.assert_allclose(matrix @ u, 1e-3 * u + outflow, rtol=0, atol=1e-12 * abs(matrix).max())


def test_iterations_give_what_a_factorisation_gives(monkeypatch):
    cells, top = column(200)
    flux = TwoPointFlux(cells, 0.1)
    conductivity = np.where(np.arange(200) % 7, 1.0, 1e-3)
    matrix = flux.matrix(np.full(200, 0.1), flux.conductances(conductivity),
                         np.where(top, flux.border_conductances(conductivity), 0.0))
    right = np.sin(np.arange(200.0))
    direct = solve(matrix, right)
    monkeypatch.setattr("snowmpm.water.flux.DIRECT", 0)
    np.testing.assert_allclose(solve(matrix, right), direct, rtol=0, atol=1e-9 * np.abs(direct).max())
