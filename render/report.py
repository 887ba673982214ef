"""A run as one page to keep and to send: settings, pictures, curves, audit, warnings, how to make it again."""

import json
import math
import tempfile
from pathlib import Path
from shlex import quote

import numpy as np
from PIL import Image

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.impact import impacts, loaded
from snowmpm.io.panels import has_panels
from snowmpm.io.parameters import method_of, parameters, pieces, succession
from snowmpm.io.projection import projection_name
from snowmpm.io.published import resolution_of, statement
from snowmpm.io.remarks import remarks
from snowmpm.io.status import status_of
from snowmpm.quantities.quantity import written
from snowmpm.quantities.resolution import rounded
from snowmpm.quantities.table import IMPACT, quantity
from snowmpm.render import page
from snowmpm.render.document import (
    Columns,
    Definitions,
    Document,
    Listing,
    Live,
    Note,
    Numbers,
    Paragraph,
    Picture,
    Section,
    Table,
)
from snowmpm.render.fracture import NAME as FRACTURE
from snowmpm.render.fracture import WeakLayer
from snowmpm.render.history_plot import render_history
from snowmpm.render.panel_plot import render_panels
from snowmpm.render.peak_map import MapSheet
from snowmpm.render.report_pdf import write_pdf
from snowmpm.render.run_film import nearest_frame, view_of
from snowmpm.render.saw_test_plot import render_saw_test
from snowmpm.render.thalweg_plot import render_thalweg
from snowmpm.render.thalweg_time_plot import render_thalweg_time
from snowmpm.render.viewer import SCRIPTS, viewer
from snowmpm.render.workers import drawn, worker_count
from snowmpm.stages import stage

SIZE = (1280, 620)
MOMENTS = 4
FILM = 24 << 20  # bytes: a larger film is named, not put in
ENDINGS = (".html", ".pdf")


