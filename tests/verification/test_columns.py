"""Columns of dry sand that collapse (G1 in plane strain, G2 in space), by MPM and by SPH, against the laws of
experiments.

phi = 37 degrees on the cone of plane strain, alpha = sqrt(3) sin(phi) = 1.0424: the same angle on the cone of triaxial
compression would be 60 degrees strong in plane strain and stop short. Run-out and height are those of
`snowmpm.comparison`: the front is where the deposit is a twentieth of its height deep. Sizes as in Favero Neto and
Borja (2018), doi:10.1007/s11440-018-0700-3; a softer sand than theirs, on which nothing depends (below).

MPM takes random particles ("poisson") and the transfer "aflip", which the program chooses for columns of grains
(`snowmpm.scenes.choices`). A tall column is stretched fourfold sideways while its middle falls: rows of a
lattice move further apart than the grid sees, the sand between them is gone for it, and the heap comes to rest too low
(`test_rows_of_particles_lower_a_tall_column`). Sixteen particles a cell in rows do what four random ones do.

Run-out and height, percent of the law, at a spacing of particles [mm] and at half of it:

    a     MPM                                     SPH
    0.5   2.5   -2.0 +0.8    1.25  -1.5 +0.3      5    -1.6 -0.1    2.5  -3.9 -0.1
    1     5     -1.6 -2.9    2.5   -3.9 -4.0      10   -5.8 -11.2   5    -3.6 -7.3
    2     10    +0.7 -1.7    5     +2.5 -5.2      10   -2.5 -11.9   5    +0.1 -7.8
    4     10    -4.1 -5.6    5     -2.5 -2.8      20  -10.6 -10.0   10   -9.7 -6.6
    8     10    -0.2 -6.8    5     +1.8 -6.0      20   -2.7 -6.6    10   -0.5 -6.2

SPH by default: a viscosity of 0.1 (the source has none) and a smoothing of 1.5, as in the source; one of 1.2 leaves
a = 1 higher at 10 mm, -5.5 -4.7, but a = 4 then goes from -10.1 -5.2 at 20 mm to +3.2 -7.2 at 10 mm. Coarser, a = 0.5:
MPM at 10 and 5 mm -13.1 +3.2 and -7.6 +1.4, SPH at 10 mm -6.9 0.0.
"""

import numpy as np
import pytest

import snowmpm
from snowmpm.comparison import Case
from snowmpm.comparison.answers import answer_of
from snowmpm.comparison.answers.column import plane_runout
from snowmpm.comparison.profile import profile
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


def default(scene, changes, folder):
    """`Case` of a library scene whose numerics are those that the program chooses."""
    found = load_scene(scene, {"output.interval": 0.1, **changes})
    assert found.choices and not {key for key in changes if key.startswith("solver")}
    return Case("default", snowmpm.run(found, folder))


def errors(case):
    return {q.name: q.error for q in answer_of(case).quantities()}


def agree(case, runout=0.15, height=0.12):
    error = errors(case)
    print(f"{case.method} {case.spacing:g} m:", *(f"{name} {100.0 * value:+.1f} %" for name, value in error.items()))
    assert abs(error["run-out"]) < runout
    assert abs(error["height of the middle"]) < height


@pytest.mark.parametrize(("method", "spacing", "a"), [
    ("mpm", 0.0067, 0.5), ("mpm", 0.0067, 1.0), pytest.param("mpm", 0.0025, 0.25, marks=pytest.mark.slow),
    pytest.param("sph", 0.005, 0.25, marks=pytest.mark.slow), pytest.param("sph", 0.01, 0.5, marks=pytest.mark.slow),
    ("sph", 0.01, 1.0)])
def test_low_columns(method, spacing, a, tmp_path):
    agree(plane(tmp_path, method, a, spacing))


@pytest.mark.slow
@pytest.mark.parametrize("angle", [33.0, 37.0])
@pytest.mark.parametrize("a", [0.5, 1.0, 2.0, 4.0, 8.0])
def test_plane_columns_by_default_choices(a, angle, tmp_path):
    """The library's scene on its own grid, 20 cells to the half-width, with nothing changed but column and angle."""
    changes = {"bodies.0.shape.max": [0.2, 0.2 * a], "end_time": round(min(0.4 + 1.2 * a**0.5, 2.0), 1),
               "materials.sand.friction_angle": angle}
    agree(default("column_collapse_2d", changes, tmp_path))


LOW = {1.0: 18.9, 2.0: 16.8, 3.0: 16.3}
"""By how many per cent the middle of round columns of 33 degrees ends too low by default choices."""


@pytest.mark.slow
@pytest.mark.parametrize(("a", "angle"), [
    pytest.param(a, angle, marks=[pytest.mark.xfail(strict=True, raises=AssertionError, reason=f"{LOW[a]} % too low")]
                 if angle == 33.0 and a in LOW else []) for angle in (33.0, 37.0) for a in (0.5, 1.0, 2.0, 3.0)])
