"""Cracks in a propagation saw test: whether, when and how fast they run (validation cases S2 to S4).

Slab of 0.5 m, 250 kg/m3, 3 MPa, elastic; weak layers W2 and W3 of 50 mm. The load on the flat is 1226 Pa, between the
Maxwell loads of W3 (887 Pa) and W2 (1471 Pa). All in plane strain with two cells through the weak layer, and again with
four where that matters.

Theories of the critical length do not agree with each other, nor do they hold all there is: WEAC's (brittle, elastic
weak layer) has no process zone and no inertia, the others a rigid layer (energy) or its shear alone (strength).
"""

import functools

import numpy as np
import pytest

import snowmpm
from snowmpm.saw_test import theory
from snowmpm.saw_test.prediction import column_of
from snowmpm.saw_test.result import crack_speed
from tests.verification.test_elastic_saw_test import of_weac

pytestmark = pytest.mark.slow

W2 = {"materials.weak_layer.hardening": 1.0, "materials.weak_layer.p0": 3.0e3}
STRONG_IN_SHEAR = {"materials.weak_layer.critical_slope": 1.8}
"""W3 bears 419 Pa in shear under the slab's weight on 35 degrees, which puts 703 Pa on it; so it bears 902 Pa."""
BRITTLE_IN_SHEAR = {"materials.weak_layer.p0": 4.8e3, "materials.weak_layer.cohesion": 0.05,
                    "materials.weak_layer.softening": 2.0}
"""W3 with little cohesion: 960 Pa of shear strength under 867 Pa of normal stress, 31 degrees once sheared."""
AS_GIVEN = {"saw_test.weak_layer": (("material", "weak_layer"), ("thickness", 0.05))}
"""The layer as thick as it is, its softening as given, whatever the grid."""
AFTER = 0.03  # s after the crack has come through


@functools.cache
def _crack(items):
    changes = {key: dict(value) if isinstance(value, tuple) else value for key, value in items}
    scene = snowmpm.load_scene("pst_2d", {"initial.stress": "geostatic", **changes})
    simulation, end = snowmpm.Simulation(scene), scene.end_time
    while simulation.time < end:
        simulation.step()
        if simulation.crack.rows["tip"][-1] >= scene.saw_test.length - 1e-9:
            end = min(end, simulation.time + AFTER)
    return simulation.crack.values(), simulation.crack.result(), scene


def crack(changes=None, **numbers):
    """Record, result and scene of pst_2d with some keys changed; `numbers` of its saw_test, and dx."""
    dx = {"solver.dx": numbers.pop("dx")} if "dx" in numbers else {}
    own = {f"saw_test.{name}": value for name, value in numbers.items()}
    return _crack(tuple(sorted({**(changes or {}), **own, **dx}.items())))


def brittle_length(scene, slope_angle):
    """Cut [m] at which WEAC's energy release rate is the work of collapse of the weak layer."""
    _, law, thickness = column_of(scene)
    energy = theory.fracture_energy(law, thickness)
    cuts = np.linspace(0.02, 1.0, 50)
    rates = [of_weac(cut, slope_angle, length=4.0)[0] for cut in cuts]
    return float(np.interp(energy, rates, cuts))


def test_no_crack_runs_below_the_maxwell_load():
    """W2: the tip stays a touchdown length ahead of the saw, which goes on; W3 runs through 6 m."""
    values, found, _ = crack(W2, length=4.0)
    assert found["theory"]["maxwell_load"] == pytest.approx(1471.9, rel=1e-3) and not found["runs_to_the_end"]
    assert found["critical_length"] is None
    ahead = values["tip"] - values["saw"]
    assert 0.2 < ahead[-1] < 1.0 and values["saw"][-1] > 0.7
    assert found["crack_length"] < 1.8
    _, found, _ = crack(length=6.0)
    assert found["theory"]["maxwell_load"] == pytest.approx(886.9, rel=1e-3) and found["runs_to_the_end"]


def test_crack_on_the_flat():
    """Speed, collapse and energy of W3, on two grids. Seen: 44.3 and 42.1 m/s, 1.27 and 1.19 mm, 0.85 and 0.86 J/m2,
    cut 0.201 and 0.195 m."""
    seen = []
    for dx in (0.025, 0.0125):
        _, found, _ = crack(dx=dx, length=4.0)
        seen.append([found[name] for name in ("critical_length", "crack_speed", "collapse_height", "fracture_energy")])
        assert 25.0 < found["crack_speed"] < 45.0
        # A collapse wave, and no faster than 0.7 of the shear waves of the slab
        assert found["crack_speed"] < 0.7 * found["theory"]["shear_wave_speed"]
        assert found["crack_speed"] == pytest.approx(found["theory"]["collapse_wave_speed"], rel=0.4)
        # Steady state of the anticrack law: 1.226 mm under this load
        assert found["collapse_height"] == pytest.approx(1.226e-3, rel=0.1)
        assert found["fracture_energy"] == pytest.approx(found["theory"]["fracture_energy"], rel=0.1)
    np.testing.assert_allclose(seen[0], seen[1], rtol=0.1)


