"""A run at a prompt or in a notebook: pictures inline, an interactive view, a PyVista plotter."""

import base64
import html
import io
import os
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.cinema.studio import do_without_display

if TYPE_CHECKING:
    import pyvista

WIDTH, HEIGHT = 960, 560
"""Pixels of a view in a notebook."""
SMALL = 360
"""Width of the picture beside the facts of a run [pixels]."""
SNOW, GROUND, BUILT = "#f4f7fb", "#b9b5ad", "#8a8a8a"
MOST_POINTS = 20_000
"""Of a small picture."""
MOST_READ = 1_000_000
"""Particles from which on none is drawn unasked."""
CURVES = ("history", "saw_test", "compression", "thalweg_time", "thalweg")


class Pictures:
    """Pictures that a notebook shows inline; `save(path)` writes the first, or all beside each other by number."""

    pictures: dict[str, bytes]

    def __init__(self, pictures: dict[str, bytes]) -> None:
        """pictures: PNG by name."""
        self.pictures = pictures

    def save(self, path: "str | Path") -> list[Path]:
        """Write them as PNG: one to `path`, of several each to NAME_WHAT.png; -> the paths."""
        path = Path(path)
        if path.suffix.lower() != ".png":
            raise InputError.at("path", str(path), "must end in .png")
        places = [path] if len(self.pictures) == 1 else [
            path.with_name(f"{path.stem}_{name}.png") for name in self.pictures]
        for place, picture in zip(places, self.pictures.values(), strict=True):
            place.write_bytes(picture)
        return places

    def __repr__(self) -> str:
        return f"pictures of {', '.join(self.pictures)}: a notebook shows them; save(path) writes them"

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, Any]:
        """One as a picture, several as HTML: a notebook keeps every form that it is given."""
        if len(self.pictures) == 1:
            return {"image/png": next(iter(self.pictures.values())), "text/plain": repr(self)}
        return {"text/html": "".join(f'<img alt="{html.escape(name)}" style="max-width:100%" src="{_source(picture)}">'
                                     for name, picture in self.pictures.items()), "text/plain": repr(self)}


class View:
    """The interactive page of a run, which a notebook shows in a frame; `save(path)` writes it as one .html file."""

    page: str
    title: str

    def __init__(self, page: str, title: str) -> None:
        self.page, self.title = page, title

    def save(self, path: "str | Path") -> Path:
        """Write the page; -> its path."""
        path = Path(path)
        if path.suffix.lower() != ".html":
            raise InputError.at("path", str(path), "must end in .html")
        path.write_text(self.page, encoding="utf-8")
        return path

    def __repr__(self) -> str:
        return f"interactive view of {self.title}: a notebook shows it; save(path) writes a page"

    def _repr_html_(self) -> str:
        return (f'<iframe title="{html.escape(self.title)}" sandbox="allow-scripts" style="width:100%;'
                f'max-width:{WIDTH}px;height:{HEIGHT}px;border:0" srcdoc="{html.escape(self.page)}"></iframe>')


def plot(run: Run, *names: str) -> Pictures:
    """Pictures of a run by name: its maps (`run.maps`), "still" (its last frame), and the curves "history", "thalweg",
    "thalweg_time", "saw_test", "compression". By default what tells most, which is the peak pressure, the saw test or
    the last frame, and the history. Raises InputError for what the run does not have."""
    chosen = names or _usual(run)
    known = [*run.maps, *CURVES, "still"]
    for name in chosen:
        if name not in known:
            raise InputError.not_in("picture", name, known, file=run.path)
    return Pictures({name: _drawn(run, name) for name in chosen})


def show(run: Run, *, color: str | None = None, camera: str | None = None) -> View:
    """The run in motion, turned by hand, as an element for a notebook that needs no network; color, camera and errors
    as of `render_run`."""
    from snowmpm.render.viewer import render_page

    with tempfile.TemporaryDirectory() as folder:
        page = render_page(run, Path(folder) / "run.html", color=color, camera=camera)
        return View(page.read_text(encoding="utf-8"), run.title)


