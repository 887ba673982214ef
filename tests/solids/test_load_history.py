"""The record of loads on obstacles: means are exact, rows are few, and a checkpoint in between changes nothing."""

import numpy as np
import pytest

from snowmpm.solids.loads import LoadHistory


def steps(n, dim=2, obstacles=2, seed=0):
    """Times (n,) and totals (n, obstacles, dim + 1|3 + 1) of made-up steps of any length."""
    rng = np.random.default_rng(seed)
    width = dim + (1 if dim == 2 else 3) + 1
    return np.cumsum(rng.uniform(0.5, 1.5, n)) * 1e-3, np.cumsum(rng.normal(size=(n, obstacles, width)), axis=0)


def recorded(times, totals, dim, frames, rows=16, interrupt=None):
    """Rows of one obstacle after another, joined over the frames; the history goes through `interrupt` after a step."""
    history, taken = LoadHistory(["wall", "mast"], dim, rows), []
    for k, (time, total) in enumerate(zip(times, totals, strict=True)):
        history.watch(time, total)
        if k in frames:
            taken.append(history.take())
        if k == interrupt:
            state, history = history.state(), LoadHistory(["wall", "mast"], dim, rows)
            history.restore(state)
    return history, taken


@pytest.mark.parametrize("dim", [2, 3])
def test_impulse_of_the_rows_is_all_the_impulse_there_was(dim):
    times, totals = steps(500, dim)
    history, taken = recorded(times, totals, dim, {99, 299, 499})
    before = np.zeros(totals.shape[1:])
    for last, rows in zip((99, 299, 499), taken, strict=True):
        for o, name in enumerate(("wall", "mast")):
            row = rows[name]
            assert row["time"][-1] == times[last] and (np.diff(row["time"]) > 0.0).all()
            start = 0.0 if last == 99 else times[{299: 99, 499: 299}[last]]
            spans = np.diff(np.concatenate([[start], row["time"]]))
            gained = totals[last, o] - before[o]
            assert np.allclose(spans @ row["force"], gained[:dim], rtol=0.0, atol=1e-10)
            assert np.allclose(spans @ row["moment"], gained[dim:-1].squeeze(), rtol=0.0, atol=1e-10)
            assert np.array_equal(row["impulse"][-1], totals[last, o, :dim]) and row["work"][-1] == totals[last, o, -1]
            assert row["moment"].shape == ((len(spans),) if dim == 2 else (len(spans), 3))
        before = totals[last]
    mean = (totals[499] - totals[299]) / (times[499] - times[299])
    axes = "xz" if dim == 2 else "xyz"
    assert [history.means()[f"mast_force_{axis}"] for axis in axes] == pytest.approx(mean[1, :dim])
    assert history.mean_units()["wall_moment" if dim == 2 else "wall_moment_y"] == ("N m/m" if dim == 2 else "N m")


def test_every_step_is_kept_while_they_are_few_and_rows_stay_bounded_when_they_are_many():
    times, totals = steps(5000)
    _, taken = recorded(times, totals, 2, {15, 4999})
    assert np.array_equal(taken[0]["wall"]["time"], times[:16])
    assert 16 <= len(taken[1]["wall"]["time"]) <= 33
    # Where the frames hold few steps again, the record becomes fine again.
    _, taken = recorded(times, totals, 2, {2000, *range(2005, 2100, 5)})
    assert [len(rows["wall"]["time"]) for rows in taken][-3:] == [5, 5, 5]


@pytest.mark.parametrize("interrupt", [20, 57, 99])
def test_a_checkpoint_in_between_changes_nothing(interrupt):
    times, totals = steps(150, 3)
    (one, there), (other, back) = (recorded(times, totals, 3, {99, 149}, interrupt=k) for k in (None, interrupt))
    assert one.means() == other.means()
    for a, b in zip(there, back, strict=True):
        assert all(np.array_equal(a[name][key], b[name][key]) for name in a for key in a[name])


def test_no_time_no_rows():
    history = LoadHistory(["wall"], 2)
    assert history.take() == {} and set(history.means().values()) == {0.0}
    history.watch(0.1, np.array([[1.0, 2.0, 3.0, 4.0]]))
    assert history.take()["wall"]["force"].tolist() == [[10.0, 20.0]]
    assert history.take() == {}
    assert history.means() == {"wall_force_x": 10.0, "wall_force_z": 20.0, "wall_moment": 30.0}
