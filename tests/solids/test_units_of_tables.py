"""A unit in brackets in the head of a table is converted, or refused."""

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.prescribed.space_time_table import SpaceTimeTable
from snowmpm.reading.number_table import UNITS, read_number_table
from snowmpm.solids.motion_table import read_motion_table

ROWS = "0, 0, 0\n1, 2, 3\n"


@pytest.mark.parametrize(("head", "factors"), [
    ("time, x, angle", (1, 1, 1)), ("time [s], x [m], angle [degrees]", (1, 1, 1)),
    ("time [ms], x [mm], angle [rad]", (1e-3, 1e-3, np.degrees(1.0))),
    ("time [min], x [cm], angle [\N{DEGREE SIGN}]", (60, 1e-2, 1)), ("time[ s ], x [km], angle [deg]", (1, 1e3, 1))])
def test_motions(tmp_path, head, factors):
    (tmp_path / "t.csv").write_text(f"{head}\n{ROWS}", encoding="utf-8")
    times, shifts, turns = read_motion_table("t.csv", tmp_path, 2)
    assert (times[1], shifts[1, 0], np.degrees(turns[1])) == pytest.approx([a * b for a, b in zip(
        (1, 2, 3), factors, strict=True)])


@pytest.mark.parametrize(("unit", "factor"), [("m/s2", 1), ("m/s^2", 1), ("g", 9.80665), ("Gal", 0.01)])
def test_accelerations(tmp_path, unit, factor):
    (tmp_path / "t.csv").write_text(f"time, ax [{unit}]\n0, 1\n1, 1\n")
    table = SpaceTimeTable("t.csv", tmp_path, "file", 2, ("ax", "az"), "m/s2")
    assert table.at(np.zeros((1, 2)), 0.5)[0] == pytest.approx([factor, 0.0])


def test_pressures(tmp_path):
    (tmp_path / "t.csv").write_text("time, pressure [kPa]\n0, 1\n1, 1\n")
    assert SpaceTimeTable("t.csv", tmp_path, "file", 2, ("pressure",), "Pa").at(np.zeros((1, 2)), 0.0)[0, 0] == 1e3


@pytest.mark.parametrize("head", [
    "time [m], x [m]", "time [s], x [s]", "time, x [furlong]", "time, x []", "time, x [m/s]"])
def test_other_units_are_refused(tmp_path, head):
    (tmp_path / "t.csv").write_text(f"{head}\n0, 1\n1, 1\n")
    with pytest.raises(InputError, match=r"column (time|x): unit .*: must be (s or ms|m or dm)"):
        read_motion_table("t.csv", tmp_path, 2)


def test_a_unit_of_a_plugin_stands_for_itself(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("time, flux [kg/s]\n0, 1\n1, 1\n")
    assert read_number_table(path, {"time": "s", "flux": "kg/s"})[0]["flux"][0] == 1.0
    path.write_text("time, flux [g/s]\n0, 1\n1, 1\n")
    with pytest.raises(InputError, match="must be kg/s"):
        read_number_table(path, {"time": "s", "flux": "kg/s"})
    assert all(1.0 in factors.values() for factors in UNITS.values())


@pytest.mark.parametrize("head", ["time, x [m", "time, x [m]/1000", "time, x [cm] [m]"])
def test_brackets_hold_a_unit_and_no_more(tmp_path, head):
    (tmp_path / "t.csv").write_text(f"{head}\n0, 1\n1, 1\n")
    with pytest.raises(InputError, match=r"column x: .*must be a unit in brackets"):
        read_motion_table("t.csv", tmp_path, 2)


@pytest.mark.parametrize("text", ["Time;x\n0;1,5\n1;2,5\n", "time;x\n0;1\n1;2\n"])
def test_semicolons_are_named(tmp_path, text):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(InputError, match="save the table with commas"):
        read_motion_table("t.csv", tmp_path, 2)


def test_heads_in_capitals_are_read(tmp_path):
    (tmp_path / "t.csv").write_text("Time,X\n0,1\n1,2\n")
    assert read_motion_table("t.csv", tmp_path, 2)[1][1, 0] == 2.0
