"""What flowed past the gauges of a run: a row of panels each, over time."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from snowmpm.annotations import PathLike
from snowmpm.errors import shown_line
from snowmpm.io import Run
from snowmpm.io.gauges import Gauge
from snowmpm.io.status import status_of
from snowmpm.quantities.table import quantity
from snowmpm.render.figure import check_ending, plain, prefixed, save

MOST = 12
"""Gauges of a picture; the table has all."""
DEPTH, SPEED, FLOW, VOLUME, LATE = "#3f8fc8", "#1d4f91", "#d9642a", "#11161c", "#c1121f"


def render_gauges(run: Run, gauges: Sequence[Gauge], output: PathLike, *, dpi: float = 130) -> Path:
    """Draw depth and speed, and discharge and volume across lines or pressure at points, over time to a PNG, PDF or
    SVG; -> the path. Raises InputError for another ending."""
    check_ending(output)
    shown = gauges[:MOST]
    figure = Figure(figsize=(10.0, 2.3 * len(shown) + 0.7), dpi=dpi, layout="constrained")
    status = status_of(run)
    title = f"{run.title.replace('_', ' ')}: gauges" + ("" if status.final else " (NOT FINAL)")
    if len(gauges) > len(shown):
        title += f", the first {len(shown)} of {len(gauges)}"
    figure.suptitle(title, fontsize=13, fontweight="bold", color="#11161c" if status.final else LATE)
    rows = figure.subplots(len(shown), 2, sharex=True, squeeze=False)
    for (left, right), gauge in zip(rows, shown, strict=True):
        time = gauge.series["time"]
        for axes in (left, right):
            plain(axes)
        left.set_title(shown_line(gauge.place.name, 60), loc="left", fontsize=10)
        _pair(left, time, (gauge.series["depth"], "depth  [m]", DEPTH), (gauge.series["speed"], "speed  [m/s]", SPEED))
        if gauge.place.is_line:
            right.set_title(_volume(gauge), loc="left", fontsize=10)
            _pair(right, time, (gauge.series["discharge"], "discharge  [m³/s]", FLOW),
                  (gauge.series["volume"], "volume passed  [m³]", VOLUME))
        else:
            factor, unit = prefixed(gauge.series["pressure"])
            right.plot(time, gauge.series["pressure"] / factor, color=FLOW, lw=1.4)
            right.set_ylabel(f"pressure ρv²  [{unit}]", color=FLOW)
    for axes in rows[-1]:
        axes.set_xlabel("time  [s]")
    return save(figure, output, dpi)


def _volume(gauge):
    if gauge.numbers["gauge_arrival"] is None:
        return "the flow did not come here"
    return f"{quantity('gauge_volume').text(gauge.numbers['gauge_volume'])} passed"


def _pair(axes, time, first, second):
    """Two curves over time, each with an axis of its own."""
    for one, (values, label, colour) in ((axes, first), (axes.twinx(), second)):
        one.plot(time, values, color=colour, lw=1.4)
        one.set_ylabel(label, color=colour)
        one.spines["top"].set_visible(False)
        one.tick_params(labelsize=9, color="0.5")
        least, most = min(0.0, float(values.min())), float(values.max())
        one.set_ylim(bottom=1.05 * least, top=max(1.05 * most, least + 1e-3))