def test_round_columns_by_default_choices(a, angle, tmp_path):
    """The same of the round column, 12 cells to the radius; the domain grows with the heap."""
    changes = {"bodies.0.shape.height": 0.2 * a, "end_time": 0.8 if a <= 1.0 else 1.2,
               "materials.sand.friction_angle": angle}
    if a > 1.0:
        changes |= {"domain.min": [-1.0, -1.0, -1.0 / 15.0], "domain.max": [1.0, 1.0, 0.8]}
    agree(default("column_collapse_3d", changes, tmp_path), height=0.15)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "a", "spacing"), [
    ("mpm", 0.5, 0.0025), ("mpm", 1.0, 0.005), ("mpm", 2.0, 0.01), ("mpm", 4.0, 0.01), ("mpm", 8.0, 0.01),
    ("sph", 0.5, 0.005), ("sph", 1.0, 0.01),
    pytest.param("sph", 2.0, 0.01, marks=pytest.mark.xfail(strict=True, reason="height 12.2 % low on one spacing")),
    pytest.param("sph", 4.0, 0.02, marks=pytest.mark.xfail(strict=True, reason="height changes by 5.5 %")),
    pytest.param("sph", 8.0, 0.02, marks=pytest.mark.xfail(strict=True, reason="run-out changes by 5.6 %"))])
def test_half_the_spacing(method, a, spacing, tmp_path):
    """On both spacings as the laws say, and on both the same: columns of a <= 1 from twenty cells (MPM) or particles
    (SPH) over their height, taller ones from ten over the half-width."""
    cases = [plane(tmp_path / str(n), method, a, spacing / n) for n in (1, 2)]
    for case in cases:
        agree(case)
    for one, other in zip(*(answer_of(case).quantities() for case in cases), strict=True):
        assert other.measured == pytest.approx(one.measured, rel=0.05), one.name


@pytest.mark.slow
@pytest.mark.parametrize("a", [0.5, 1.0])
def test_profiles_in_time_by_both_methods(a, tmp_path):
    """Depths at 0.1, 0.2 and 0.3 s, in the mean over the published run-out: within 5 % of the height of each other."""
    spacing = {"mpm": 0.0033, "sph": 0.005}
    cases = [plane(tmp_path / method, method, a, spacing[method]) for method in spacing]
    x = np.linspace(0.0, 0.2 * (1.0 + plane_runout(a)), 100)
    for time in (0.1, 0.2, 0.3):
        depths = []
        for case in cases:
            found = profile(case, case.run.frame(int(np.abs(case.run.times - time).argmin())))
            depths.append(np.interp(x, found.s, found.top, right=0.0))
        apart = np.abs(depths[0] - depths[1]).mean() / (0.2 * a)
        print(f"{time} s: {apart:.3f}")
        assert apart < 0.05


@pytest.mark.slow
def test_rows_of_particles_lower_a_tall_column(tmp_path):
    """a = 4 on ten cells: a lattice of four particles a cell loses a quarter of the height, random ones do not."""
    rows, random = (errors(plane(tmp_path / sampling, "mpm", 4.0, 0.01, **{"solver.sampling": sampling}))
                    for sampling in ("regular", "poisson"))
    assert rows["height of the middle"] < -0.2
    assert abs(random["height of the middle"]) < 0.12


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_stiffness_means_nothing(method, tmp_path):
    soft, stiff = (answer_of(plane(tmp_path / str(n), method, 1.0, 0.01,
                                   **{"materials.sand.youngs_modulus": n * 5.04e5})).quantities() for n in (1, 4))
    for one, other in zip(soft, stiff, strict=True):
        assert other.measured == pytest.approx(one.measured, rel=0.03), one.name


@pytest.mark.slow
@pytest.mark.parametrize(("method", "spacing", "a"), [
    ("mpm", 0.00694, 0.5), ("mpm", 0.00694, 1.0), ("sph", 0.2 / 24, 0.5), ("sph", 0.2 / 28, 1.0)])
def test_round_columns(method, spacing, a, tmp_path):
    """MPM, 14 cells over 0.2 m: -11.0 -11.5 (a = 1), -9.8 +3.3 (a = 0.5); on 12 the heap of a = 1 is 12.4 % low, of a
    lattice 14.6 % low; on 20 (5 mm) -11.1 -9.5. On this cone sand has 37 degrees in plane strain and 26 where two
    principal stresses are the same, as in the middle; with 37 everywhere (Mohr-Coulomb, SPH at 12.5 mm) the heap is
    13 % higher, 6 % shorter.

    SPH, whose support, three spacings, has to be small beside the heap, with smoothing = 1.2 and half the viscosities,
    of which the source has none: a = 0.5 -5.9 -0.4; a = 1 on 16 particles over its height -9.2 -14.4, on 28 -13.3
    -10.9. With all of the viscosities on 16 -10.0 -15.6, on 30 -14.7 -9.3; without, noise flows, on 16 -2.2 -25.3; with
    smoothing = 1.5 on 16 -8.9 -22.4. Profiles on 30 are those of MPM at 5 mm within 3 mm; what the rim lacks, 1.7 % of
    the sand, lies beyond r = 0.44 m in single grains that have run on, of which there are more the coarser they are.
    """
    shape = {"kind": "cylinder", "base": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0], "radius": 0.2, "height": 0.2 * a}
    changes = {"bodies.0.shape": shape, "end_time": 0.7, **SOFT}
    if method == "sph":
        changes |= {"solver.sph.smoothing": 1.2, "solver.sph.viscosity": 0.05, "solver.sph.disorder_damping": 0.25}
    agree(collapse(tmp_path, "column_collapse_3d", method, spacing, changes))
