"""Profiles, stress lines and labels of runs that are made up."""

import numpy as np
import pytest

from snowmpm.comparison import Line, Way, open_cases, profile, stress_along
from snowmpm.comparison.difference import profile_difference
from snowmpm.errors import InputError
from snowmpm.io import RunWriter

SPACING = 0.05
SCENE = 'name = "made_up"\ngravity = 9.81\n[solver]\nmethod = "mpm"\n'


def write(folder, frames, dimension=2, fields=None, **record):
    """A run of these frames: positions (n, dim)."""
    record = {"scene": SCENE, "particle_spacing": SPACING, "dx": 2.0 * SPACING, **record}
    units = dict.fromkeys(fields or (), "Pa")
    with RunWriter(folder, provenance=record, dimension=dimension, units=units, origin=np.zeros(dimension)) as writer:
        for i, x in enumerate(frames):
            writer.history(float(i), {"front": 0.0, "steps": i}, {"front": "m", "steps": "1"})
            writer.frame(float(i), x, {name: values(x) for name, values in (fields or {}).items()})
    return folder


def block(width, height, depth=None):
    """Particles of a box with a corner at the origin."""
    sizes = [width, height] if depth is None else [width, depth, height]
    axes = [(np.arange(round(size / SPACING)) + 0.5) * SPACING for size in sizes]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(axes))


def only(*paths):
    return open_cases([str(path) for path in paths])


def test_profile_of_a_box_and_of_a_wedge(tmp_path):
    box = block(2.0, 1.0)
    wedge = box[box[:, 1] < 1.0 - 0.5 * box[:, 0]]
    grains = np.array([[2.5, 0.02], [3.1, 0.02], [0.5, 2.0]])  # roll ahead and fly
    (case,) = only(write(tmp_path / "run", [box, np.concatenate([wedge, grains])]))
    found = profile(case, case.run.frame(0))
    assert (found.start, found.end) == pytest.approx((0.0, 2.0), abs=1e-6)
    np.testing.assert_allclose(found.top, 1.0, atol=1e-6)
    np.testing.assert_allclose(found.bottom, 0.0, atol=1e-6)
    assert (found.back, found.front) == pytest.approx((0.0, 2.0), abs=1e-6)
    found = profile(case, case.run.frame(1))
    np.testing.assert_allclose(found.at(np.array([0.5, 1.0])), [0.75, 0.5], atol=SPACING)
    assert found.end < 2.0 + 1e-6
    # A twentieth of the depth of 1 m is left at x = 1.9 m
    assert found.front == pytest.approx(1.9, abs=SPACING)


def test_profile_around_a_middle(tmp_path):
    x = block(4.0, 0.5, 4.0) - np.array([2.0, 2.0, 0.0])
    disc = x[np.hypot(x[:, 0], x[:, 1]) < 1.5]
    (case,) = only(write(tmp_path / "run", [disc, disc], dimension=3))
    found = profile(case, case.run.frame(0), (0.0, 0.0))
    assert found.along == "r"
    assert found.front == pytest.approx(1.5, abs=SPACING)
    np.testing.assert_allclose(found.top, 0.5, atol=1e-6)
    assert profile(case, case.run.frame(0)).front == pytest.approx(1.5, abs=SPACING)  # a strip along x


def test_front_of_a_round_heap_where_it_is_half_a_layer_deep(tmp_path):
    """A cone 10 spacings high: a twentieth of it is half a layer, at r = 1.9 m; a layer, at 1.8 m, is no border."""
    rng, height, radius = np.random.default_rng(1), 10 * SPACING, 2.0
    count = round((2.0 * radius) ** 2 * height / SPACING**3)
    x = rng.uniform([-radius, -radius, 0.0], [radius, radius, height], (count, 3))
    r = np.hypot(x[:, 0], x[:, 1])
    cone = x[x[:, 2] < height * (1.0 - r / radius)]
    rolling = np.array([[2.5, 0.0, 0.02], [0.0, -2.7, 0.02]])
    (case,) = only(write(tmp_path / "run", [np.concatenate([cone, rolling])] * 2, dimension=3))
    assert profile(case, case.run.frame(0), (0.0, 0.0)).front == pytest.approx(1.9, abs=0.03)


def test_difference_of_profiles(tmp_path):
    cases = only(write(tmp_path / "a", [block(2.0, 1.0)] * 2), write(tmp_path / "b", [block(2.0, 0.8)] * 2))
    one, other = (profile(case, case.run.frame(0)) for case in cases)
    assert profile_difference(one, one) == 0.0
    assert profile_difference(one, other) == pytest.approx(0.2)


def test_stress_along_lines(tmp_path):
    """A stress that grows with depth, tension positive in the file."""
    fields = {"stress": lambda x: np.stack([0.5 * (x[:, 1] - 1.0), 0.0 * x[:, 1], x[:, 1] - 1.0, *[0.0 * x[:, 1]] * 3],
                                           axis=1)}
    (case,) = only(write(tmp_path / "run", [block(2.0, 1.0)] * 2, fields=fields))
    upright = stress_along(case, case.run.frame(0), Line.of("x=1.0"))
    np.testing.assert_allclose(upright.values["upright"], 1.0 - upright.place, atol=1e-5)
    np.testing.assert_allclose(upright.values["level"], 0.5 * (1.0 - upright.place), atol=1e-5)
    level = stress_along(case, case.run.frame(0), Line.of("z = 0.25"))
    np.testing.assert_allclose(level.values["upright"], 0.75, atol=1.1 * SPACING)
    assert stress_along(case, case.run.frame(0), Line("x", 7.0)) is None
    for text in ("y=1", "x", "x=", "z=far", "x=nan"):
        with pytest.raises(InputError, match="--line"):
            Line.of(text)


