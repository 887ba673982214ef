"""Snow cover as particles beside the depth-averaged flow that takes the same cover up (D15); table of the guide.

A slab of 10 m by 1.2 m at 12 m/s on a rough slope of 20 degrees. By MPM in plane strain the cover fractures and is
taken up as far as the flow can; the depth-averaged flow, whose friction is that of sand that shears over its own, sin
25 degrees, takes all of it up as it comes. So does MPM on such friction with the same law at the bed.
"""

import re
from functools import cache

import numpy as np
import pytest

import snowmpm
from snowmpm.scenes.schema import Scene
from tests.support.project import ROOT

ANGLE, FRICTION, SPEED, DENSITY = 20.0, 25.0, 12.0, 250.0
SNOW = {"kind": "mohr_coulomb", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3,
        "friction_angle": FRICTION}
TIMES = (2.0, 4.0, 6.0, 12.0)


def scene(method, thickness, cohesion=0.0):
    slope = np.radians(ANGLE)
    level, down = float(SPEED * np.cos(slope)), float(-SPEED * np.sin(slope))
    mpm = method != "depth"
    side = {} if mpm else {"y": [0.0, 2.0]}
    bodies = [{"name": "release", "material": "flow", "velocity": [level, down] if mpm else [level, 0.0, down],
               "shape": {"kind": "layer", "bottom": 0.0, "top": 1.2, "region": {"x": [0.0, 10.0], **side}}}]
    terrain = {"kind": "plane", "angle": ANGLE}
    if method == "mpm":
        terrain["contact"] = "stick"
        if thickness:
            bodies.append({"name": "cover", "material": "old", "laid_ahead": 4.0, "shape": {
                "kind": "layer", "bottom": 0.0, "top": thickness, "region": {"x": [10.2, 90.0]}}})
    else:
        terrain["friction"] = float(np.sin(np.radians(FRICTION)))
        if thickness:
            terrain["entrainment"] = {"law": "erosion_energy", "energy": 1.0, "thickness": thickness,
                                      "density": DENSITY}
    low, high = ([-5.0, -60.0], [140.0, 10.0]) if mpm else ([-5.0, 0.0, -60.0], [140.0, 2.0, 10.0])
    sides = {} if mpm else {"boundary": {"y_min": "slip", "y_max": "slip"}}
    return Scene.model_validate({
        "name": "cover", "dimension": 2 if mpm else 3, "end_time": TIMES[-1], "output": {"interval": 0.5},
        "solver": {"dx": 0.1} if mpm else {"dx": 0.5, "method": "depth"}, "terrain": terrain,
        "domain": {"min": low, "max": high, **sides}, "stop": {"at_rest": False},
        "materials": {"flow": SNOW, **({"old": {**SNOW, "cohesion": cohesion}} if len(bodies) > 1 else {})},
        "bodies": bodies, **({"initial": {"stress": "geostatic"}} if mpm else {})})


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    """(method, thickness of the cover, cohesion) -> mass taken up over that of the release, front at TIMES [m]."""
    @cache
    def of(*case):
        history = snowmpm.run(scene(*case), tmp_path_factory.mktemp("cover") / "run").history
        fronts = np.interp(TIMES, history["time"], history["front_distance"])
        return float(history["entrained_mass"][-1] / history["mass"][0]), fronts
    return of


def rows():
    """Of the table of the guide: (method, thickness, cohesion), mass taken up, fronts."""
    text = (ROOT / "docs" / "snow_cover.md").read_text(encoding="utf-8")
    for line in re.findall(r"^\| (?:MPM|depth).*\|$", text, re.MULTILINE):
        method, cover, taken, *fronts = (cell.strip() for cell in line.strip("|").split("|"))
        thickness, cohesion = (float(re.search(rf"([\d.]+) {unit}\b", cover)[1]) if f" {unit}" in cover else 0.0
                               for unit in ("m", "Pa"))
        yield (method.lower(), thickness, cohesion), float(taken), [float(cell) for cell in fronts]


def test_the_table_has_all_rows():
    assert [case for case, _, _ in rows()] == [
        ("mpm", 0.0, 0.0), ("depth", 0.0, 0.0), ("mpm", 0.4, 1500.0), ("mpm", 0.4, 400.0), ("mpm", 0.4, 100.0),
        ("depth", 0.4, 0.0), ("mpm, bed", 0.15, 0.0), ("depth", 0.15, 0.0)]


@pytest.mark.slow
@pytest.mark.parametrize(("case", "taken", "fronts"), [
    pytest.param(*row, id=" ".join(map(str, row[0]))) for row in rows()])
def test_the_table_is_true(case, taken, fronts, measured):
    found, reached = measured(*case)
    assert found == pytest.approx(taken, abs=0.05 + 0.03 * taken)
    np.testing.assert_allclose(reached, fronts, rtol=0.03, atol=0.5)


@pytest.mark.slow
def test_without_a_cover_both_methods_come_alike(measured):
    """Fronts to 10 %."""
    np.testing.assert_allclose(measured("mpm", 0.0, 0.0)[1], measured("depth", 0.0, 0.0)[1], rtol=0.1)


@pytest.mark.slow
def test_a_weak_cover_is_taken_up_as_by_the_depth_averaged_flow(measured):
    """Mass to a quarter, front at the end to 15 %; on the way the flow in space is ahead, for it first runs over what
    the other has to carry at once."""
    taken, fronts = measured("mpm", 0.4, 100.0)
    all_of_it, also = measured("depth", 0.4, 0.0)
    assert taken == pytest.approx(all_of_it, rel=0.25)
    assert fronts[-1] == pytest.approx(also[-1], rel=0.15) and fronts[1] > also[1]
    assert taken < 7.2  # Sovilla et al. (2001), doi:10.3189/172756401781819058: up to 720 % of the release


@pytest.mark.slow
def test_a_thin_cover_taken_up_at_the_bed_is_that_of_the_depth_averaged_flow(measured):
    """1.5 cells: fronts to 10 %, and all that they have passed."""
    taken, fronts = measured("mpm, bed", 0.15, 0.0)
    also, reached = measured("depth", 0.15, 0.0)
    np.testing.assert_allclose(fronts, reached, rtol=0.1)
    assert taken / fronts[-1] == pytest.approx(also / reached[-1], rel=0.05)
