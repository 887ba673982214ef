"""One Taichi for the whole test session; kernels are compiled once and shared."""

import os
from collections import Counter
from typing import NamedTuple

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from snowmpm.cli import watch
from snowmpm.cli.app import app
from snowmpm.compiler import runtime
from tests.support.expected_failures import pytest_runtest_makereport  # noqa: F401  a hook

TOGETHER = {
    "campaigns": ("tests/campaigns/",),
    "depth": ("tests/depth/", "tests/verification/test_depth_"),
    "materials": ("tests/materials/",),
    "mpm": ("tests/mpm/", "tests/verification/test_free_flight", "tests/verification/test_periodic_waves",
            "tests/verification/test_waves"),
    "sph": ("tests/sph/", "tests/verification/test_sph_"),
    "structures": ("tests/components/structures/", "tests/components/precice/"),
}
"""Tests that one worker runs, since they share compiled kernels or a cluster; of all others, those of a file."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Of pytest-xdist: which worker runs which tests."""
    from xdist.scheduler import LoadScopeScheduling

    class Together(LoadScopeScheduling):
        def _split_scope(self, nodeid):
            file = nodeid.split("::")[0]
            return next((name for name, begins in TOGETHER.items() if file.startswith(begins)), file)

    return Together(config, log)


@pytest.fixture(scope="session", autouse=True)
def taichi():
    """Start Taichi on the CPU once; every test shares its kernels, and later sessions find them on the disk."""
    runtime.start("cpu")
    yield
    runtime.keep_kernels()  # a process of pytest-xdist does not end as others do


@pytest.fixture(scope="session", autouse=True)
def compiled_modules(tmp_path_factory):
    """Where Python is told to leave nothing beside the sources, commands in processes of their own share a folder for
    what it compiles: it takes each of them half a second."""
    with pytest.MonkeyPatch.context() as patch:
        if os.environ.get("PYTHONDONTWRITEBYTECODE"):
            patch.delenv("PYTHONDONTWRITEBYTECODE")
            patch.setenv("PYTHONPYCACHEPREFIX", str(tmp_path_factory.mktemp("compiled")))
        yield


DPI = 50.0
"""Dots per inch of the tests' figures: half of the time of the usual 130 to 150."""


@pytest.fixture(scope="session", autouse=True)
def small_figures():
    """Figures of Matplotlib with few dots, which take less time to draw and to compress; `full_figures` undoes it."""
    draw = FigureCanvasAgg.print_figure

    def coarse(canvas, output, dpi=DPI, **options):
        return draw(canvas, output, dpi=min(dpi, DPI), **options)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FigureCanvasAgg, "print_figure", coarse)
        yield draw


@pytest.fixture
def full_figures(small_figures, monkeypatch):
    """Figures with as many dots as a user gets."""
    monkeypatch.setattr(FigureCanvasAgg, "print_figure", small_figures)


@pytest.fixture(scope="session", autouse=True)
def no_lines_of_progress():
    """A busy machine takes its time: what stderr must say would stand between lines of progress."""
    usual, watch.LINE_INTERVAL = watch.LINE_INTERVAL, 1e9
    yield
    watch.LINE_INTERVAL = usual


def pytest_terminal_summary(terminalreporter):
    """What was not validated, counted by reason."""
    skipped = terminalreporter.stats.get("skipped", ())
    reasons = Counter(report.longrepr[2].removeprefix("Skipped: ") for report in skipped
                      if isinstance(report.longrepr, tuple))
    if reasons:
        counts = "; ".join(f"{count} {reason}" for reason, count in reasons.most_common())
        terminalreporter.write_line(f"skipped validation: {sum(reasons.values())} tests: {counts}")


class Result(NamedTuple):
    """Of a command."""

    code: int
    out: str
    err: str


@pytest.fixture
def call(capsys, tmp_path, monkeypatch):
    """call("run", "scene.toml") -> Result, in an empty folder of its own and in this process: a subprocess costs a
    second each."""
    monkeypatch.chdir(tmp_path)

    def invoke(*arguments):
        capsys.readouterr()
        try:
            app([str(argument) for argument in arguments])
            code = 0
        except SystemExit as end:
            code = end.code or 0
        output = capsys.readouterr()
        return Result(code, output.out, output.err)

    return invoke
