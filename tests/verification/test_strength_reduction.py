"""The factor of safety of slopes by `snowmpm strength`, against slices on circles (R8).

The reference is Bishop's (`snowmpm.comparison.answers.slope_stability`, itself checked against a published benchmark),
of the strength that each law has in plane strain. The factor found is the first multiple of the step at which the slope
slides, that of the reference the first at which slices fall below one: the two must not differ by more than one step.

Numerical viscosity and shear bands a cell or two wide hold a slope up: on a grid of 0.5 m, 12 cells over the height,
the affine transfer lets the slope of soil stand at 1.7, where that of aflip on 0.3 m does not.
"""

import numpy as np
import pytest
from scipy.integrate import trapezoid

import snowmpm
from snowmpm.comparison.answers.slope_stability import Slope, plane_strain_strength, upper_surface
from snowmpm.materials import LAWS
from snowmpm.scenes import load_scene
from snowmpm.strength.displacement import slip_surface, ways_of
from snowmpm.strength.reduction import reduce_strength
from snowmpm.strength.weakening import weakened

STEP = 0.1
SOIL = {"kind": "drucker_prager", "density": 1850.0, "youngs_modulus": 3e7, "poisson_ratio": 0.3,
        "friction_angle": 33.0, "cohesion": 9e3, "cone": "plane_strain"}
SAND = {"kind": "hypoplastic", "density": 1850.0, "youngs_modulus": 3e7, "poisson_ratio": 0.2, "friction_angle": 30.0,
        "cohesion": 2887.0, "reference_pressure": 1e5}
CUT = {**SOIL, "youngs_modulus": 5e6, "friction_angle": 31.2, "cohesion": 550.0}
"""Strength of the cut slope of Bui and Nguyen (2021), whose factor is 1.23 by three methods. Its geometry is not in the
text; that of `cut_slope` is chosen so that slices give it 1.23."""
MPM, SPH = {"solver.dx": 0.3}, {"solver.method": "sph", "solver.dx": 0.2}


def slope(law, **changes):
    """The slope of the library, 6 m high at 45 degrees, of this material."""
    return load_scene("slope_failure", {"materials.soil": law, **changes})


def cut_slope(method):
    """0.65 m high at 45 degrees, on 0.3 m of the same soil; particles 0.02 m apart, as in the source."""
    points = [[0.0, 0.0], [2.4, 0.0], [2.4, 0.95], [1.55, 0.95], [0.9, 0.3], [0.0, 0.3]]
    return slope(CUT, **{"solver.dx": 0.04 if method == "mpm" else 0.02, "solver.method": method,
                         "bodies.0.shape.points": points, "domain.max": [2.4, 1.2]})


def known(scene, way):
    """First multiple of the step at which slices on circles fall below one."""
    points = np.array(scene.bodies[0].shape.points, float)
    x, z = upper_surface(points)
    for number in range(5, 100):
        law = weakened(scene.materials["soil"], number * STEP, way)
        try:
            cohesion, angle, _ = plane_strain_strength(law.model_dump())
        except ValueError:  # stronger than any angle of Coulomb: it stands
            continue
        circle = Slope(x, z, points[:, 1].min(), law.density * 9.81, cohesion, np.tan(angle)).critical()
        if circle.factor < 1.0:
            return number * STEP
    raise AssertionError


def within_a_step(scene, folder, way="tangent"):
    """The reduction, compared with slices; it began from a rest of the slope with its own strength."""
    reduction = reduce_strength(scene, folder, way=way, step=STEP)
    assert abs(reduction.found.slides - known(scene, way)) < 1.01 * STEP
    assert reduction.rest_factor == 1.0
    return reduction


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
@pytest.mark.parametrize("way", ["tangent", "angle"])
def test_cut_slope(method, way, tmp_path):
    scene = cut_slope(method)
    assert LAWS["drucker_prager"].model_validate(CUT) == scene.materials["soil"]
    if way == "tangent":
        assert known(scene, way) == pytest.approx(1.3)  # 1.23
    within_a_step(scene, tmp_path, way)


@pytest.mark.slow
@pytest.mark.parametrize("changes", [MPM, SPH], ids=["mpm", "sph"])
def test_slope_of_soil(changes, tmp_path):
    """Bishop's factor is 1.59. As much slides as lies above Bishop's circle (9.3 % of the soil) within a fifth, and its
    lower border is that of the circle to a fifth of the height, in the middle of the slope."""
    reduction = within_a_step(slope(SOIL, **changes), tmp_path)
    ways = ways_of(reduction.run_of(reduction.found.trial))
    points = np.array(reduction.scene.bodies[0].shape.points, float)
    surface = upper_surface(points)
    circle = Slope(*surface, 0.0, 1850.0 * 9.81, 9e3, np.tan(np.radians(33.0))).critical()

    def lower(x):
        return circle.z - np.sqrt(np.maximum(circle.radius**2 - (x - circle.x) ** 2, 0.0))

    across = np.linspace(max(0.0, circle.x - circle.radius), circle.x + circle.radius, 4001)
    above = trapezoid(np.maximum(np.interp(across, *surface) - lower(across), 0.0), across)
    assert ways.slid.mean() == pytest.approx(above / trapezoid(surface[1], surface[0]), rel=0.2)
    x, z = slip_surface(ways, 0.6).T
    middle = (x > 9.0) & (x < 13.0)
    np.testing.assert_allclose(z[middle], lower(x[middle]), atol=1.2)