def test_labels_tell_runs_apart(tmp_path):
    frames = [block(0.5, 0.5)] * 2
    paths = [write(tmp_path / part / "run", frames) for part in ("mpm", "sph")]
    assert [case.label for case in only(*paths)] == ["mpm/run", "sph/run"]
    assert [case.label for case in only(paths[0], paths[0] / "run.vtkhdf")] != ["run", "run"]


def test_runs_of_different_dimension_are_refused(tmp_path):
    flat, deep = write(tmp_path / "a", [block(0.5, 0.5)] * 2), write(tmp_path / "b", [block(0.5, 0.5, 0.5)] * 2, 3)
    with pytest.raises(InputError, match=r"a 3-D run; .* is 2-D"):
        only(flat, deep)


@pytest.mark.parametrize(("solver", "expected"), [
    ('method = "mpm"\ntransfer = "apic"\nflip_ratio = 0.97', "apic"),
    ('method = "mpm"\ntransfer = "aflip"\nflip_ratio = 0.99', "aflip 0.99"),
    ('method = "sph"\n[solver.sph]\nviscosity = 0.1\nquadratic_viscosity = 0.0\ndisorder_damping = 0.5',
     "alpha 0.1, gamma 0.5"),
    ('method = "sph"\n[solver.sph]\nviscosity = 0.0', "none")])
def test_damping_of_a_method(solver, expected, tmp_path):
    scene = f'name = "made_up"\ngravity = 9.81\n[solver]\n{solver}\n'
    assert only(write(tmp_path / "run", [block(1.0, 1.0)] * 2, scene=scene))[0].damping == expected


def test_profile_along_a_thalweg_that_bends(tmp_path):
    """A ribbon of snow 0.5 m deep on ground that falls by a fifth, 3 m along x and then 4 m along y, far from the
    origin of the map; and one that ends a metre earlier."""
    offset = np.array([247000.0, 352000.0, 900.0])
    s = np.arange(0.0, 8.0, 0.1)
    corner = np.clip(s, None, 3.0), np.clip(s - 3.0, 0.0, None)
    way = Way(np.column_stack(corner) + offset[:2], s, 900.0 - 0.2 * s)
    runs = []
    for length in (7.0, 6.0):
        along, beside, up = (values.ravel() for values in np.meshgrid(
            np.arange(0.025, length, SPACING), np.arange(-0.2, 0.2, SPACING), np.arange(0.025, 0.5, SPACING)))
        on_x = along < 3.0
        x, y = np.where(on_x, along, 3.0 + beside), np.where(on_x, beside, along - 3.0)
        x = np.column_stack([x, y, up - 0.2 * along])
        with RunWriter(tmp_path / f"{length:g}", origin=offset, provenance={
                "scene": SCENE, "particle_spacing": SPACING, "dx": 2.0 * SPACING}) as writer:
            for time in (0.0, 1.0):
                writer.history(time, {"front": 0.0, "steps": 1.0}, {})
                writer.frame(time, x, {})
        runs.append(tmp_path / f"{length:g}")
    found = [profile(case, case.run.frame(1), way=way) for case in only(*runs)]
    assert [one.front for one in found] == pytest.approx([7.0, 6.0], abs=0.15)
    middle = (found[0].s > 0.5) & (found[0].s < 2.5)
    np.testing.assert_allclose(found[0].top[middle], 0.5, atol=0.05)
    assert found[0].along == "s" and Way.of(only(runs[0])[0].run) is None


def test_the_ground_of_a_depth_averaged_flow_is_that_of_the_way():
    """Cells 1 m wide on ground that also falls across the way: their depth stands on the way's ground, level or not."""
    from types import SimpleNamespace

    from snowmpm.comparison.profile import profile

    i, j = (one.ravel() for one in np.meshgrid(np.arange(40), [0, 1], indexing="ij"))
    x = np.column_stack([i + 0.5, np.where(i % 3, j - 0.5, j + 0.5), np.zeros(len(i))])
    x[:, 2] = 0.5 * x[:, 1] + 0.05  # of a film 0.1 m deep
    way = SimpleNamespace(strip=lambda x, width: (np.ones(len(x), bool), x[:, 0], x[:, 2]))
    case = SimpleNamespace(positions=lambda frame: x, spacing=0.5, in_plan=True)
    found = profile(case, SimpleNamespace(fields={"depth": np.full(len(x), 0.1)}), way=way)
    assert not found.bottom.any() and found.top == pytest.approx(np.full(len(found.s), 0.1), rel=0.2)


def test_stray_grains_are_no_profile():
    """Two grains on the way of another run, and all the rest elsewhere."""
    from types import SimpleNamespace

    from snowmpm.comparison.profile import profile

    way = SimpleNamespace(strip=lambda x, width: (x[:, 0] < 1.0, x[x[:, 0] < 1.0, 0], x[x[:, 0] < 1.0, 2]))
    for near, there in ((2, False), (40, True)):
        x = np.column_stack([np.r_[np.linspace(0.0, 0.9, near), np.full(400, 50.0)], np.zeros(400 + near),
                             np.full(400 + near, 0.05)])
        case = SimpleNamespace(positions=lambda frame, x=x: x, spacing=0.1, in_plan=False,
                               volumes=lambda frame, x=x: np.full(len(x), 0.001))
        assert (profile(case, None, way=way) is not None) == there