def render_report(run_path: PathLike | Run, output: PathLike, *, interactive: bool = True,
                  size: tuple[int, int] = SIZE) -> Path:
    """Write the report of a run to an .html file that holds all it shows, or to a .pdf; -> its path.

    interactive: with the scene to turn in three dimensions, some megabytes, on a page; size: of its pictures [px].
    Raises InputError for a run without frames, or another ending.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    kind = Path(output).suffix.lower()
    if kind not in ENDINGS:
        raise InputError.at("output", str(output), "must end in .html or .pdf")
    view = view_of(run, size)
    with tempfile.TemporaryDirectory() as folder, stage("writing the report", 5, "parts with pictures") as now:
        document = _document(run, view, Path(folder), interactive and kind == ".html", now)
        return write_pdf(document, output) if kind == ".pdf" else page.write_page(output, page.page_of(document))


def _document(run, view, folder, interactive, now):
    """The report of a `Run`, its pictures drawn to `folder`; now: the `Stage` that counts the parts with pictures."""
    def part(title, make):
        section = Section(title, list(make()))
        now.done += 1
        return section

    sheet = MapSheet(run)
    return Document(run.title.replace("_", " "), _lead(run), [
        part("", lambda: [Numbers(_key_numbers(run)), *_first_map(run, sheet, folder), *_warnings(run)]),
        part("Pictures", lambda: [*_pictures(run, view, folder), *_film(run)]),
        part("To turn and move through", lambda: _turning(run, view, interactive)),
        part("Curves", lambda: _curves(run, folder)),
        part("Maps", lambda: _maps(run, sheet, folder)),
        Section("Numbers of hazard mapping", list(_hazard(run))),
        Section("Areas by class", list(_areas(run))),
        Section("Impact", list(_impacts(run))),
        Section("Audit at the end", [_table(_last_row(run), run.units, run.dimension)]),
        Section("What the numbers mean", [Definitions(_told(run))]),
        Section("Settings", [Listing(run.provenance.get("scene", "not known"), "the resolved scene")]),
        Section("How to make it again", list(_reproduction(run))),
    ], f"snowmpm {run.provenance.get('version', '')}: {run.path}", SCRIPTS if interactive else ())


def _lead(run):
    words = _in_short(run)
    return f"{words} {statement(run)}" if run.hazard else words


def _in_short(run):
    kind = "three dimensions" if run.dimension == 3 else "plane strain"
    method = method_of(run)
    kind = method.title if method and method.capabilities.plan else f"in {kind}"
    then = f" {succession(run)}." if succession(run) else ""
    dx = run.provenance.get("dx", math.nan)
    of = " with snow at the start, of" if pieces(run) == "cells" else " on cells of"
    return (f"A simulation {kind} over {run.times[-1]:g} s, {len(run)} frames, with {_count(run.n_points(0))}"
            f" {pieces(run)}{of} {dx:g} m.{then}")


def _key_numbers(run):
    history, numbers, known = run.history, run.hazard.get("numbers", {}), resolution_of(run)
    found = {pieces(run): _count(run.n_points(0)), "simulated": f"{run.times[-1]:g} s"}
    so_far = status_of(run).so_far
    for name in ("runout", "travel_angle", "affected_area", "largest_flow_speed", "largest_flow_pressure",
                 "deposit_volume"):
        if name in numbers:
            found[quantity(name).label + so_far] = quantity(name).text(numbers[name], known.get(name))
    if "max_speed" in history and "largest_flow_speed" not in numbers:
        found["fastest particle"] = quantity("max_speed").text(float(np.nanmax(history["max_speed"])))
    if "front_distance" in history and "runout" not in numbers:
        furthest = float(np.nanmax(np.nan_to_num(history["front_distance"])))
        found[quantity("front_distance").label] = quantity("front_distance").text(furthest)
    if "wall_time" in run.summary:
        found["computed in"] = _duration(run.summary["wall_time"])
    return found


def _warnings(run):
    """Marked lines: what in the audit a reader should know of, or that there is nothing."""
    found = list(remarks(run))
    return [Note(text) for text in found] or [Note("The audit shows nothing to warn of.", "good")]


def _pictures(run, view, folder):
    moments = _moments(run)
    pictures = drawn(view.picture, moments, worker_count(view.size, view.most_points, len(moments)))
    for i, picture in zip(moments, pictures, strict=True):
        yield Picture(_as_jpeg(picture, folder / f"{i}.jpg"), f"t = {run.times[i]:g} s")
    try:
        WeakLayer.of(run)
    except InputError:
        return
    broken = view.cut_away() if run.dimension == 3 else view_of(run, view.size, FRACTURE)
    i = _half_broken(run, broken.layer)
    cut = ", what lies over it cut away" if run.dimension == 3 else ""
    yield Picture(_as_jpeg(broken.picture(i), folder / "weak_layer.jpg"),
                  f"t = {run.times[i]:g} s: the weak layer as it fails{cut}")


def _half_broken(run, layer):
    """Number of a frame in which about half of what breaks of the weak layer has broken."""
    sampled = np.unique(np.linspace(0, len(run) - 1, min(len(run), 40)).round().astype(int))
    damage = []
    for i in sampled:
        fields = run.frame(int(i), ["damage", "material"]).fields
        damage.append(float(fields["damage"][fields["material"] == layer.weak].mean()))
    middle = 0.5 * (damage[0] + max(damage))
    return int(sampled[int(np.argmax(np.array(damage) >= middle))])


def _moments(run):
    """Numbers of a few frames: the start, the end, and between them where the speed rises and falls."""
    speed = run.history.get("max_speed")
    if speed is None or len(run) <= MOMENTS or not np.nanmax(speed, initial=0.0) > 0.0:
        return np.unique(np.linspace(0, len(run) - 1, MOMENTS).round().astype(int)).tolist()
    way = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(run.history["time"]) * np.nan_to_num(speed[1:] + speed[:-1]))])
    times = [np.interp(share * way[-1], way, run.history["time"]) for share in (0.2, 0.5)]
    return sorted({0, len(run) - 1, *(nearest_frame(run, time) for time in times)})


def _as_jpeg(picture, path):
    Image.fromarray(picture).save(path, quality=88)
    return path


def _film(run):
    film = run.path.with_name("film.mp4")
    if not film.is_file():
        return []
    if film.stat().st_size > FILM:
        return [Note(f"The film, {film.stat().st_size >> 20} MiB, lies beside the run: {film.name}", "good")]
    return [Live(page.figure(film, "the film"), f"The film lies beside the run: {film.name}")]


def _turning(run, view, interactive):
    if not interactive:
        return []
    return [Live(viewer(run, view)), Paragraph("Drag to turn, wheel or two fingers to come closer, shift-drag to move,"
                                               " double-click to go back.")]


def _curves(run, folder):
    if len(run.history.get("time", ())) > 1:
        yield Picture(render_history(run, folder / "history.png"), "Over time.")
    if run.saw_test:
        yield Picture(render_saw_test(run, folder / "saw_test.png"), "The saw test.")
    if has_panels(run):
        yield Picture(render_panels(run, folder / "panels.png")[0], "Pressure over the face of obstacles with panels.")


FIRST = ("peak_pressure", "peak_depth")
"""Maps that stand first, the one that there is."""


def _shown(run):
    """Names of the maps that hold something."""
    return [name for name, raster in run.maps.items() if (raster.values > 0.0).any()]


def _first(run):
    """Name of the map that stands first; none of a run without run-out."""
    return next((name for name in FIRST if name in _shown(run) and "runout" in run.hazard.get("numbers", {})), None)


def _first_map(run, sheet, folder):
    """The map of the hazard, before all else."""
    if name := _first(run):
        yield Picture(sheet.render(name, folder / f"{name}.png"), quantity(name).definition)


def _maps(run, sheet, folder):
    drawn = [Picture(sheet.render(name, folder / f"{name}.png"), quantity(name).definition)
             for name in _shown(run) if name != _first(run)]
    if drawn:
        yield Columns(tuple(drawn))
    if run.hazard.get("profile"):
        yield Picture(render_thalweg(run, folder / "thalweg.png"), "Along the thalweg.")
        if "velocity" in run.field_names:
            yield Picture(render_thalweg_time(run, folder / "thalweg_time.png"),
                          "Depth and speed along the thalweg over time, the largest across it.")


def _hazard(run):
    if run.hazard:
        status = status_of(run)
        yield Note(status.text, "good" if status.final else "warning")
        yield _table(run.hazard.get("numbers", {}), known=resolution_of(run))
        known = {"projection": projection_name(run.provenance.get("crs")) or "not known", **parameters(run)}
        yield Table(known)


def _areas(run):
    for name, rows in run.hazard.get("classes", {}).items():
        yield Table({f"{quantity(name).label}, {row['class']}": written(row["area"], "m2") for row in rows})


def _impacts(run):
    for name, one in impacts(run).items():
        texts = one.texts()
        yield Table({"obstacle": name, **{quantity(number).label: text for number, text in texts.items()}},
                    {quantity(number).label: quantity(number) for number in texts})


def _last_row(run):
    return {name: values[-1] for name, values in run.history.items() if len(values) and name != "time"}


def _table(values, units=None, dimension=3, known=None):
    """Values by quantity name as a table that leads to their definitions. known: {name: resolution} of numbers of
    hazard mapping, which are rounded as in files."""
    named = {name: quantity(name, (units or {}).get(name, ""), dimension) for name in values}
    if known is not None:
        values = {name: rounded(value, known.get(name)) for name, value in values.items()}
    return Table({one.label: one.text(values[name], (known or {}).get(name)) for name, one in named.items()},
                 {one.label: one for one in named.values()})


def _told(run):
    """The quantities of the report that have a definition, each once."""
    pressed = (one.name for one in IMPACT if any(map(loaded, run.obstacles.values())))
    names = dict.fromkeys([*run.hazard.get("numbers", {}), *run.maps, *_last_row(run), *pressed])
    return tuple(one for one in map(quantity, names) if one.definition)


def _reproduction(run):
    origin = run.provenance
    precision, backend = origin.get("precision", "f32"), origin.get("backend", "auto")
    made = {name: origin[name] for name in ("version", "taichi", "numpy", "python", "backend", "device", "threads",
                                            "precision", "seed") if name in origin}
    yield Listing("\n".join([f"# with snowmpm {origin.get('version', '')}",
                             f"snowmpm run scene.toml --backend {quote(backend)} --precision {quote(precision)}",
                             f"snowmpm report {quote('runs/' + origin.get('scene_name', 'NAME'))}"]))
    yield Paragraph("scene.toml lies in the folder of the run, and is the text under Settings. On a processor the"
                    " result is bitwise the same for any number of threads.")
    yield Table(made)
    if run.summary:
        yield Listing(json.dumps(run.summary, indent=1), "summary.json")


def _count(number):
    return f"{number:,}".replace(",", "\u202f")


def _duration(seconds):
    minutes = round(seconds / 60.0)
    return f"{seconds:.0f} s" if seconds < 100.0 else f"{minutes} min" if minutes < 100 else f"{minutes / 60.0:.1f} h"
