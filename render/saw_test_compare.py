"""Saw tests over each other: the crack in time, its speed, the energy it takes, the slab's settlement, the numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.io import Run
from snowmpm.io.saw_theories import THEORIES, compared
from snowmpm.io.saw_words import SPREADS, in_short
from snowmpm.render.figure import DASHES, INK, check_ending, plain, save, titled
from snowmpm.render.history_plot import LEGEND, colour_of
from snowmpm.render.saw_test_plot import USUAL, local_speed

ENERGIES = {"plastic_work": "plastic work", "kinetic_energy": "kinetic", "elastic_energy": "elastic"}
NUMBERS = {"critical_length": ("critical length", "m", 1.0), "crack_speed": ("crack speed", "m/s", 1.0),
           "collapse_height": ("collapse height", "mm", 1e3), "fracture_energy": ("fracture energy", "J/m²", 1.0)}


@dataclass(frozen=True)
class ComparedSawTest:
    """label; run: `snowmpm.io.Run`; theories: {name: value} beside those of its summary."""

    label: str
    run: Run
    theories: dict[str, float]

    @property
    def found(self) -> dict[str, Any]:
        """What was measured, and under "theory" what all theories say."""
        found = self.run.summary.get("saw_test", {})
        return {**found, "theory": {**found.get("theory", {}), **self.theories}}


def render_saw_tests(tests: Sequence[ComparedSawTest], output: PathLike, *, dpi: float = 130) -> Path:
    """Draw `ComparedSawTest`s over each other to a PNG, PDF or SVG. Raises InputError for another
    ending."""
    check_ending(output)
    return save(saw_tests_figure(tests, dpi), output, dpi)


def saw_tests_figure(tests, dpi=130):
    """`ComparedSawTest`s as a Matplotlib figure."""
    figure = Figure(figsize=(16.5, 8.2), dpi=dpi, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.1, h_pad=0.1, wspace=0.03, hspace=0.03)
    figure.suptitle(" and ".join(dict.fromkeys(test.run.name.replace("_", " ") for test in tests)), fontsize=13,
                    fontweight="bold", color=INK)
    for axes, draw in zip(figure.subplots(2, 3).ravel(), (_way, _speed, _numbers, _settlement, _work, _energies),
                          strict=True):
        plain(axes)
        draw(axes, tests)
    return figure


def _way(axes, tests):
    for i, test in enumerate(tests):
        saw = test.run.saw_test
        axes.plot(saw["time"], saw["tip"], color=colour_of(i), lw=1.8, label=f"{test.label}: crack")
        axes.plot(saw["time"], saw["saw"], color=colour_of(i), lw=1.0, ls=":",
                  label=f"saw, {saw.about['saw_speed']:g} m/s")
    axes.legend(**LEGEND)
    titled(axes, "tip of the crack, and the saw", "time  [s]", "along the column  [m]")


def _speed(axes, tests):
    top = 1.0
    for i, test in enumerate(tests):
        saw, found = test.run.saw_test, test.found
        own = np.isfinite(saw["arrival"]) & (saw["x"] > (found.get("critical_length") or 0.0))
        x, speed = local_speed(saw["x"][own], saw["arrival"][own], 2.0 * saw.about["slab_thickness"])
        axes.plot(x, speed, color=colour_of(i), lw=1.8, label=test.label)
        wave = found["theory"].get("collapse_wave_speed")
        if wave and any(one.theory.measured == "crack_speed" for one in compared(found, saw.about["slope_angle"])):
            axes.axhline(wave, color=colour_of(i), lw=1.0, ls="--", label=f"collapse wave: {wave:.0f} m/s")
            top = max(top, wave)
        if len(speed):
            top = max(top, float(np.percentile(speed, USUAL)))
    axes.set_ylim(0.0, 1.4 * top)
    axes.legend(loc="upper left", **LEGEND)
    titled(axes, "speed over two slab thicknesses", "crack length  [m]", "[m/s]")


def _numbers(axes, tests):
    """A row a number, all runs and their theories over the largest measured value."""
    labels = []
    for k, (name, (words, unit, scale)) in enumerate(NUMBERS.items()):
        values = [test.found.get(name) for test in tests]
        largest = max((value for value in values if value), default=None)
        labels.append(words)
        if largest is None:
            words = ", ".join(dict.fromkeys(in_short(test.found, name) for test in tests))
            axes.text(0.02, k, words, fontsize=8, va="center")
            continue
        for i, (test, value) in enumerate(zip(tests, values, strict=True)):
            y = k + 0.7 * ((i + 0.5) / len(tests) - 0.5)
            if value:
                near = test.found.get(SPREADS.get(name))
                axes.barh(y, value / largest, height=0.6 / len(tests), color=colour_of(i),
                          xerr=near / largest if near else None, error_kw={"lw": 1.2, "ecolor": INK, "capsize": 3})
                axes.text(0.01, y, f"{scale * value:.3g} {unit}", fontsize=8, va="center", color="white",
                          fontweight="bold")
            for one in compared(test.found, test.run.saw_test.about["slope_angle"]):
                if one.theory.measured == name:
                    axes.plot(min(one.predicted / largest, 1.9), y, marker=_marker(one.theory), ls="", ms=6,
                              color=INK, mfc="white")
    for theory in THEORIES:
        axes.plot([], [], marker=_marker(theory), ls="", color=INK, mfc="white", label=theory.label)
    axes.set_yticks(range(len(labels)), labels)
    axes.set_ylim(len(labels) + 1.2, -0.6)
    axes.set_xlim(0.0, 2.0)
    axes.legend(loc="lower right", **{**LEGEND, "fontsize": 7})
    titled(axes, "measured (bars), theories (signs; at 1.9: 1.9 and more)", "over the largest measured", "")


def _marker(theory):
    return "odsv^"[THEORIES.index(theory)]


def _settlement(axes, tests):
    for i, test in enumerate(tests):
        saw = test.run.saw_test
        axes.plot(saw["x"], -1e3 * saw["settlement"][-1], color=colour_of(i), lw=1.8,
                  label=f"{test.label}, {saw['time'][-1]:.3g} s")
    axes.legend(**LEGEND)
    titled(axes, "deflection of the slab at the end", "along the column  [m]", "normal to the slope  [mm]")


def _work(axes, tests):
    for i, test in enumerate(tests):
        saw = test.run.saw_test
        axes.plot(saw["x"], saw["fracture_energy"], color=colour_of(i), lw=1.8, label=test.label)
        energy = test.found["theory"].get("fracture_energy")
        if energy:
            axes.axhline(energy, color=colour_of(i), lw=1.0, ls="--", label=f"work of collapse: {energy:.2f} J/m²")
    axes.set_ylim(bottom=0.0)
    axes.legend(**LEGEND)
    titled(axes, "energy until the strength was gone", "along the column  [m]", "[J/m²]")


def _energies(axes, tests):
    width = "/m" if tests[0].run.dimension == 2 else ""
    for i, test in enumerate(tests):
        history = test.run.history
        for name, dashes in zip(ENERGIES, DASHES, strict=False):
            if name in history:
                axes.plot(history["time"], history[name], color=colour_of(i), lw=1.5, ls=dashes,
                          label=ENERGIES[name] if i == 0 else None)
    axes.legend(**LEGEND)
    titled(axes, "energy", "time  [s]", f"[J{width}]")
