"""Whether a run is final, as pictures, tables and files say it."""

import pytest

from snowmpm.io import Run, RunWriter
from snowmpm.io.remarks import remarks
from snowmpm.io.status import Status, cautions, status_of


def write(folder, rows, complete=True, hazard=True):
    with RunWriter(folder, provenance={"scene_name": "a", "end_time": 60.0}) as writer:
        for time, row in rows.items():
            writer.history(time, {"mass": 100.0, **row}, {})
            writer.frame(time, [[0.0, 0.0, 0.0]], {})
        if hazard:
            writer.hazard({"numbers": {"runout": 1970.0}})
        writer.close(complete=complete)
    return Run(folder)


REST, MOVING = {"moving_share": 0.0, "momentum_share": 0.01}, {"moving_share": 0.98, "momentum_share": 0.7}


def test_a_run_at_rest_is_final(tmp_path):
    status = status_of(write(tmp_path, {0.0: MOVING, 45.0: REST}))
    assert status.final and status.text == "final: at rest when it ended, at 45 s"
    assert status.so_far == "" and not status.warnings


@pytest.mark.parametrize(("row", "complete", "words"), [
    (MOVING, True, ["Still moving at 45 s: 98 % of the snow is faster than 1 m/s (at rest: 2 %), the momentum is 70 %"
                     " of its peak (at rest: 5 %)."]),
    (REST, False, ["The run is not complete: it stands at 45 s of 60 s."]),
    ({**REST, "removed_mass": 12.0}, True, ["12 % of the mass left the model, over an open side or the edge of the"
                                            " terrain."]),
    ({}, True, ["Whether the snow is at rest is not known: an older version wrote the file."]),
    ({"moving_share": 0.01, "momentum_share": 0.2}, True, [
        "Still moving at 45 s: 1 % of the snow is faster than 1 m/s (at rest: 2 %), the momentum is 20 % of its peak"
        " (at rest: 5 %)."]),
    ({**MOVING, "removed_mass": 50.0}, False, ["not complete", "Still moving", "50 % of the mass"]),
])
def test_what_is_not_final_says_why(tmp_path, row, complete, words):
    run = write(tmp_path, {0.0: {"removed_mass": 0.0}, 45.0: row}, complete)
    status = status_of(run)
    assert not status.final and status.text.startswith("NOT FINAL: ") and status.so_far == " so far"
    assert len(status.warnings) == len(words)
    assert all(part in found for part, found in zip(words, status.warnings, strict=True))
    assert list(remarks(run)) == cautions(run) == status.warnings
    assert status.record()["final"] is False and status.record()["status"] == status.text


def test_what_a_saw_took_has_not_left(tmp_path):
    row = {**REST, "removed_mass": 12.0, "taken_mass": 12.0}
    assert status_of(write(tmp_path, {0.0: REST, 45.0: row})).final


def test_motion_is_no_warning_where_there_is_no_run_out(tmp_path):
    run = write(tmp_path, {0.0: REST, 45.0: MOVING}, hazard=False)
    assert not status_of(run).final and cautions(run) == []


def test_a_run_without_frames_can_be_asked(tmp_path):
    with RunWriter(tmp_path, provenance={}) as writer:
        writer.close(complete=False)
    assert status_of(Run(tmp_path)).complete is False
    assert Status(True, 1.0, 1.0, 0.0, 0.0).final


def test_the_state_at_the_close_counts_before_the_last_row(tmp_path):
    """Snow that has left is counted when particles are sorted, which may be after the last row; while a resumed run
    goes on, its rows count again."""
    end = {"time": 45.5, "moving_share": 0.5, "momentum_share": 0.4, "left_share": 0.2}
    run = write(tmp_path, {0.0: REST, 45.0: REST})
    assert status_of(run).final
    with RunWriter.reopen(tmp_path) as writer:
        writer.provenance({"end_state": end})
    status = status_of(Run(tmp_path))
    assert (status.time, status.moving_share, status.left_share) == (45.5, 0.5, 0.2) and not status.final
    with RunWriter.reopen(tmp_path) as writer:
        writer.provenance({"end_state": {}})
    assert status_of(Run(tmp_path)).final