@pytest.mark.slow
@pytest.mark.parametrize("changes", [
    pytest.param({"solver.dx": 0.4}, id="mpm"),
    pytest.param(SPH, id="sph", marks=pytest.mark.xfail(
        strict=True, reason="it creeps with its own strength and rests with twice that, from where it slides at 1.4"))])
def test_slope_of_hypoplastic_soil(changes, tmp_path):
    """The slope row of Peng et al., its cohesion as Coulomb counts it."""
    within_a_step(slope(SAND, **changes), tmp_path)


@pytest.mark.slow
@pytest.mark.xfail(strict=True, raises=AssertionError, reason="8.3 % of the soil slides, 6.4 % of that with the cone")
def test_the_slide_of_hypoplastic_soil_is_the_shallower_one(tmp_path):
    """As Peng et al. (2015), section 5.3, say of their slope, by MPM; both cones have one angle and one apex."""
    cone = {**SOIL, "friction_angle": SAND["friction_angle"], "cohesion": SAND["cohesion"]}
    slid = []
    for name, law in (("hypoplastic", SAND), ("cone", cone)):
        reduction = reduce_strength(slope(law, **{"solver.dx": 0.4}), tmp_path / name, step=STEP)
        slid.append(ways_of(reduction.run_of(reduction.found.trial)).slid.mean())
    print(*slid)
    assert slid[0] < slid[1]


@pytest.mark.slow
def test_slope_of_coulomb_material(tmp_path):
    within_a_step(slope({**{k: v for k, v in SOIL.items() if k != "cone"}, "kind": "mohr_coulomb"}, **MPM), tmp_path)


@pytest.mark.slow
def test_a_slope_that_does_not_stand(tmp_path):
    """The library's own soil: 0.8 by slices. The search begins from a rest with more strength."""
    scene = load_scene("slope_failure", {"solver.dx": 0.3})
    reduction = reduce_strength(scene, tmp_path, step=STEP)
    assert reduction.rest_factor < 1.0
    assert abs(reduction.found.slides - known(scene, "tangent")) < 1.01 * STEP


def slid_off(method, kind, folder):
    """Run of the cut slope with two thirds of its strength, to 1 s; "softening": towards 0.1 kPa and 15 degrees."""
    weak = {**CUT, "friction_angle": float(np.degrees(np.arctan(np.tan(np.radians(31.2)) / WEAKER))),
            "cohesion": 550.0 / WEAKER}
    if kind == "softening":
        weak |= {"kind": "softening_cone", "residual_friction_angle": 15.0, "residual_cohesion": 100.0,
                 "softening_strain": 1.0 / 3.0}
    scene = cut_slope(method)
    changes = {"solver.dx": scene.solver.dx, "solver.method": method, "end_time": 1.0, "output.interval": 0.05,
               "output.fields": ["id"], "domain.max": [2.4, 1.2],
               "bodies.0.shape.points": [list(point) for point in scene.bodies[0].shape.points]}
    return snowmpm.run(load_scene("slope_failure", {"materials.soil": weak, **changes}), folder / kind)


WEAKER = 1.5
"""By which the strength of the cut slope is divided: its factor of safety is then 0.82."""


@pytest.mark.slow
@pytest.mark.parametrize("method", ["mpm", "sph"])
def test_a_cut_slope_that_softens_runs_out_further(method, tmp_path):
    """B12 of Bui and Nguyen (2021): towards 0.1 kPa and 15 degrees, over a strain of a third. It fails along the
    surface of the plastic one at first: of what has moved by 2 % of the height, as much, within a third; then it runs
    out further by more than a fifth of its height."""
    height, ways = 0.65, {}
    for kind in ("plastic", "softening"):
        ways[kind] = ways_of(slid_off(method, kind, tmp_path))
    early = {}
    for kind, one in ways.items():
        frame = int(np.argmax(one.ways.max(axis=1) > 0.1 * height))
        early[kind] = (one.ways[frame] > 0.02 * height).mean()
    reach = {kind: one.ways[-1].max() for kind, one in ways.items()}
    print(method, early, reach)
    assert early["softening"] == pytest.approx(early["plastic"], rel=1.0 / 3.0)
    assert reach["softening"] > reach["plastic"] + 0.2 * height
