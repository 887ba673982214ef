"""Columns of dry sand that collapse (G1 in plane strain, G2 in space), by MPM and by SPH, against the laws of
experiments.

phi = 37 degrees on the cone of plane strain, alpha = sqrt(3) sin(phi) = 1.0424: the same angle on the cone of triaxial
compression would be 60 degrees strong in plane strain and stop short. Run-out and height are those of
`snowmpm.comparison`: the front is where the deposit is a twentieth of its height deep. Sizes as in Favero Neto and
Borja (2018), doi:10.1007/s11440-018-0700-3, and about their number of particles; a softer sand than theirs, on which
nothing depends (below).

Seen, in percent of the law, run-out and height:

    MPM, particles at 0.005 m    a = 0.5  -2.3  0.0    1  -3.8 -2.9    2  +4.5 -6.3    4  -5.9 -14.5    8  -0.8 -10.5
    SPH, at 0.0067 m             a = 1    -3.7 -8.6
    SPH, at 0.005 m              a = 2  -15.5 -15.9    4  -16.8 -17.6    8  -7.1 -13.2

The middle of tall columns, which falls freely, comes to rest too low on coarse grids, by an error of first order: a = 4
is 28.6 % low on cells of 0.02 m, 14.5 % on 0.01 m. SPH's heap is too low since its particles crowd: J is integrated,
and nothing ties it to how close they are (a twentieth have 1.35 times the neighbours of the start, a = 2, 0.01 m).
"""

import numpy as np
import pytest

import snowmpm
from snowmpm.comparison import Case
from snowmpm.comparison.answers import answer_of
from snowmpm.scenes import load_scene

SOFT = {"materials.sand.youngs_modulus": 5.04e5}


def collapse(folder, scene, method, spacing, changes):
    """`Case` of a column; spacing of its particles [m]."""
    dx = spacing if method == "sph" else 2.0 * spacing
    changes = {"solver.method": method, "solver.dx": dx, "output.interval": 0.1, **changes}
    return Case(method, snowmpm.run(load_scene(scene, changes), folder))


def plane(folder, method, a, spacing, half_width=0.2, **changes):
    end = 0.4 + 1.2 * float(np.sqrt(a * half_width / 0.2))
    shape = {"kind": "box", "min": [0.0, 0.0], "max": [half_width, a * half_width]}
    return collapse(folder, "column_collapse_2d", method, spacing,
                    {"bodies.0.shape": shape, "end_time": round(min(end, 2.0), 1), **SOFT, **changes})


def errors(case):
    return {q.name: q.error for q in answer_of(case).quantities()}


def agree(case, runout=0.15, height=0.12):
    error = errors(case)
    assert abs(error["run-out"]) < runout
    assert abs(error["height of the middle"]) < height


@pytest.mark.parametrize("a", [0.5, 1.0])
@pytest.mark.parametrize(("method", "spacing"), [("mpm", 0.0067), ("sph", 0.01)])
def test_low_columns(method, spacing, a, tmp_path):
    agree(plane(tmp_path, method, a, spacing))


TOO_LOW = pytest.mark.xfail(strict=True, reason="14.5 % too low on 20 cells over the half-width, 28.6 % on 10")
SHORT = pytest.mark.xfail(strict=True, reason="SPH: 13 to 18 % too low, at a = 2 and 4 16 % too short; particles crowd")


@pytest.mark.slow
@pytest.mark.parametrize(("method", "a"), [
    ("mpm", 2.0), pytest.param("mpm", 4.0, marks=TOO_LOW), ("mpm", 8.0), pytest.param("sph", 2.0, marks=SHORT),
    pytest.param("sph", 4.0, marks=SHORT), pytest.param("sph", 8.0, marks=SHORT)])
def test_tall_columns(method, a, tmp_path):
    agree(plane(tmp_path, method, a, 0.005, **{"materials.sand.youngs_modulus": 2.016e6}))


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_half_the_spacing(method, a, tmp_path):
    coarse, fine = (answer_of(plane(tmp_path / str(n), method, a, 0.01 / n)).quantities() for n in (1, 2))
    for one, other in zip(coarse, fine, strict=True):
        assert other.measured == pytest.approx(one.measured, rel=0.05), one.name


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_stiffness_means_nothing(method, tmp_path):
    soft, stiff = (answer_of(plane(tmp_path / str(n), method, 1.0, 0.01,
                                   **{"materials.sand.youngs_modulus": n * 5.04e5})).quantities() for n in (1, 4))
    for one, other in zip(soft, stiff, strict=True):
        assert other.measured == pytest.approx(one.measured, rel=0.03), one.name


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.5, 1.0])
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_round_columns(method, a, tmp_path):
    shape = {"kind": "cylinder", "base": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0], "radius": 0.2, "height": 0.2 * a}
    agree(collapse(tmp_path, "column_collapse_3d", method, 0.00833, {"bodies.0.shape": shape, "end_time": 0.7, **SOFT}))
