"""A short saw test from scene to plot: what is recorded, that it survives an interruption, that pictures come of it."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import snowmpm
from snowmpm.cli.app import app
from snowmpm.io import Run

SHORT = {"solver.dx": 0.025, "saw_test.length": 1.5, "saw_test.saw_speed": 4.0, "saw_test.saw_start": 0.005,
         "saw_test.saw_length": 0.5, "end_time": 0.12, "initial.stress": "geostatic", "output.interval": 0.01}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return snowmpm.run(snowmpm.load_scene("pst_2d", SHORT), tmp_path_factory.mktemp("saw_test") / "run")


def test_the_saw_takes_the_weak_layer_away(run):
    test = run.saw_test
    assert test["saw"][0] == 0.0 and test["saw"][-1] == pytest.approx(4.0 * (0.12 - 0.005), abs=0.03)
    assert (np.diff(test["saw"]) >= 0.0).all() and (np.diff(test["tip"]) >= 0.0).all()
    assert (test["tip"] >= test["saw"] - 0.05).all()  # sawn bins count, a bin wide
    gone = run.n_points(0) - run.n_points(-1 % len(run))
    assert gone == pytest.approx(test["saw"][-1] / 0.0125 * 4, rel=0.1)  # four rows of particles, 12.5 mm apart


def test_record_is_finer_than_the_frames(run):
    time = run.saw_test["time"]
    assert len(time) > 10 * len(run) and time[0] == 0.0 and time[-1] <= 0.12 + 1e-9
    assert np.diff(time).max() < 2.0 * np.diff(time).min() + 1e-9


def test_summary_tells_what_was_measured(run):
    found, x = run.summary["saw_test"], run.saw_test["x"]
    assert 0.05 < found["critical_length"] < 0.5 and found["runs_to_the_end"]
    assert found["top_speed"] is None
    assert found["reasons"]["top_speed"].startswith("column too short to tell: needs 2.") \
        and found["reasons"]["top_speed"].endswith("m, has 1.50 m")
    assert found["theory"]["maxwell_load"] == pytest.approx(685.3, rel=1e-3)
    assert found["theory"]["fracture_energy"] == pytest.approx(0.323, rel=2e-3)
    assert found["saw"] == {"saw_speed": 4.0, "saw_start": 0.005, "saw_length": 0.5, "notch": 0.0}
    assert np.isfinite(run.saw_test["arrival"][(x > 0.5) & (x < 1.3)]).all()  # the free end breaks late or never


def test_slab_and_energy(run):
    """The free end sinks most, the far one not yet; what the weak layer took is no more than was dissipated in all."""
    test = run.saw_test
    settled = test["settlement"][-1]
    assert settled[0] > 3.0 * settled[-1] > -1e-3 and settled[0] < 0.05
    # work at the arrival is the row of that time
    i = int(np.argmin(np.abs(test["x"] - 1.0)))
    row = int(np.searchsorted(test["time"], test["arrival"][i]))
    assert test["fracture_energy"][i] == pytest.approx(test["work"][row, i], rel=1e-5)
    assert (np.diff(test["plastic_work"]) >= 0.0).all()
    own = np.isfinite(test["arrival"])
    width = test["x"][1] - test["x"][0]
    assert test["work"][-1][own].sum() * width == pytest.approx(test["plastic_work"][-1], rel=0.15)


def test_resumed_run_is_the_same(run, tmp_path):
    """Stopped halfway, and gone on with from its checkpoint: the same rows, bit for bit."""
    scene = snowmpm.load_scene("pst_2d", {**SHORT, "output.checkpoint_interval": 0.025})

    class Stop(Exception):
        pass

    def stop(progress):
        if progress.time > 0.08:  # past a checkpoint with the cut begun: what is sawn away must be remembered
            raise Stop

    with pytest.raises(Stop):
        snowmpm.run(scene, tmp_path, progress=stop)
    whole = snowmpm.run(scene, tmp_path, resume=True).saw_test
    for name, values in run.saw_test.values.items():
        np.testing.assert_array_equal(whole[name], values, err_msg=name)


def test_plot_and_info(run):
    shell = CliRunner()
    done = shell.invoke(app, ["plot", str(run.path.parent)])
    assert done.exit_code == 0 and "saw_test.png" in done.output and "history.png" in done.output
    assert (run.path.parent / "saw_test.png").stat().st_size > 50_000
    done = shell.invoke(app, ["info", str(run.path.parent)])
    assert "critical_length" in done.output and "saw test" in done.output
    assert json.loads((run.path.parent / "summary.json").read_text())["saw_test"]["crack_length"] > 1.0


def test_data_set_and_table(run):
    """Every value has its axis, every number its unit and definition."""
    pytest.importorskip("xarray")
    from snowmpm.saw_test.crack import BINS, LINES, SERIES

    data, test = run.to_xarray("saw_test"), run.saw_test
    assert test.bins == set(BINS) and set(test.values) == {*BINS, *LINES, *SERIES}
    assert all(data[name].dims == ("x",) for name in BINS) and data.tip.dims == ("time",)
    table = run.to_pandas("saw_test")
    assert table.loc["critical_length", "value"] == run.summary["saw_test"]["critical_length"]
    assert table.loc[["plastic_work", "theory.maxwell_load", "saw.saw_speed"], "unit"].tolist() == ["J/m", "Pa", "m/s"]
    assert all(table["definition"]) and table.attrs["units"]["crack_speed"] == "m/s"
    assert table.attrs["not_final"] == []
    if importlib.util.find_spec("weac"):
        assert 0.05 < table.loc["theory.critical_length_weac", "value"] < 1.0


def test_a_bin_that_the_saw_enters_stays_broken(run):
    """On a slope a leaning column is cut at the lower end of a bin first: its broken particles leave one by one."""
    simulation = snowmpm.Simulation(snowmpm.load_scene("pst_2d", {**SHORT, "saw_test.slope_angle": 45.0,
                                                                  "initial.stress": "none"}))
    crack = simulation.crack
    crack.bins["arrival"][:6] = 0.001  # broken before, and now with none of the broken particles left
    crack._measure()
    assert crack.values()["tip"][-1] == pytest.approx(6 * crack.bin)


def test_elastic_weak_layer_never_breaks():
    """Only the saw opens it; the slab bends down over the cut."""
    simulation = snowmpm.Simulation(snowmpm.load_scene("pst_2d", {
        **SHORT, "saw_test.weak_layer": {"material": "slab", "thickness": 0.05}, "saw_test.notch": 0.3,
        "saw_test.saw_length": 0.3}))
    while simulation.time < 0.01:
        simulation.step()
    values = simulation.crack.values()
    assert np.isnan(values["arrival"]).all() and values["tip"][-1] == pytest.approx(0.3)
    assert values["settlement"][-1][0] > 10.0 * abs(values["settlement"][-1][-1])


def test_plain_runs_have_no_saw_test(tmp_path):
    file = Path(__file__).parents[1] / "release.toml"
    scene = snowmpm.load_scene(file, {"end_time": 0.002, "initial.stress": "none"})
    assert Run(snowmpm.run(scene, tmp_path).path).saw_test is None
