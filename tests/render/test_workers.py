"""Pictures drawn side by side: their order, how far ahead, errors, and the same film as by one thread."""

import ast
import threading
import time
import tracemalloc
from pathlib import Path

import pytest
from synthetic_runs import slab_2d, slab_3d

from snowmpm import render
from snowmpm.io import Run
from snowmpm.render import render_run, run_film, workers
from snowmpm.render.workers import drawn, worker_count


class Desk:
    """Draws numbers; the even ones take longer."""

    def __init__(self, fails_at=None):
        self.begun, self.at_once, self.most, self.fails_at = [], 0, 0, fails_at
        self._lock = threading.Lock()

    def draw(self, i):
        with self._lock:
            self.begun.append(i)
            self.at_once += 1
            self.most = max(self.most, self.at_once)
        time.sleep(0.02 if i % 2 == 0 else 0.002)
        with self._lock:
            self.at_once -= 1
        if i == self.fails_at:
            raise ValueError(i)
        return 10 * i


def test_pictures_come_in_order_whoever_is_first():
    desk = Desk()
    assert list(drawn(desk.draw, range(9), 3)) == [10 * i for i in range(9)]
    assert 1 < desk.most <= 3


def test_no_more_is_drawn_ahead_than_said():
    desk, taken = Desk(), 0
    for _ in drawn(desk.draw, range(12), 2):
        taken += 1
        time.sleep(0.03)
        assert len(desk.begun) <= taken + 2 + 2
    assert taken == 12


def test_an_error_comes_after_what_was_drawn_before_it():
    desk, good = Desk(fails_at=4), []
    with pytest.raises(ValueError, match="4"):
        for picture in drawn(desk.draw, range(50), 3):
            good.append(picture)
    assert good == [0, 10, 20, 30] and max(desk.begun) < 12


def test_who_stops_early_leaves_nobody_drawing():
    desk = Desk()
    pictures = drawn(desk.draw, range(50), 3)
    assert next(pictures) == 0
    pictures.close()
    assert desk.at_once == 0 and max(desk.begun) < 12


@pytest.mark.parametrize(("free", "cores", "pictures", "wanted"), [(1e12, 4, 100, 4), (1e12, 64, 100, workers.MOST),
                                                                  (1e12, 4, 3, 3), (1e12, 4, 1, 1), (0.0, 4, 100, 1),
                                                                  (6.0, 4, 100, 3)])
def test_as_many_threads_as_cores_memory_and_pictures_allow(monkeypatch, free, cores, pictures, wanted):
    """free: in pictures of this size and so many particles, where below 1e3."""
    each = workers.PER_PARTICLE * 10_000 + workers.PER_PIXEL * 640 * 360
    monkeypatch.setattr(workers.memory, "available", lambda: free * each + 1.0)
    monkeypatch.setattr(workers, "available_cores", lambda: cores)
    assert worker_count((640, 360), 10_000, pictures) == wanted


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Made-up runs in two and three dimensions."""
    folder = tmp_path_factory.mktemp("runs")
    slab_2d(folder / "2", frames=6)
    slab_3d(folder / "3", frames=6, particles=1500)
    return folder


@pytest.mark.parametrize(("dimension", "camera"), [(2, "auto"), (3, "150,40")])
def test_pictures_are_the_same_by_one_thread_and_by_three(runs, tmp_path, monkeypatch, dimension, camera):
    films = []
    for threads in (1, 3):
        monkeypatch.setattr(run_film, "worker_count", lambda *_, count=threads: count)
        folder = tmp_path / f"by_{threads}"
        render_run(Run(runs / f"{dimension}"), folder, size=(240, 136), camera=camera)
        films.append({file.name: file.read_bytes() for file in folder.iterdir()})
    assert films[0] == films[1] and len(films[0]) == 6 and len(set(films[0].values())) == 6


def test_a_picture_takes_no_more_memory_than_it_is_counted_as(runs):
    """So that as many threads as memory is said to allow do not run out of it."""
    view = run_film.view_of(Run(runs / "3"), (320, 180), camera="150,40")
    view.picture(0)
    tracemalloc.start()
    view.picture(3)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    counted = workers.PER_PARTICLE * view.most_points + workers.PER_PIXEL * 320 * 180
    assert 0.1 * counted < peak < counted


DRAWING = ("camera", "crumble", "fracture", "ground", "light", "section", "section_view", "shadow", "sheet", "snow",
           "solid", "space_view", "splat", "upright", "winter")
"""Modules that the pictures of a film go through."""
PREPARING = {"crumble": 3, "fracture": 2, "light": 2, "upright": 2}
"""Products of a few numbers in them, or of whole numbers, neither of which BLAS shares among threads."""


@pytest.mark.parametrize("name", DRAWING)
def test_pictures_keep_off_blas(name):
    """Its threads waited for each other without end while two pictures were drawn: no matrix product of arrays."""
    tree = ast.parse((Path(render.__file__).parent / f"{name}.py").read_text(encoding="utf-8"))
    products = sum(isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult) for node in ast.walk(tree))
    calls = sum(isinstance(node, ast.Attribute) and node.attr in ("dot", "matmul", "tensordot")
                for node in ast.walk(tree))
    assert (products, calls) == (PREPARING.get(name, 0), 0)
