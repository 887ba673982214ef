"""Rigid motion: rotations, ramps that integrate exactly, tables, and the words of what is wrong with one."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import fixed_quad
from scipy.spatial.transform import Rotation

from snowmpm.errors import InputError
from snowmpm.solids import Obstacle
from snowmpm.solids.motion import RigidMotion, Tabulated, Uniform
from snowmpm.solids.motion_table import read_motion_table
from snowmpm.solids.rotation import rotation_matrix, turn_velocity
from tests.support.tables import Table

DT = 1e-5
CENTRE = {2: np.array([1.0, -0.5]), 3: np.array([1.0, 2.0, -0.5])}
VELOCITY = {2: np.array([0.4, -0.2]), 3: np.array([0.4, 0.1, -0.2])}
OMEGA = {2: 1.3, 3: np.array([0.7, -1.1, 0.4])}


def courses(dim):
    times = np.array([0.0, 0.3, 0.8, 1.5])
    rng = np.random.default_rng(1)
    turns = rng.normal(size=4) if dim == 2 else rng.normal(size=(4, 3))
    return [Uniform(VELOCITY[dim], OMEGA[dim], 0.2, 1.4, 0.3), Tabulated(times, rng.normal(size=(4, dim)), turns, 0.1)]


@pytest.mark.parametrize("size", [0.0, 1e-6, 0.9e-4, 1.1e-4, 1e-2, 1.0, 3.0, 10.0])
def test_rotations_in_space_are_those_of_their_vector(size):
    turn = size * np.array([2.0, -1.0, 2.0]) / 3.0
    assert np.allclose(rotation_matrix(turn), Rotation.from_rotvec(turn).as_matrix(), rtol=0.0, atol=1e-15)


def test_a_positive_angle_turns_x_towards_z():
    assert np.allclose(rotation_matrix(0.5 * np.pi) @ [1.0, 0.0], [0.0, 1.0], atol=1e-15)
    assert turn_velocity(0.4, 2.0) == 2.0


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("kind", [0, 1])
@pytest.mark.parametrize("time", [0.25, 0.45, 0.7, 1.0, 1.35])
def test_velocity_is_the_rate_of_change_of_the_position(dim, kind, time):
    """By differences of the positions of points that move along: their error is DT^2 / 6 of the third derivative."""
    motion = RigidMotion(CENTRE[dim], courses(dim)[kind])
    body = np.random.default_rng(2).normal(size=(20, dim))
    rate = (motion.moved(body, time + DT) - motion.moved(body, time - DT)) / (2.0 * DT)
    assert np.allclose(motion.velocity_at(motion.moved(body, time), time), rate, rtol=0.0, atol=2e-7)
    assert np.linalg.norm(rate, axis=1).min() > 0.01
    pose = motion.pose(time)
    assert np.allclose(pose.rotation @ pose.rotation.T, np.eye(dim), rtol=0.0, atol=1e-14)
    assert np.linalg.det(pose.rotation) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("dim", [2, 3])
def test_placement_is_the_motion_relative_to_an_origin(dim):
    motion, origin = RigidMotion(CENTRE[dim], courses(dim)[0]), np.arange(1.0, 1.0 + dim)
    body = np.random.default_rng(2).normal(size=(5, dim))
    rotation, shift = motion.placement(0.9, origin)
    assert np.allclose((body - origin) @ rotation.T + shift, motion.moved(body, 0.9) - origin, rtol=0.0, atol=1e-14)


def test_ramps_start_and_end_smoothly_and_the_way_is_their_integral():
    course = Uniform(np.array([2.0, 0.0]), 0.5, start=1.0, stop=4.0, ramp=0.8)
    speeds = [course.at(t)[2][0] for t in (0.5, 1.0, 1.4, 1.8, 2.5, 3.2, 3.6, 4.0, 9.0)]
    assert speeds == pytest.approx([0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 1.0, 0.0, 0.0], abs=1e-15)
    for t in (1.3, 1.8, 2.0, 3.5, 4.0, 7.0):
        ends = np.minimum([0.0, 1.0, 1.8, 3.2, 4.0, 9.0], t)
        way = sum(fixed_quad(np.vectorize(lambda s: course.at(s)[2][0]), a, b)[0] for a, b in pairwise(ends))
        assert course.at(t)[0][0] == pytest.approx(way, abs=1e-12)
    assert course.at(9.0)[0][0] == pytest.approx(2.0 * (3.0 - 0.8), rel=1e-14)
    assert course.at(9.0)[1] == pytest.approx(0.5 * (3.0 - 0.8), rel=1e-14)


def test_without_a_ramp_the_speed_is_there_from_the_start_until_the_stop():
    course = Uniform(np.array([2.0, 0.0]), 0.0, start=0.0, stop=1.0)
    assert [course.at(t)[2][0] for t in (0.0, 0.999, 1.0)] == [2.0, 2.0, 0.0]
    assert course.at(3.0)[0].tolist() == [2.0, 0.0]
    assert Uniform(np.zeros(2), 0.0).still and not Uniform(np.zeros(2), 0.1).still and RigidMotion([0.0, 0.0]).still


def test_a_scene_says_it_in_degrees_and_the_middle_of_the_shape_is_the_centre():
    spec = SimpleNamespace(velocity=(0.0, 0.0), angular_velocity=90.0, centre=None, start=0.0, stop=1.0, ramp=0.0,
                           file=None)
    motion = RigidMotion.of(spec, np.array([1.0, 1.0]))
    assert np.allclose(motion.moved(np.array([[2.0, 1.0]]), 5.0), [[1.0, 2.0]], atol=1e-15)
    spec.centre = (2.0, 1.0)
    assert RigidMotion.of(spec, np.array([1.0, 1.0])).moved(np.array([[2.0, 1.0]]), 5.0).tolist() == [[2.0, 1.0]]
    assert RigidMotion.of(None, np.array([1.0, 1.0])).still


def table(tmp_path, text):
    (tmp_path / "motion.csv").write_text(text)
    return "motion.csv", tmp_path


def test_a_table_goes_through_its_rows_and_rests_outside_them(tmp_path):
    text = "# a push\ntime [s], z [m], angle [degrees]\n0.5, 0.0, 0\n1.0, 0.2, 45\n\n2.0, 0.1, 90\n"
    motion = Tabulated(*read_motion_table(*table(tmp_path, text), 2), start=0.25)
    for t, z, angle in ((0.0, 0.0, 0.0), (0.75, 0.0, 0.0), (1.25, 0.2, 45.0), (2.25, 0.1, 90.0), (9.0, 0.1, 90.0)):
        shift, turn, velocity, omega = motion.at(t)
        assert shift == pytest.approx([0.0, z], abs=1e-15) and np.degrees(turn) == pytest.approx(angle, abs=1e-13)
        assert (t in (0.0, 9.0)) == (not velocity.any() and omega == 0.0)
    heights = [motion.at(t)[0][1] for t in np.linspace(0.0, 3.0, 400)]
    assert min(heights) >= 0.0 and max(heights) <= 0.2  # no overshoot
    assert motion.at(1.25)[2][1] == pytest.approx(0.0, abs=1e-12)  # the turning point


def test_the_key_of_the_obstacle_stands_before_what_is_wrong_with_its_table(tmp_path):
    file, folder = table(tmp_path, "time,x\n0,0\n")
    spec = Table(name="o", shape=SimpleNamespace(kind="sphere", centre=(0.0, 0.0), radius=1.0),
                 motion=SimpleNamespace(centre=None, file=file, start=0.0), contact="slip", friction=0.0)
    with pytest.raises(InputError, match=r"^obstacles\.0 \(o\): .*motion\.csv: needs a line"):
        Obstacle.of(spec, 2, folder, "obstacles.0 (o)")


def test_a_table_in_space_turns_about_any_axis(tmp_path):
    text = "time,angle_y,x\n0,0,0\n2,180,4\n"
    motion = RigidMotion(np.zeros(3), Tabulated(*read_motion_table(*table(tmp_path, text), 3)))
    assert np.allclose(motion.moved(np.array([[1.0, 0.0, 0.0]]), 1.0), [[2.0, 0.0, -1.0]], atol=1e-14)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("time,x\n0,0\n", "at least two rows"),
        ("time,x,y\n0,0,0\n1,0,0\n", "column y: must be one of time, x, z, angle in a 2-D scene"),
        ("time,x,x\n0,0,0\n1,0,0\n", "column x: twice"),
        ("time\n0\n1\n", "needs a column time and at least one of"),
        ("x,z\n0,0\n1,1\n", "needs a column time"),
        ("time,x\n0,0\n1,nan\n", "line 3: '1,nan': must be 2 finite numbers"),
        ("time,x\n0,0\n1\n", "line 3: '1': must be 2 finite numbers"),
        ("time,x\n0,0\n\n1,0\n1,0\n", "line 5: time = 1: must be after 1"),
    ],
)
def test_what_is_wrong_with_a_table_is_said_in_one_line(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        read_motion_table(*table(tmp_path, text), 2)
    assert "motion.csv" in str(caught.value) and "\n" not in str(caught.value)


def test_a_table_that_is_no_text_or_not_there(tmp_path):
    (tmp_path / "motion.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not a text file"):
        read_motion_table("motion.csv", tmp_path, 2)
    with pytest.raises(InputError, match="no such file"):
        read_motion_table("absent.csv", tmp_path, 2)
