"""What a user reads when a scene is wrong: file, key, value, what is allowed; two lines at most."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from snowmpm.errors import InputError
from snowmpm.scenes import load_scene


def message(path, changes):
    with pytest.raises(InputError) as caught:
        load_scene(path, changes)
    return str(caught.value)


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"solver.dx": -1}, "solver.dx = -1: must be > 0"),
        ({"solver.dx": "0.1"}, 'solver.dx = "0.1": must be a number'),
        ({"solver.dx": True}, "solver.dx = true: must be a number"),
        ({"solver.dx": float("nan")}, "solver.dx = nan: must be a finite number"),
        ({"solver.dxx": 1}, "solver.dxx = 1: unknown key; did you mean dx?"),
        ({"solver.d\nx": 1}, "solver.d\\nx = 1: unknown key; did you mean dx?"),
        ({"solver.kernel": "\x1b[2J"}, 'solver.kernel = "\\x1b[2J": must be "quadratic", "cubic", "gimp" or "linear"'),
        ({"solver.<dx": 1}, "solver.<dx = 1: unknown key; did you mean dx?"),
        ({"solver": 3}, "solver = 3: must be a table"),
        ({"solver.particles_per_cell": 3.5}, "solver.particles_per_cell = 3.5: must be a whole number"),
        ({"solver.kernel": "cubik"}, 'solver.kernel = "cubik": must be "quadratic", "cubic", "gimp" or "linear"; did'
         " you mean cubic?"),
        (
            {"terrain.kind": "plan"},
            'terrain.kind = "plan": must be one of "plane", "profile", "mesh", "dem"; did you mean plane?',
        ),
        ({"terrain": {"points": 1}}, 'terrain.kind is missing: one of "dem", "mesh", "plane", "profile"'),
        ({"terrain.pionts": 3}, "terrain.pionts = 3: unknown key; did you mean points?"),
        ({"materials.slab.density": -250.0}, "materials.slab.density = -250.0: must be > 0"),
        ({"materials.slab.density": "250"}, 'materials.slab.density = "250": must be a number'),
        ({"materials.slab.p0": True}, "materials.slab.p0 = true: must be a number"),
        ({"materials.slab.densty": 3}, "materials.slab.densty = 3: unknown key; did you mean density?"),
        (
            {"bodies.0.shape.region.x": [5, 3]},
            "bodies.0.shape.region.x = [5, 3]: must be [lower, upper] with lower < upper",
        ),
        ({"bodies.0.shape.region": {"z": 3}}, "bodies.0.shape.region.z = 3: unknown key; known here: x, y"),
        ({"bodies.0.shape.top": 0.05}, "bodies.0.shape.top = 0.05: must be above bottom = 0.1"),
        (
            {"bodies.0.shape": {"kind": "layer"}},
            "bodies.0.shape.top is missing: distance of its upper face from the terrain [m]",
        ),
        ({"bodies.0.velocity": [0, 0, 0]}, "bodies.0.velocity = [0, 0, 0]: must be 2 numbers, [x, z], in a 2-D scene"),
        ({"bodies.0.velocity": ["a", 0]}, 'bodies.0.velocity.0 = "a": must be a number'),
        (
            {"bodies.0.material": "sl"},
            'bodies.0.material = "sl": must be one of the materials: slab, weak_layer; did you mean slab?',
        ),
        ({"gravity": "x"}, 'gravity = "x": must be a number'),
        (
            {"domain.boundary": "opn"},
            'domain.boundary = "opn": must be "open", "slip", "symmetric", "stick", "separate" or "periodic"; did you'
            " mean open?",
        ),
        (
            {"domain.boundary": {"x_min": "s"}},
            'domain.boundary.x_min = "s": must be "open", "slip", "symmetric", "stick", "separate" or "periodic"',
        ),
        ({"terrain.points": [[0, 1], [0, 2]]}, "terrain.points.1 = [0.0, 2.0]: x must grow from point to point"),
        ({"bodies": []}, "bodies = []: too few entries, at least 1 needed"),
    ],
    ids=lambda value: str(value)[:50],
)
def test_message(scene_file, changes, expected):
    assert message(scene_file, changes) == f"{scene_file}: {expected}"


def test_missing_key_says_what_it_is(scene_file):
    scene_file.write_text(scene_file.read_text().replace("dx = 0.1 ", "# "))
    text = message(scene_file, {})
    assert text == (f"{scene_file}: solver.dx is missing: grid spacing (mpm; in plan: depth) or particle spacing (sph)"
                    " [m]")


def test_a_misspelt_key_stands_before_the_one_it_hides(scene_file):
    scene_file.write_text(scene_file.read_text().replace("dx = 0.1 ", "dxx = 0.1 "))
    first, second = message(scene_file, {}).split("\n")
    assert first.endswith("solver.dxx = 0.1: unknown key; did you mean dx?")
    assert "solver.dx is missing" in second


def test_many_faults_make_two_lines(scene_file):
    text = message(scene_file, {"end_time": -1, "seed": -1, "solver.dx": -1, "solver.cfl": -1})
    assert len(text.split("\n")) == 2
    assert text.endswith("(and 2 more)")


WIND = {"kind": "acceleration", "value": ["1 - vx", 0.0]}


@pytest.mark.parametrize(("changes", "expected"), [
    ({"forces": [{**WIND, "value": ["q*t", 0.0]}]}, 'forces.0.value.0 = "q*t": q: a formula knows x, z, vx, vz, t, pi'),
    ({"forces": [{**WIND, "value": ["sine(t)", 0.0]}]}, "did you mean sin?"),
    ({"forces": [{**WIND, "value": ["y", 0.0]}]}, "y: a formula knows x, z"),
    ({"forces": [{**WIND, "value": ["x.real", 0.0]}]}, 'forces.0.value.0 = "x.real": a formula is made of numbers'),
    ({"forces": [{**WIND, "value": [1.0]}]}, "forces.0.value"),
    ({"forces": [{**WIND, "value": [1.0, 2.0, 3.0]}]}, "must have 2 entries, one an axis"),
    ({"forces": [{"kind": "acceleration"}]}, "needs value or file, and not both"),
    ({"forces": [{"kind": "pressure", "value": "x +"}]}, 'must be a formula such as "2.0*sin(3.0*t)"'),
    ({"forces": [{"kind": "pressure", "value": 1.0, "acts_on": "surfaces"}]}, "did you mean surface?"),
    ({"forces": [{"kind": "wind"}]}, 'forces.0.kind = "wind": must be one of "traction", "follower_pressure"'),
    ({"forces": [{"kind": "traction", "name": "pull", "body": "slap", "value": [1.0, 0.0]}]},
     'forces.0.body = "slap": must be one of the bodies'),
    ({"forces": [{"kind": "displacement", "name": "grip", "body": "slab", "value": [1.0, 0.0], "contact": "stik"}]},
     "did you mean stick?"),
    ({"forces": [{"kind": "follower_pressure", "body": "slab", "value": 1.0}]}, "forces.0.name is missing"),
    ({"forces": [{**WIND, "body": "slap"}]}, 'forces.0.body = "slap": must be one of the bodies'),
    ({"forces": [{**WIND, "start": 2.0, "stop": 1.0}]}, "forces.0.stop = 1.0: must be after start = 2"),
    ({"forces": [{**WIND, "file": "absent.csv"}]}, "forces.0"),
    ({"gravity": {"ramp": -1.0}}, "gravity.ramp = -1.0: must be > 0"),
    ({"gravity": {"rampe": 1.0}}, "gravity.rampe = 1.0: unknown key; did you mean ramp?"),
    ({"gravity": {"value": 9.81}}, "needs one of ramp, times and file"),
    ({"gravity": {"times": [0.0, 1.0], "values": [1.0, [1.0, 2.0, 3.0]]}}, "gravity.values.1"),
    ({"damping": {"coefficient": 0.0}}, "damping.coefficient = 0.0: must be > 0"),
    ({"damping": {}}, "damping.coefficient is missing: [1/s]"),
    ({"initial": {"from": 3}}, "initial.from = 3: must be text"),
    ({"initial": {"fron": "runs/a"}}, "unknown key; did you mean from?"),
])
def test_forces_gravity_and_damping(scene_file, changes, expected):
    text = message(scene_file, changes)
    assert expected in text and text.startswith(f"{scene_file}: "), text


def test_long_values_are_cut(scene_file):
    assert len(message(scene_file, {"solver.dx": "x" * 10_000}).removeprefix(str(scene_file))) < 120


KEYS = [
    *("name", "dimension", "end_time", "gravity", "seed", "output", "output.fields", "output.fields.0", "solver"),
    *("solver.dx", "solver.particles_per_cell", "domain", "domain.min", "domain.boundary", "terrain", "terrain.kind"),
    *("terrain.points", "terrain.points.0", "materials", "materials.slab", "materials.slab.kind", "materials.slab.p0"),
    *("bodies", "bodies.0", "bodies.0.name", "bodies.0.material", "bodies.0.shape", "bodies.0.shape.kind"),
    *("bodies.0.shape.top", "bodies.0.shape.region", "bodies.0.shape.region.x", "bodies.0.shape.region.file"),
    *("obstacles.0.motion", "obstacles.0.shape.kind", "events", "events.0.kind", "events.0.path", "initial.stress"),
    *("obstacles.0.motion.angular_velocity", "obstacles.0.motion.centre", "obstacles.0.motion.file"),
    *("gravity.value", "gravity.ramp", "gravity.times", "forces", "forces.0", "forces.0.kind", "forces.0.value.0"),
    *("forces.0.value", "forces.0.within", "forces.0.region", "damping", "damping.coefficient", "initial.from"),
    *("new", "solver.new", "bodies.0.shape.new", "materials.slab.new"),
]
WORDS = st.sampled_from(["mesh", "polygon", "file", "layer", "plane", "dem", "load", "elastic", "kind", "<number>", ""])
LEAVES = st.one_of(st.integers(), st.floats(), st.booleans(), WORDS, st.text(max_size=5))
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS | st.sampled_from("xyz"), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=st.dictionaries(st.sampled_from(KEYS), VALUES, min_size=1, max_size=3))
def test_whatever_stands_in_a_scene_it_loads_or_gets_a_message(scene_file, changes):
    try:
        scene = load_scene(scene_file, changes)
    except InputError as error:
        lines = str(error).split("\n")
        assert 1 <= len(lines) <= 2
        assert all(line.startswith(f"{scene_file}: ") for line in lines)
    else:
        resolved = scene_file.with_name("resolved.toml")
        resolved.write_text(scene.to_toml(), encoding="utf-8")
        assert load_scene(resolved).model_dump() == scene.model_dump()
