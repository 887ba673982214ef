"""Gravity over time: means are exact integrals, tables are read, and wrong ones refused."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.prescribed.course import Course
from snowmpm.scenes.gravity import Gravity


def course(dim=2, base_dir=".", **keys):
    return Course.of(Gravity.model_validate(keys), dim, base_dir)


def test_ramp():
    found = course(value=10.0, ramp=2.0, start=1.0)
    assert found.at(1.0) == pytest.approx([0.0, 0.0]) and found.at(2.0) == pytest.approx([0.0, -5.0])
    assert found.at(3.0) == pytest.approx([0.0, -10.0]) and found.at(9.0) == pytest.approx([0.0, -10.0])
    assert found.mean(1.0, 2.0) == pytest.approx([0.0, -10.0 * (1 / 4 - 1 / 16) * 2.0 / 2.0], rel=1e-12)


def test_tilt_keeps_the_size():
    found = course(times=[0.0, 10.0], tilts=[0.0, 30.0])
    for time, angle in ((0.0, 0.0), (5.0, 15.0), (20.0, 30.0)):
        angle = np.radians(angle)
        np.testing.assert_allclose(found.at(time), 9.81 * np.array([np.sin(angle), -np.cos(angle)]), atol=1e-12)
    assert (found.strongest >= np.abs(found.at(10.0)) - 1e-12).all()


def test_table_of_vectors_in_3d():
    found = course(3, times=[0.0, 1.0, 2.0], values=[[0.0, 0.0, 0.0], [1.0, 2.0, -3.0], [1.0, 0.0, 0.0]])
    np.testing.assert_allclose(found.at(0.5), [0.5, 1.0, -1.5])
    np.testing.assert_allclose(found.mean(0.2, 0.8), [0.5, 1.0, -1.5])


def test_file(tmp_path):
    (tmp_path / "shaking.csv").write_text("time [s], x [m/s2]\n# the ground\n0, 0\n0.5, 2\n1, -2\n")
    found = course(base_dir=tmp_path, file="shaking.csv")
    np.testing.assert_allclose(found.at(0.25), [1.0, -9.81])
    np.testing.assert_allclose(found.at(0.75), [0.0, -9.81], atol=1e-15)


@pytest.mark.parametrize(("text", "message"), [
    ("x\n0\n1\n", "needs a column time"), ("time,x\n0,0\n0,1\n", "line 3: time must grow"),
    ("time,q\n0,0\n1,1\n", "column q"), ("time,x\n0,nan\n1,1\n", "line 2"), ("time,x\n0,0\n", "two rows"),
    ("time,x\n0,0\n1\n", "line 3"), ("time,x,x\n0,0,0\n1,0,0\n", "twice"),
])
def test_wrong_files(tmp_path, text, message):
    (tmp_path / "g.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        course(base_dir=tmp_path, file="g.csv")


@pytest.mark.parametrize(("keys", "message"), [
    ({}, "needs one of ramp, times and file"), ({"ramp": 1.0, "times": [0.0, 1.0]}, "not ramp and times"),
    ({"times": [0.0, 1.0]}, "times go with"), ({"times": [0.0, 0.0], "tilts": [0.0, 1.0]}, "must grow"),
    ({"times": [0.0, 1.0], "values": [1.0]}, "too_short|at least"),
    ({"times": [0.0, 1.0], "tilts": [1.0, 2.0, 3.0]}, "as many entries"), ({"ramp": 0.0}, "greater than 0"),
    ({"times": [0.0, 1.0], "values": [1.0, [1.0, 2.0]]}, "all numbers or all vectors"),
    ({"tilts": [1.0, 2.0]}, "one of"),
])
def test_wrong_tables(keys, message):
    with pytest.raises(ValueError, match=message):
        Gravity.model_validate(keys)
