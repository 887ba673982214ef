"""Pictures and films of runs. Reads run files only: needs neither Taichi nor a solver, a display or a graphics card."""

if __name__ != "snowmpm.render":
    raise ImportError("import this package as snowmpm.render")

import importlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # they take time to import, and a command needs few of them
    from snowmpm.io import Run
    from snowmpm.render.compare_plot import ComparedRun, Comparison, render_comparison
    from snowmpm.render.compression_plot import render_compression
    from snowmpm.render.element_plot import ElementCurves, render_element
    from snowmpm.render.history_plot import render_history
    from snowmpm.render.line_plot import render_line
    from snowmpm.render.map_film import render_map_film
    from snowmpm.render.pair import render_pair
    from snowmpm.render.panel_plot import render_panels
    from snowmpm.render.peak_map import render_before_after, render_map
    from snowmpm.render.report import render_report
    from snowmpm.render.run_film import render_run
    from snowmpm.render.saw_test_compare import ComparedSawTest, render_saw_tests
    from snowmpm.render.saw_test_plot import render_saw_test
    from snowmpm.render.stills import render_stills
    from snowmpm.render.strength_plot import SlipPicture, StrengthCurve, render_strength
    from snowmpm.render.strip import notes_of, render_strip
    from snowmpm.render.thalweg_plot import render_thalweg
    from snowmpm.render.thalweg_time_plot import render_thalweg_time
    from snowmpm.render.viewer import render_page

_HOMES = {
    "ComparedRun": "compare_plot",
    "Comparison": "compare_plot",
    "render_comparison": "compare_plot",
    "render_compression": "compression_plot",
    "ElementCurves": "element_plot",
    "render_element": "element_plot",
    "render_history": "history_plot",
    "render_line": "line_plot",
    "render_before_after": "peak_map",
    "render_map_film": "map_film",
    "render_pair": "pair",
    "render_map": "peak_map",
    "render_panels": "panel_plot",
    "render_report": "report",
    "render_run": "run_film",
    "ComparedSawTest": "saw_test_compare",
    "render_saw_tests": "saw_test_compare",
    "render_saw_test": "saw_test_plot",
    "render_stills": "stills",
    "SlipPicture": "strength_plot",
    "StrengthCurve": "strength_plot",
    "render_strength": "strength_plot",
    "notes_of": "strip",
    "render_strip": "strip",
    "render_thalweg": "thalweg_plot",
    "render_thalweg_time": "thalweg_time_plot",
    "render_page": "viewer",
}
_PLOTS = {"history": "render_history", "compression": "render_compression", "saw_test": "render_saw_test",
          "thalweg_time": "render_thalweg_time"}

PLOTS: "dict[str, Callable[[Run, Path], Path]]"
"""Functions (run, file) that draw curves of a run, by the name that a scene's picture gives them."""

__all__ = ["PLOTS", "ComparedRun", "ComparedSawTest", "Comparison", "ElementCurves", "SlipPicture", "StrengthCurve",
           "notes_of", "render_before_after", "render_comparison", "render_compression", "render_element",
           "render_history", "render_line", "render_map", "render_map_film", "render_page", "render_pair",
           "render_panels", "render_report", "render_run", "render_saw_test", "render_saw_tests", "render_stills",
           "render_strength", "render_strip", "render_thalweg", "render_thalweg_time"]


def __getattr__(name: str) -> Any:
    if name == "PLOTS":
        return {key: __getattr__(function) for key, function in _PLOTS.items()}
    if name in _HOMES:
        return vars(importlib.import_module(f"snowmpm.render.{_HOMES[name]}"))[name]
    raise AttributeError(f"module 'snowmpm.render' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