def plotter(run: Run, i: int = -1, color: str | None = None, **options: Any) -> "pyvista.Plotter":
    """A `pyvista.Plotter` with frame i: snow coloured by a field (`color`, by default the speed where there is one),
    terrain and obstacles; options: of `pyvista.Plotter`, by default off_screen where there is no display. Raises
    InputError for an unknown field."""
    do_without_display()
    import pyvista

    if not len(run):
        raise InputError(f"{run.path}: no frame to draw yet")
    blocks = run.frame(i).to_pyvista()
    snow: Any = blocks["snow"]
    if color is None:
        color = "speed" if "velocity" in snow.point_data else None
    if color == "speed" and "speed" not in snow.point_data and "velocity" in snow.point_data:
        snow.point_data["speed"] = np.linalg.norm(snow.point_data["velocity"], axis=1)
        snow.user_dict["units"] = {**snow.user_dict["units"], "speed": "m/s"}
    if color is not None and color not in snow.point_data:
        raise InputError.not_in("color", color, list(snow.point_data), file=run.path)
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        options.setdefault("off_screen", True)
    made: Any = pyvista.Plotter(**options)
    for name in blocks.keys():  # noqa: SIM118 (of a MultiBlock, whose iterator gives data sets)
        if name != "snow":
            made.add_mesh(blocks[name], color=GROUND if name == "terrain" else BUILT, name=name)
    if snow.n_points:
        title: dict[str, Any]
        unit = "" if color is None else snow.user_dict["units"].get(color, "")
        title = {"scalar_bar_args": {"title": f"{color} [{unit}]" if unit not in ("", "1") else color, "fmt": "%.3g"}}
        if color == "speed":
            title["clim"] = [0.0, max(1e-9, float(snow.point_data[color].max()))]
        made.add_mesh(snow, name="snow", style="points", render_points_as_spheres=True, point_size=5,
                      **({"color": SNOW} if color is None else {"scalars": color, "cmap": "viridis", **title}))
    if run.dimension == 2:
        made.view_xz()
    made.add_text(f"t = {run.times[i]:g} s", font_size=10, name="time")
    return made


def thumbnail(run: Run) -> str:
    """A small picture of a run as an element of HTML; "" where none can be drawn."""
    try:
        known = run.path.stat()
        picture = _small(str(run.path.resolve()), known.st_mtime_ns, known.st_size)
        return f'<img width="{SMALL}" src="{_source(picture)}">' if picture else ""
    except Exception:  # a glance at a run must never fail
        return ""


@lru_cache(maxsize=16)
def _small(path: str, changed: int, size: int) -> bytes:
    """A map of a run, or the particles of its last frame, kept until the file changes; none where it would be slow."""
    run = Run(path)
    if "peak_depth" not in run.maps and run.n_points(-1) > MOST_READ:
        return b""
    return _compact(_drawn(run, "peak_depth") if "peak_depth" in run.maps else _glimpse(run), 2 * SMALL)


def _glimpse(run: Run) -> bytes:
    """The last frame as points, drawn in a moment: from the side in 2-D, from above in 3-D."""
    up = 2 if run.dimension == 2 else 1
    frame = run.frame(-1, [name for name in ("velocity",) if name in run.field_names])
    points = frame.positions[:: max(1, len(frame) // MOST_POINTS)]
    figure = Figure(figsize=(5.0, 3.0), dpi=130, layout="constrained")
    axes = figure.add_subplot(aspect="equal")
    if run.terrain is not None and run.dimension == 2:
        for ends in (run.terrain.vertices + run.origin)[run.terrain.facets]:
            axes.plot(ends[:, 0], ends[:, 2], color=GROUND, lw=1.0)
    speed = np.linalg.norm(frame.fields["velocity"], axis=1)[:: max(1, len(frame) // MOST_POINTS)] if frame.fields \
        else None
    drawn = axes.scatter(points[:, 0], points[:, up], s=1.0, c=speed, cmap="viridis", linewidths=0)
    if speed is not None:
        figure.colorbar(drawn, ax=axes, label="speed [m/s]", shrink=0.5, location="bottom")
    axes.set_title(f"t = {frame.time:g} s", fontsize=9)
    axes.tick_params(labelsize=7)
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def _usual(run: Run) -> tuple[str, ...]:
    first = "peak_pressure" if "peak_pressure" in run.maps else "saw_test" if run.saw_test else "still"
    return (first, "history")


def _drawn(run: Run, name: str) -> bytes:
    """A picture as PNG."""
    from snowmpm import render

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        if name == "still":
            render.render_run(run, path)
        elif name == "thalweg":
            render.render_thalweg(run, path)
        elif name in CURVES:
            render.PLOTS[name](run, path)
        else:
            render.render_map(run, name, path, dpi=110)
        return _compact(path.read_bytes())


def _compact(picture: bytes, width: int | None = None) -> bytes:
    """The PNG in 256 colours, and not wider than so many pixels: a notebook keeps every picture as text."""
    image = Image.open(io.BytesIO(picture)).convert("RGB")
    if width is not None and image.width > width:
        image = image.resize((width, round(image.height * width / image.width)), Image.Resampling.LANCZOS)
    small = io.BytesIO()
    image.quantize(256, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
    return small.getvalue()


def _source(picture: bytes) -> str:
    return f"data:image/png;base64,{base64.b64encode(picture).decode()}"
