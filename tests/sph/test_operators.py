"""Sums over neighbours against exact derivatives (B1-B3 of Bui & Nguyen 2021, M18a): what is exact, and what is not."""

import numpy as np
import pytest

from snowmpm.sph.smoothing import KERNELS
from tests.support.sph_sums import rms, stage


@pytest.mark.parametrize("name", KERNELS)
@pytest.mark.parametrize("dim", [2, 3])
def test_kernels_integrate_to_one_and_slope_is_theirs(name, dim):
    r = np.linspace(0.0, 2.0, 40001)
    shell = 2.0 * np.pi * r if dim == 2 else 4.0 * np.pi * r**2
    weight = KERNELS[name].weight(r, 2.0, dim)
    assert (shell * weight).sum() * (r[1] - r[0]) == pytest.approx(1.0, abs=1e-6)
    middle = 0.5 * (r[1:] + r[:-1])
    slope = middle * KERNELS[name].slope_over_r(middle, 2.0, dim)
    assert slope == pytest.approx(np.diff(weight) / np.diff(r), abs=2e-6)
    assert KERNELS[name].weight(np.array([2.0, 2.5]), 2.0, dim) == pytest.approx(0.0, abs=1e-15)


def test_corrected_gradient_is_exact_for_linear_fields_up_to_the_surface():
    solver, x, _ = stage(20, 0.2)
    f = 3.0 * x[:, 0] - 2.0 * x[:, 1] + 1.0
    exact = np.array([3.0, -2.0])
    corrected = solver.operate("corrected_gradient", f)[:, 0] / solver.dx
    plain = solver.operate("gradient", f)[:, 0] / solver.dx
    assert np.abs(corrected - exact).max() < 1e-12
    assert np.abs(plain - exact).max() > 1.0


def test_plain_gradient_loses_half_of_the_normal_derivative_at_a_flat_surface():
    """In the limit of many neighbours: the half space that is missing carries half of the second moment."""
    solver, x, _ = stage(40, 0.0, scheme={"kernel": "wendland_c2", "smoothing": 2.5})
    face = (np.abs(x[:, 0] - 0.5) < 0.02) & (x[:, 1] < 0.03)
    slope = solver.operate("gradient", x[:, 1])[face, 0, 1] / solver.dx
    assert slope == pytest.approx(0.5 + 0.5 * face_share(0.5, 5.0), abs=0.02)


def face_share(height, radius):
    """Share of the second moment of the C2 kernel's slope within `height` of a plane through its middle (both in dx),
    by quadrature."""
    y = (np.arange(400) + 0.5) / 400 * radius
    x = (np.arange(-400, 400) + 0.5) / 400 * radius
    X, Y = np.meshgrid(x, y, indexing="ij")
    moment = (-KERNELS["wendland_c2"].slope_over_r(np.hypot(X, Y), radius, 2) * Y**2).sum(axis=0)
    return float(moment[y < height].sum() / moment.sum())


def test_new_laplacian_is_exact_for_linear_fields_the_old_one_is_not():
    errors = {}
    for n in (20, 40):
        solver, x, inner = stage(n, 0.1, rows=3)
        f = x.sum(axis=1)
        new, old = (solver.operate(kind, f)[inner, 0] / solver.dx**2 for kind in ("laplacian", "plain_laplacian"))
        assert np.abs(new).max() < 1e-9 * n
        errors[n] = rms(old)
    # Under the same relative disorder the old one gets worse with resolution (measured: 2.05 and 4.07)
    assert errors[20] == pytest.approx(2.05, rel=0.25) and errors[40] == pytest.approx(4.07, rel=0.25)


def test_laplacians_of_quadratic_fields_on_disordered_particles():
    solver, x, inner = stage(40, 0.2, rows=3)
    fields = {"x2 + y2": (x[:, 0] ** 2 + x[:, 1] ** 2, 4.0), "x2 - y2": (x[:, 0] ** 2 - x[:, 1] ** 2, 0.0),
              "x y": (x[:, 0] * x[:, 1], 0.0)}
    found = {}
    for name, (f, exact) in fields.items():
        found[name] = [rms(solver.operate(kind, f)[inner, 0] / solver.dx**2 - exact)
                       for kind in ("laplacian", "plain_laplacian")]
    assert found["x2 + y2"] == pytest.approx([2.6e-2, 9.43], rel=0.3)
    assert found["x2 - y2"] == pytest.approx([0.163, 9.48], rel=0.3)
    assert found["x y"] == pytest.approx([0.100, 4.62], rel=0.3)


def test_laplacian_is_of_second_order_on_a_lattice():
    errors = []
    for n in (20, 40):
        solver, x, inner = stage(n, 0.0, rows=3)
        f = np.sin(2.0 * np.pi * x[:, 0]) * np.sin(2.0 * np.pi * x[:, 1])
        new = solver.operate("laplacian", f)[inner, 0] / solver.dx**2
        errors.append(rms(new + 8.0 * np.pi**2 * f[inner]))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert errors[1] == pytest.approx(0.263, rel=0.05)


def test_filters_and_coverage():
    solver, x, _ = stage(20, 0.2)
    linear = 3.0 * x[:, 0] - 2.0 * x[:, 1]
    assert np.abs(solver.operate("mls", linear)[:, 0] - linear).max() < 1e-12
    assert np.abs(solver.operate("shepard", np.ones(len(x)))[:, 0] - 1.0).max() < 1e-13
    assert np.abs(solver.operate("shepard", linear)[:, 0] - linear).max() > 0.05
    rng = np.random.default_rng(1)
    noise = rng.normal(size=len(x))
    assert solver.operate("mls", noise).std() < 0.7 * noise.std()


def test_coverage_tells_the_first_layer_from_the_second():
    """The threshold works with the particle itself left out (sums on the lattice: 0.469, 0.681, 0.684 for the cubic
    spline)."""
    solver, x, _ = stage(20, 0.0, scheme={"kernel": "cubic_spline", "smoothing": 1.2})
    cover = solver.operate("coverage", x[:, 0])[:, 0]
    middle = np.abs(x[:, 0] - 0.5) < 0.06
    for layer, expected in enumerate((0.469, 0.681, 0.684)):
        own = middle & (np.abs(x[:, 1] - (layer + 0.5) / 20) < 1e-6)
        assert cover[own] == pytest.approx(expected, abs=0.002)
