"""The plot of an element test: stress path with the yield surface, stress, volume and hardening against strain."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from snowmpm.annotations import Numbers, PathLike
from snowmpm.render.figure import check_ending, plain, prefixed, save

PATH, SECOND, SURFACE, MARK = "#1d4f91", "#d9642a", "#8a949e", "#11161c"
SAME = 1e-3  # of the plane of p and q: surfaces that differ by less, as by the change of J alone, are drawn as one
FLAT = 1e-6  # of the largest stress: a smaller q is round-off


@dataclass(frozen=True)
class ElementCurves:
    """What is drawn, all arrays (n,) with one entry for the start and one a step.

    strain: the driven one; p, q [Pa]; volumetric and plastic (or None) logarithmic volume changes, expansion positive;
    hardening: name, unit and values of what describes the state, or None; yield_row, peak_row: rows to mark, or None;
    section: name of the surface, p (m,), q (k,) [Pa], its functions (k, m) at the start and at the end; or None.
    """

    title: str
    strain_label: str
    strain: Numbers
    p: Numbers
    q: Numbers
    volumetric: Numbers
    plastic: Numbers | None = None
    hardening: tuple[str, str, Numbers] | None = None
    yield_row: int | None = None
    peak_row: int | None = None
    section: tuple[str, Numbers, Numbers, Numbers, Numbers] | None = None


def render_element(curves: ElementCurves, output: PathLike, *, dpi: float = 130) -> Path:
    """Draw `ElementCurves` to a PNG, PDF or SVG. Returns the path written. Raises InputError for another ending."""
    check_ending(output)
    return save(element_figure(curves, dpi), output, dpi)


def element_figure(curves, dpi=130):
    """`ElementCurves` as a Matplotlib figure: stress path, stress, volume, state."""
    figure = Figure(figsize=(10.5, 8.0), dpi=dpi, layout="constrained")
    figure.get_layout_engine().set(w_pad=0.12, h_pad=0.12, wspace=0.03, hspace=0.03)
    figure.suptitle(curves.title, fontsize=13, fontweight="bold", color=MARK)
    path, stress, volume, state = figure.subplots(2, 2).ravel()
    _draw_path(path, curves)
    _draw_stress(stress, curves)
    _draw_volume(volume, curves)
    _draw_state(state, curves)
    for axes in (path, stress, volume, state):
        plain(axes)
    # One for the marks of every panel, where it covers no curve
    figure.legend(*path.get_legend_handles_labels(), loc="outside lower center", ncols=8, frameon=False, fontsize=9)
    return figure


def _draw_path(axes, curves):
    """Path in the plane of p and q, over the yield surface as it was and as it became."""
    scale, unit = prefixed(curves.p, curves.q)
    if curves.section is not None:
        surface, p, q, initial, final = curves.section
        same = np.mean((initial > 0.0) != (final > 0.0)) < SAME
        drawn = [(final, surface, "-", 1.6)]
        if not same:
            drawn = [(initial, f"initial {surface}", "--", 1.2), (final, f"final {surface}", "-", 1.6)]
        for function, name, style, width in drawn:
            # A cohesionless surface that has shrunk to a point, or no surface at all, has no line
            if np.nanmin(function) <= 0.0 < np.nanmax(function) and np.isfinite(function).any():
                finite = np.where(np.isfinite(function), function, np.nan)
                options = {"colors": SURFACE, "linestyles": style, "linewidths": width}
                axes.contour(p / scale, q / scale, finite, levels=[0.0], **options)
                axes.plot([], [], color=SURFACE, ls=style, lw=width, label=name)
    axes.plot(curves.p / scale, curves.q / scale, color=PATH, lw=2.0, label="path", zorder=3)
    _mark(axes, curves, curves.p / scale, curves.q / scale, legend=True)
    axes.axvline(0.0, color="0.75", lw=0.8, zorder=0)
    top = axes.get_ylim()[1]
    axes.set_ylim(-0.03 * top, top)  # marks on the axis p are shown whole
    axes.set_title("stress path (Cauchy)", loc="left", fontsize=10)
    axes.set_xlabel(f"p  [{unit}]")
    axes.set_ylabel(f"q  [{unit}]")


def _draw_stress(axes, curves):
    scale, unit = prefixed(curves.p, curves.q)
    sheared = curves.q.max() > FLAT * max(np.abs(curves.p).max(), 1e-300)
    if sheared:
        axes.plot(curves.strain, curves.q / scale, color=PATH, lw=2.0, label="q")
    axes.plot(curves.strain, curves.p / scale, color=SECOND, lw=1.6, label="p")
    _mark(axes, curves, curves.strain, (curves.q if sheared else curves.p) / scale)
    axes.set_title("stress (Cauchy)", loc="left", fontsize=10)
    axes.set_xlabel(curves.strain_label)
    axes.set_ylabel(f"{'p, q' if sheared else 'p'}  [{unit}]")
    axes.legend(frameon=False, fontsize=9)


def _draw_volume(axes, curves):
    axes.plot(curves.strain, curves.volumetric, color=PATH, lw=2.0, label="total")
    if curves.plastic is not None:
        axes.plot(curves.strain, curves.plastic, color=SECOND, lw=1.6, label="plastic")
        axes.legend(frameon=False, fontsize=9)
    _widen(axes, curves.volumetric, curves.plastic)
    axes.set_title("volume", loc="left", fontsize=10)
    axes.set_xlabel(curves.strain_label)
    axes.set_ylabel("ln J, expansion positive  [-]")


def _draw_state(axes, curves):
    name, unit, values = curves.hardening or ("dissipation", "J/m³", np.zeros_like(curves.strain))
    scale, unit = prefixed(values, unit=unit) if unit in ("Pa", "J/m3") else (1.0, unit)
    axes.plot(curves.strain, values / scale, color=PATH, lw=2.0)
    _widen(axes, values / scale)
    axes.set_title("state", loc="left", fontsize=10)
    axes.set_xlabel(curves.strain_label)
    axes.set_ylabel(f"{name.replace('_', ' ')}  [{unit.replace('m3', 'm³')}]")


def _mark(axes, curves, x, y, legend=False):
    """Start, yield, peak (where it is neither yield nor the end) and end."""
    points = [(0, "o", "white", "start"), (len(x) - 1, "s", MARK, "end")]
    if curves.yield_row is not None:
        points.append((curves.yield_row, "D", SECOND, "yield"))
    if curves.peak_row is not None and curves.peak_row not in (curves.yield_row, len(x) - 1):
        points.append((curves.peak_row, "^", "white", "peak"))
    for row, marker, face, label in points:
        style = {"mfc": face, "mec": MARK, "ms": 6, "mew": 1.1, "zorder": 4, "ls": "none"}
        axes.plot(x[row], y[row], marker, label=label if legend else None, **style)


def _widen(axes, *values):
    """Keep round-off from being drawn as a zigzag that fills the panel."""
    everything = np.concatenate([np.atleast_1d(v) for v in values if v is not None])
    low, high = everything.min(), everything.max()
    least = max(1e-6 * max(abs(low), abs(high)), 1e-9)
    if high - low < least:
        middle = 0.5 * (low + high)
        span = max(0.05 * abs(middle), 1e-3)
        axes.set_ylim(middle - span, middle + span)