def test_speed_reaches_a_plateau():
    """Beyond about 3 m: Bobillier et al. (2021) 4 m. Seen: 44.3 m/s from 3 to 5 m, within 4 %."""
    values, _, _ = crack(length=6.0)
    x, speed = crack_speed(values["x"], values["arrival"], 1.0)
    plateau = speed[(x > 3.0) & (x < 5.0)]
    assert np.ptp(plateau) < 0.1 * plateau.mean() and 25.0 < plateau.mean() < 47.0
    assert speed[x < 1.5].max() < 0.85 * plateau.mean()  # it had to get there


def test_fracture_energy_does_not_hang_on_the_grid():
    """Of the layer drawn two cells thick; that of the layer as given falls with the height of the row that collapses.
    Seen: 0.85 and 0.86 J/m2; 0.46 and 0.28."""
    drawn = [crack(dx=dx, length=4.0)[1]["fracture_energy"] for dx in (0.025, 0.0125)]
    given = [crack(AS_GIVEN, dx=dx, length=3.0)[1]["fracture_energy"] for dx in (0.025, 0.0125)]
    assert drawn[1] == pytest.approx(drawn[0], rel=0.1)
    assert given[1] < 0.75 * given[0] and given[0] < 0.75 * drawn[0]


@pytest.fixture(scope="module")
def critical_lengths():
    """(measured, by WEAC at the work of collapse, by energy, by strength) [m] by slope angle."""
    found = {}
    for angle, length in ((0.0, 4.0), (35.0, 4.0), (-35.0, 4.0)):
        _, result, scene = crack(STRONG_IN_SHEAR, length=length, slope_angle=angle)
        found[angle] = (result["critical_length"], brittle_length(scene, angle),
                        result["theory"]["critical_length_energy"], result["theory"]["critical_length_strength"])
    return found


def test_critical_length_against_the_slope(critical_lengths):
    """Up the slope shorter, down longer than on the flat, as WEAC has it: its bending moment adds to, or takes from,
    that of the overhang. Seen: 0.226, 0.138 and 0.390 m; WEAC 0.298, 0.232, 0.427; strength 0.778, 0.158, 0.158."""
    flat, up, down = (critical_lengths[angle] for angle in (0.0, 35.0, -35.0))
    assert up[0] < 0.8 * flat[0] < flat[0] < 0.8 * down[0]
    assert up[1] < 0.8 * flat[1] < flat[1] < 0.8 * down[1]
    for found in (flat, down):
        assert found[0] == pytest.approx(found[1], rel=0.3)
    assert up[0] < up[1]
    for found in (flat, up, down):
        assert found[0] < found[2]  # energy over a rigid layer: an upper bound


@pytest.mark.xfail(strict=True, reason="0.14 m where WEAC says 0.23: 40 % less, as shear failure (0.16 m) takes over")
def test_critical_length_up_the_slope(critical_lengths):
    """Up the slope the load is close to the shear strength of the weak layer, which WEAC's brittle layer has not."""
    up = critical_lengths[35.0]
    assert up[0] == pytest.approx(up[1], rel=0.3)


def test_supershear():
    """On 45 degrees, far beyond the friction angle of the sheared layer, the crack first runs below the shear waves of
    the slab and then, from about 6 m on, jumps to the speed of its plate waves: the weight along the slope drives it.
    Seen: 55 m/s, then 107 (0.93 of 115 m/s); cracks that begin ahead of the tip, which catches up with them.

    W3 with p0 = 4 kPa does not: bonds of the law break by change of volume only, and in shear under a given normal
    stress it comes to the critical state of its intact ellipse, tan phi = M (1 + beta) / (1 - beta) sqrt(3 + 6 beta) =
    0.85, not 0.58. That leaves 132 of 867 Pa to drive a crack (tip 1.4 m after a cut of 1 m, 9.6 m after one of 8 m).
    """
    values, found, _ = crack(BRITTLE_IN_SHEAR, length=30.0, slope_angle=45.0, notch=0.3, saw_start=0.0, saw_speed=10.0,
                             saw_length=1.5)
    x, speed = crack_speed(values["x"], values["arrival"], 2.0)
    plate = found["theory"]["plate_wave_speed"]
    assert 0.90 < np.nanmedian(speed[(x > 10.0) & (x < 22.0)]) / plate < 1.02
    assert 0.90 < found["crack_speed"] / plate < 1.02
    assert np.nanmedian(speed[x < 4.0]) < found["theory"]["shear_wave_speed"]
