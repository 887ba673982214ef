"""Library scenes with a known answer, run as they are but coarse, by MPM and by SPH: beam (M11), oedometer (M17 and
that of Peng et al. 2015), slump between plates."""

import numpy as np
import pytest

import snowmpm
from snowmpm.comparison import Case
from snowmpm.comparison.answers import answer_of
from snowmpm.comparison.profile import profile
from snowmpm.scenes import load_scene

BOTH = ["mpm", pytest.param("sph", marks=pytest.mark.slow)]
SNOW = {"kind": "cohesive_cam_clay", "density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3,
        "critical_slope": 1.5, "cohesion": 0.3, "hardening": 1.0, "p0": 30e3}


def answer(folder, scene, method, spacing, **changes):
    changes = {"solver.method": method, "solver.dx": spacing if method == "sph" else 2.0 * spacing, **changes}
    return answer_of(Case(method, snowmpm.run(load_scene(scene, changes), folder)))


def errors(found):
    return {quantity.name: quantity.error for quantity in found.quantities()}


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_oedometer_of_sand(method, tmp_path):
    """Hypoplastic sand, loaded to 15 times its pressure and unloaded: the stress ratio is on its way to K0 = 0.511. The
    stress grows as e^(345 strain): a ten-thousandth of strain lost at a wall is 3 % of it."""
    found = answer(tmp_path, "oedometer", method, 0.05)
    error = errors(found)
    assert abs(error["axial stress"]) < 0.02
    assert abs(error["lateral over axial stress"]) < 0.02
    assert abs(error["stress on the piston"]) < 0.03
    assert abs(error["axial stress, unloaded"]) < 0.05  # it falls by 60 % over a tenth of the strain
    assert found.facts()["K0"].startswith("0.51")


SOURCE = {"solver.sph.kernel": "cubic_spline", "solver.sph.smoothing": 1.4142, "solver.sph.viscosity": 1.0,
          "solver.sph.quadratic_viscosity": 0.1, "solver.sph.disorder_damping": 0.0, "solver.sph.volumes": "constant"}
"""SPH as Peng et al. (2015) have it: cubic spline of h = sqrt(2) spacings, alpha 1, beta 0.1, constant volumes."""


@pytest.mark.slow
def test_oedometer_of_sand_by_the_sums_of_the_source(tmp_path):
    error = errors(answer(tmp_path, "oedometer", "sph", 0.05, **SOURCE))
    assert abs(error["axial stress"]) < 0.02
    assert abs(error["lateral over axial stress"]) < 0.02


@pytest.mark.parametrize("method", BOTH)
def test_oedometer_of_snow(method, tmp_path):
    """M17: set A to a strain of 2 %, from no stress; sigma to 2 %, the lateral one to 3 %."""
    (tmp_path / "way.csv").write_text("time,z\n0,0\n0.05,-0.005\n0.1,-0.02\n")
    changes = {"materials.sample": SNOW, "initial": {"stress": "none"}, "end_time": 0.1, "output.interval": 0.01,
               "obstacles.0.motion.file": str(tmp_path / "way.csv")}
    error = errors(answer(tmp_path, "oedometer", method, 0.0625, **changes))
    assert abs(error["axial stress"]) < 0.02
    assert abs(error["lateral over axial stress"]) < 0.03


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_swing_of_the_beam(method, tmp_path):
    """M11: 3 %, of which the theory of slender beams takes one in time: it leaves shear out."""
    error = errors(answer(tmp_path, "elastic_beam", method, 0.1 / 12 if method == "mpm" else 0.1 / 10, end_time=1.2))
    assert abs(error["depth of the first swing"]) < 0.03
    assert abs(error["time of the first swing"] - 0.01) < 0.03


SHORT = pytest.mark.xfail(strict=True, reason="10.8 % short for 10, as the scene is; on cells of half the size 6 %")
SLUMPS = {"mpm": ("mpm", 0.005), "mpm, fine": ("mpm", 0.0025), "sph": ("sph", 0.005)}
"""Method and spacing of particles [m]; the first is the scene as it is."""


@pytest.fixture(scope="module")
def slumps(tmp_path_factory):
    """Half-width at rest and height of the middle [m], by case."""
    return {case: [quantity.measured for quantity in answer(
        tmp_path_factory.mktemp("slump"), "sand_between_plates", method, spacing).quantities()]
        for case, (method, spacing) in SLUMPS.items()}


@pytest.mark.slow
@pytest.mark.parametrize("case", SLUMPS)
def test_height_between_plates(case, slumps):
    """The middle stays as high as it was (Lube et al. 2005), to 3 %."""
    assert slumps[case][1] == pytest.approx(0.1, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("case", [pytest.param("mpm", marks=SHORT), "mpm, fine", "sph"])
def test_half_width_between_plates(case, slumps):
    """0.32 m by the law of the experiment of Lube et al. 2005, to 10 %."""
    assert slumps[case][0] == pytest.approx(0.32, rel=0.1)


@pytest.mark.slow
def test_both_methods_slump_alike(slumps):
    """To 4 %, where the particles by MPM are half as far apart."""
    assert slumps["mpm, fine"][0] == pytest.approx(slumps["sph"][0], rel=0.04)


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="0.30 m: -17 % of what the source quotes for the experiment, -25 % of its own")
def test_slump_of_the_source(slumps):
    """Peng et al. 2015, section 5.2, quote 0.36 m for the experiment and find 0.40 m: to 10 %."""
    assert slumps["mpm, fine"][0] == pytest.approx(0.36, rel=0.1)


@pytest.mark.slow
def test_line_of_the_first_slip_and_stress_that_stays(tmp_path):
    """Peng et al. 2015, section 5.2: after 0.05 s the surface has a kink where the first slip begins, 61 degrees above
    the foot in the experiment, 65 in theirs, 45 + 15 by theory: 60, to 10. The middle is not deformed: at rest its
    vertical stress is rho g times the depth below its surface, to 5 % of that at the floor, from two cells above it on
    (on the floor 5.1 %)."""
    case = Case("mpm", snowmpm.run(load_scene("sand_between_plates", {
        "solver.dx": 0.005, "output.interval": 0.05, "output.fields": ["stress", "density"]}), tmp_path / "run"))
    run, height, half = case.run, 0.1, 0.2
    early = profile(case, run.frame(int(np.abs(run.times - 0.05).argmin())))
    kink = early.s[early.top > 0.97 * height].max()
    angle = np.degrees(np.arctan(height / (half - kink)))
    print(f"{angle:.0f} degrees")
    assert angle == pytest.approx(60.0, abs=10.0)
    frame = run.frame(-1)
    top = profile(case, frame).top[0]
    x, z = frame.positions[:, 0], frame.positions[:, 2]
    middle = (x < 0.03) & (z < top - 0.005) & (z > 0.01)
    weight = frame.fields["density"][middle].mean() * 9.81
    off = -frame.fields["stress"][middle, 2] - weight * (top - z[middle])
    rows = np.floor(z[middle] / 0.01).astype(int)
    mean = np.bincount(rows, off) / np.maximum(1, np.bincount(rows))
    print(np.abs(mean).max() / (weight * top))
    assert np.abs(mean).max() < 0.05 * weight * top
