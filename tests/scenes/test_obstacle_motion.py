"""Motion of obstacles in a scene: what may be said, what is refused and in which words."""

import pytest

from snowmpm.errors import InputError
from snowmpm.scenes import load_scene

SPACE = {"dimension": 3, "domain": {}, "terrain": {"kind": "plane"}, "events": [],
         "bodies": [{"name": "b", "material": "slab", "shape": {"kind": "sphere", "centre": [0, 0, 1], "radius": 1}}],
         "obstacles.0.shape": {"kind": "box", "min": [0, 0, 0], "max": [1, 1, 1]}}


def motion(scene_file, table, changes=None):
    return load_scene(scene_file, {**(changes or {}), "obstacles.0.motion": table}).obstacles[0].motion


def test_defaults(scene_file):
    only = motion(scene_file, {"angular_velocity": 5})
    assert only.velocity == (0.0, 0.0) and only.angular_velocity == 5.0
    assert (only.centre, only.start, only.stop, only.ramp, only.file) == (None, 0.0, None, 0.0, None)
    assert motion(scene_file, {"velocity": [1, 0]}).angular_velocity == 0.0
    assert motion(scene_file, {"velocity": [1, 0, 0]}, SPACE).angular_velocity == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("changes", [{}, SPACE])
@pytest.mark.parametrize("file", [False, True])
def test_a_resolved_scene_says_the_same(scene_file, changes, file):
    space = bool(changes)
    table = {"velocity": [0.1, 0.0, 0.2][: 3 if space else 2], "angular_velocity": [0, 0, 90] if space else -20.5,
             "centre": [1, 2, 3][: 3 if space else 2], "start": 0.5, "stop": 2.0, "ramp": 0.75}
    if file:
        (scene_file.parent / "push.csv").write_text("time,x\n0,0\n1,1\n")
        table = {"file": "push.csv", "start": 1.0}
    scene = load_scene(scene_file, {**changes, "obstacles.0.motion": table})
    again = scene_file.with_name("again.toml")
    again.write_text(scene.to_toml())
    resolved = load_scene(again).obstacles[0].motion
    same = {"file": str(scene_file.parent / "push.csv")} if file else {}
    assert resolved == scene.obstacles[0].motion.model_copy(update=same)


REFUSED = [
    ({}, {}, "motion = {}: needs velocity, angular_velocity or file"),
    ({"start": 1.0}, {}, "}: needs velocity, angular_velocity or file"),
    ({"velocity": [1, 0], "stop": 1.0, "start": 1.0}, {}, "motion.stop = 1.0: must be after start = 1"),
    ({"velocity": [1, 0], "stop": 1.0, "ramp": 0.6}, {}, "motion.ramp = 0.6: must be at most half of the time"),
    ({"velocity": [1, 0], "ramp": -1}, {}, "motion.ramp = -1: must be >= 0"),
    ({"velocity": [1, 0, 0]}, {}, "motion.velocity = [1, 0, 0]: must be 2 numbers"),
    ({"angular_velocity": [0, 1]}, {}, "motion.angular_velocity = [0.0, 1.0]: must be a number [degrees/s]"),
    ({"angular_velocity": "fast"}, {}, 'motion.angular_velocity = "fast": must be a number'),
    ({"angular_velocity": 1.0}, SPACE, "motion.angular_velocity = 1.0: must be 3 numbers, [x, y, z] [degrees/s]"),
    ({"angular_velocity": [1, 2]}, SPACE, "motion.angular_velocity = [1, 2]: must be 3 numbers"),
    ({"centre": [0, 0, 0], "velocity": [0, 0]}, {}, "motion.centre = [0, 0, 0]: must be 2 numbers"),
    ({"file": "push.csv", "velocity": [1, 0]}, {}, "motion.velocity = [1.0, 0.0]: does not go with file"),
    ({"file": "push.csv", "ramp": 1.0}, {}, "motion.ramp = 1.0: does not go with file"),
    ({"file": "absent.csv"}, {}, 'motion.file = "absent.csv": no such file'),
    ({"velocity": [1, 0], "speed": 3}, {}, "motion.speed = 3: unknown key"),
]


@pytest.mark.parametrize(("table", "changes", "message"), REFUSED, ids=lambda value: str(value)[:50])
def test_refused(scene_file, table, changes, message):
    (scene_file.parent / "push.csv").write_text("time,x\n0,0\n1,1\n")
    with pytest.raises(InputError) as caught:
        motion(scene_file, table, changes)
    assert message in str(caught.value)
