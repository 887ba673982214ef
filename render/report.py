"""A run as one page to keep and to send: settings, pictures, curves, audit, warnings, how to make it again."""

import json
import math
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.hazard_units import unit_of
from snowmpm.io.impact import impact
from snowmpm.io.remarks import remarks
from snowmpm.render import page
from snowmpm.render.fracture import NAME as FRACTURE
from snowmpm.render.fracture import WeakLayer
from snowmpm.render.history_plot import render_history
from snowmpm.render.peak_map import render_map
from snowmpm.render.run_film import nearest_frame, view_of
from snowmpm.render.saw_test_plot import render_saw_test
from snowmpm.render.thalweg_plot import render_thalweg
from snowmpm.render.viewer import viewer

SIZE = (1280, 620)
MOMENTS = 4
FILM = 24 << 20  # bytes: a larger film is named, not put in


def render_report(run_path, output, *, interactive=True, size=SIZE):
    """Write the report of a run to an .html file that holds all it shows; -> its path.

    interactive: with the scene to turn in three dimensions, some megabytes; size: of its pictures [px].
    Raises InputError for a run without frames, or another ending.
    """
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    if not str(output).lower().endswith(".html"):
        raise InputError.at("output", str(output), "must end in .html")
    view = view_of(run, size)
    title = view.title.replace("_", " ")
    with tempfile.TemporaryDirectory() as folder:
        body = "\n".join(part for part in (
            f"<h1>{page.escaped(title)}</h1>", f'<p class="lead">{page.escaped(_lead(run))}</p>',
            page.numbers(_key_numbers(run)), *_warnings(run),
            page.section("Pictures", *_pictures(run, view, Path(folder)), _film(run)),
            page.section("To turn and move through", _turning(run, view, interactive)),
            page.section("Curves", *_curves(run, Path(folder))),
            page.section("Maps", *_maps(run, Path(folder))),
            page.section("Numbers of hazard mapping", page.table(_hazard(run))),
            page.section("Impact", *_impacts(run)),
            page.section("Audit at the end", page.table(_audit(run))),
            page.section("Settings", page.listing(run.provenance.get("scene", "not known"), "the resolved scene")),
            page.section("How to make it again", *_reproduction(run)),
            f"<footer>snowmpm {page.escaped(run.provenance.get('version', ''))}: {page.escaped(run.path)}</footer>",
            page.script("viewer.js") if interactive else "") if part)
    return page.write_page(output, page.page(title, body))


def _lead(run):
    kind = "three dimensions" if run.dimension == 3 else "plane strain"
    state = "" if run.complete else " Not complete: it goes on, or was stopped."
    return (f"A simulation in {kind} over {run.times[-1]:g} s, {len(run)} frames, with {_count(run.n_points(0))}"
            f" particles on cells of {run.provenance.get('dx', math.nan):g} m.{state}")


def _key_numbers(run):
    history, numbers = run.history, run.hazard.get("numbers", {})
    found = {"particles": _count(run.n_points(0)), "simulated": f"{run.times[-1]:g} s"}
    if "max_speed" in history:
        found["largest speed of any particle"] = f"{np.nanmax(history['max_speed']):.3g} m/s"
    if "runout" in history:
        found["run-out in plan"] = f"{np.nanmax(np.nan_to_num(history['runout'])):.3g} m"
    for name, words, unit in (("deposit_volume", "deposit", "m³"), ("largest_pressure", "largest pressure", "kPa")):
        if name in numbers:
            found[words] = f"{numbers[name] / (1e3 if unit == 'kPa' else 1.0):.3g} {unit}"
    if "wall_time" in run.summary:
        found["computed in"] = _duration(run.summary["wall_time"])
    return found


def _warnings(run):
    """Marked lines: what in the audit a reader should know of, or that there is nothing."""
    found = list(remarks(run))
    return [page.note(text) for text in found] or [page.note("The audit shows nothing to warn of.", "good")]


