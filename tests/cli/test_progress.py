"""The live display: what it says of a run that goes on."""

import io
import json
import sys
from types import SimpleNamespace

import pytest
from rich.console import Console

from snowmpm.cli import watch
from snowmpm.cli.progress import Json, Lines, Pace, Screen, display
from snowmpm.cli.wording import step
from snowmpm.stages import stage


def state(time, wall, potential):
    audit = {"kinetic_energy": 2500.0, "elastic_energy": 40.0, "plastic_work": 1.2e6, "contact_work": 0.0,
             "potential_energy": potential}
    return SimpleNamespace(time=time, end_time=10.0, dt=1.25e-4, dt_cause="advective", n_particles=123456,
                           max_speed=8.5, front=31.5, steps=1000, frames=21, wall=wall, particle_steps=wall * 5e6,
                           audit=audit)


@pytest.fixture
def screen():
    screen = Screen("slope")
    screen(state(1.0, 10.0, -1e6))
    screen(state(2.0, 20.0, -3e6))
    return screen


def drawn(screen, width=120):
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(screen)
    return console.export_text()


def test_screen_tells_all_that_a_person_waits_for(screen):
    text = drawn(screen)
    # 1 s of simulation in 10 s: 8 s more take 80 s
    for words in ("slope", "20%", "1 min 20 s left", "2.000 / 10 s", "123 456", "8.5 m/s", "31.5 m", "125 µs",
                  "fastest particle", "5 M particle-steps/s", "potential lost 2 MJ", "kinetic 2.5 kJ",
                  "plastic work 1.2 MJ", "elastic 40 J"):
        assert words in text, (words, text)


@pytest.mark.parametrize("width", [80, 100, 160])
def test_no_line_of_the_screen_is_folded_or_cut(screen, width):
    lines = drawn(screen, width).rstrip().split("\n")
    assert max(map(len, lines)) <= width
    text = "\n".join(" ".join(line.split()) for line in lines)
    for words in ("limited by fastest particle", "pace 5 M particle-steps/s", "potential lost 2 MJ",
                  "plastic work 1.2 MJ", "contact 0 J", "frames 21"):
        assert words in text, text


@pytest.mark.parametrize(("seconds", "words"), [(3.27e-3, "3.27 ms"), (1.25e-4, "125 µs"), (2.0, "2 s"),
                                                (9.9999e-4, "1 ms"), (4.3e-8, "43 ns")])
def test_steps_in_units_of_their_size(seconds, words):
    assert step(seconds) == words


def test_screen_before_the_first_step():
    assert "preparing" in drawn(Screen("slope"))


def test_pace_forgets_what_was_long_ago():
    pace = Pace()
    for wall, time in [(0.0, 0.0), (100.0, 1.0), (101.0, 2.0), (121.5, 22.5)]:
        pace.add(state(time, wall, 0.0))
    assert pace.time_left(state(5.0, 121.5, 0.0)) == pytest.approx(5.0)  # 1 s in 1 s, in the last 20 s


@pytest.mark.parametrize(("form", "quiet", "kind"), [
    ("auto", False, Lines), ("lines", False, Lines), ("json", False, Json), ("auto", True, type(None)),
    ("lines", True, type(None))])
def test_lines_where_there_is_no_terminal(capsys, form, quiet, kind):
    with watch.watched(form=form), display("slope", quiet) as shown:
        assert type(shown) is kind
    assert watch.form() == "auto"


def test_json_is_one_line_a_report_also_from_two_threads(monkeypatch):
    """Share, time and what is known; nothing where standard error is closed."""
    class Stream(io.StringIO):
        def write(self, text):
            assert text.endswith("\n")  # in one piece
            return super().write(text)

    stream = Stream()
    monkeypatch.setattr(sys, "stderr", stream)
    report = Json("slope")
    for wall in (0.0, 0.1, 0.6):  # the second comes too soon
        report(state(10.0 * wall, wall, 0.0))
    rows = [json.loads(line) for line in stream.getvalue().splitlines()]
    assert [row["share"] for row in rows] == [0.0, 0.6] and [row["time"] for row in rows] == [0.0, 6.0]
    assert all(value is not None for row in rows for value in row.values())
    monkeypatch.setattr(sys, "stderr", None)
    watch.print_json("nobody reads it")
    with watch.watched(form="json"), display("slope") as shown:
        assert shown is None


def test_lines_elsewhere_begin_late_and_say_nothing_of_a_short_run(monkeypatch):
    monkeypatch.setattr(watch, "LINE_INTERVAL", 10.0)
    short, long = io.StringIO(), io.StringIO()
    for file, end in ((short, 9.0), (long, 31.0)):
        lines = Lines("slope", file, late=True)
        for wall in (0.5, 4.0, 9.0, 12.0, 15.0, 24.0, 31.0):
            if wall <= end:
                lines(state(10.0 * wall / end, wall, 0.0))
    assert short.getvalue() == ""
    told = long.getvalue().splitlines()
    assert [line.split(" of ")[0] for line in told] == ["slope: 3.871", "slope: 7.742", "slope: 10.000"]
    assert "19 s left" in told[0]


def test_screen_names_the_stage_before_the_first_step():
    with stage("settling to rest", unit="steps") as now:
        now.done, now.detail = 3000, "speed 2.1 of what is allowed"
        assert "slope: settling to rest: 3 000 steps" in drawn(Screen("slope"))