def _pictures(run, view, folder):
    for i in _moments(run):
        yield page.figure(_as_jpeg(view.picture(i), folder / f"{i}.jpg"), f"t = {run.times[i]:g} s")
    try:
        WeakLayer.of(run)
    except InputError:
        return
    space = run.dimension == 3
    camera = view.camera.bearing_and_elevation() if space else None
    broken = view_of(run, view.size, None if space else FRACTURE, camera, cutaway=space)
    i = _half_broken(run, broken.layer)
    cut = ", what lies over it cut away" if run.dimension == 3 else ""
    yield page.figure(_as_jpeg(broken.picture(i), folder / "weak_layer.jpg"),
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
        return ""
    if film.stat().st_size > FILM:
        return page.note(f"The film, {film.stat().st_size >> 20} MiB, lies beside the run: {film.name}", "good")
    return page.figure(film, "the film")


def _turning(run, view, interactive):
    if not interactive:
        return ""
    return (viewer(run, view) + '<p class="lead">Drag to turn, wheel or two fingers to come closer, shift-drag to move,'
            " double-click to go back.</p>")


def _curves(run, folder):
    if len(run.history.get("time", ())) > 1:
        yield page.figure(render_history(run, folder / "history.png"), "Over time.")
    if run.saw_test:
        yield page.figure(render_saw_test(run, folder / "saw_test.png"), "The saw test.")


def _maps(run, folder):
    drawn = [(render_map(run, name, folder / f"{name}.png"), f"{name} [{raster.units}]".replace("_", " "))
             for name, raster in run.maps.items() if (raster.values > 0.0).any()]
    yield page.columns(page.figure(*one) for one in drawn)
    if run.hazard.get("profile"):
        yield page.figure(render_thalweg(run, folder / "thalweg.png"), "Along the thalweg.")


def _hazard(run):
    return {name.replace("_", " "): f"{_number(value)} {_unit(unit_of(name))}".strip()
            for name, value in run.hazard.get("numbers", {}).items()}


def _impacts(run):
    for name, obstacle in run.obstacles.items():
        one = impact(obstacle)
        if one:
            yield page.table({"obstacle": name, "arrival": f"{one.arrival:.4g} s", "early peak": f"{one.peak:.4g} Pa",
                              "of the peak": f"{one.peak_time:.4g} s", "steady part": f"{one.steady:.4g} Pa"})


def _audit(run):
    last = {name: values[-1] for name, values in run.history.items() if len(values) and name != "time"}
    return {name.replace("_", " "): f"{_number(value)} {_unit(run.units.get(name, ''))}".strip()
            for name, value in last.items()}


def _unit(unit):
    """A unit as it is read: none for "1", powers raised."""
    return {"1": "", "m2": "m²", "m3": "m³", "degrees": "°"}.get(unit, unit)


def _reproduction(run):
    origin = run.provenance
    precision, backend = origin.get("precision", "f32"), origin.get("backend", "auto")
    made = {name: origin[name] for name in ("version", "taichi", "numpy", "python", "backend", "device", "threads",
                                            "precision", "seed") if name in origin}
    yield page.listing("\n".join([f"# with snowmpm {origin.get('version', '')}",
                                  f"snowmpm run scene.toml --backend {backend} --precision {precision}",
                                  f"snowmpm report runs/{origin.get('scene_name', 'NAME')}"]))
    yield ('<p class="lead">scene.toml lies in the folder of the run, and is the text under Settings. On a processor'
           " the result is bitwise the same for any number of threads.</p>")
    yield page.table(made)
    if run.summary:
        yield page.listing(json.dumps(run.summary, indent=1), "summary.json")


def _number(value):
    return f"{value:.4g}" if isinstance(value, float | np.floating) else str(value)


def _count(number):
    return f"{number:,}".replace(",", "\u202f")


def _duration(seconds):
    minutes = round(seconds / 60.0)
    return f"{seconds:.0f} s" if seconds < 100.0 else f"{minutes} min" if minutes < 100 else f"{minutes / 60.0:.1f} h"
