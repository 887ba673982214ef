"""The interactive page of a run: what is in it, and where it begins."""

import json
from pathlib import Path

import numpy as np

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.ground import contour_interval
from snowmpm.render.page import escaped, page, script, write_page
from snowmpm.render.run_film import view_of
from snowmpm.render.viewer.fields import PLAIN, fields_of
from snowmpm.render.viewer.ground import section_ground, space_ground
from snowmpm.render.viewer.layers import layers_of
from snowmpm.render.viewer.packing import Parts, in_box
from snowmpm.render.viewer.snow import Snow, add_snow, clipped

SCRIPTS = ("unpack.js", "stance.js", "pick.js", "paint.js", "measure.js", "viewer.js")
"""What a page with viewers ends in, in this order."""

FRAMES = 48
POINTS = 1_500_000  # of all frames together, for the memory of a phone
LETTERS = 8_000_000  # of the snow's data; with ground, maps and scripts the page stays below 10 MB
BALL = 1.7  # diameter of a point in cells
NEVER = 1e9  # m: a distance between contours that draws none


def render_page(run_path: PathLike | Run, output: PathLike, *, color: str | None = None,
                camera: str | None = None) -> Path:
    """Write the interactive page of a run; -> its path. color, camera and errors as of `render_run`."""
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    if not str(output).lower().endswith(".html"):
        raise InputError.at("output", str(output), "must end in .html")
    view = view_of(run, (1280, 720), color, camera, drawn=False)
    body = f"{viewer(run, view)}\n{script(*SCRIPTS)}"
    return write_page(output, page(view.title.replace("_", " "), body, whole=True))


def viewer(run, view, frames=FRAMES, points=POINTS, letters=LETTERS):
    """The element that shows a run, for a page that ends in `script(*SCRIPTS)`.

    view: the `run_film` view whose colours and camera it starts with; frames, points: how many at most; letters: of the
    page for the snow
    """
    chosen = np.unique(np.linspace(0, len(run) - 1, min(frames, len(run))).round().astype(int))
    flat, fields = run.dimension == 2, fields_of(view)
    snow = Snow(view, fields, chosen)
    snow.fit(points, letters)
    cells = [snow.frame(int(i)) for i in chosen]
    solids = [view.solids(int(i)) for i in chosen] if run.obstacles or view.saw else []
    if flat:
        solids = [_ribbon(*solid, 0.02 * max(np.ptp(one.points[:, 0]) for one in cells if len(one.points)))
                  for solid in solids]
    ground = section_ground(view.profile) if flat else space_ground(view)
    everything = [one.points for one in cells if len(one.points)] + [vertices for vertices, _ in solids]
    if not flat:
        everything = [_clipped(some, view.action) for some in everything]
    corners = np.concatenate([*everything, *([] if ground is None else [ground.vertices])])
    low, high = corners.min(axis=0).astype(float), corners.max(axis=0).astype(float)
    span = np.maximum(high - low, 1e-6)
    kept = corners if flat else view.action.points
    parts = Parts()
    if ground is not None:
        parts.add("ground.place", in_box(ground.vertices, low, span))
        parts.add("ground.colour", ground.colours)
        parts.add("ground.facets", ground.facets.astype(np.uint32))
        if ground.picture is not None:
            parts.add_bytes("ground.picture", ground.picture)
    if solids:
        parts.add("solid.facets", solids[0][1].astype(np.uint32))
        for k, (vertices, _) in enumerate(solids):
            parts.add(f"solid.{k}.place", in_box(vertices, low, span))
    counts = [add_snow(parts, k, clipped(one, low, high), low, span) for k, one in enumerate(cells)]
    head = {
        "low": low.tolist(), "span": span.tolist(), "reach": float(np.linalg.norm(span)), "flat": flat,
        "origin": [float(x) for x in run.origin], "frames": counts,
        "times": [round(float(run.times[i]), 6) for i in chosen], "size": BALL * snow.cell, "sun": _sun(view, flat),
        "interval": _contours(None if flat else ground) or NEVER, "plain": PLAIN,
        "fields": [field.head() for field in fields], "field": -1 if view.scale is None else 0,
        "layers": [] if flat else layers_of(run, parts),
        "ground": None if ground is None else {"facets": ground.ground, "box": list(ground.box)},
        "camera": _start(view, kept, flat), "keep": _extremes(kept).tolist(), "pause": max(40.0, 6000.0 / len(chosen)),
        "start": _liveliest(run, chosen), "parts": parts.table,
    }
    title = escaped(view.title.replace("_", " "))
    # It holds names that users gave: nothing in it may open an element or read as a call
    about = json.dumps(head, allow_nan=False).replace("<", "\\u003c").replace("(", "\\u0028")
    return (f'<div class="viewer"><canvas aria-label="{title} in three dimensions"></canvas>\n'
            f'<div class="title">{title}</div><div class="said"></div><div class="legends"></div>\n'
            f'<div class="bar"></div>\n<script type="application/json">{about}</script>\n'
            f'<script type="text/plain" class="data">{parts.text()}</script></div>')


def _contours(ground):
    """Distance in height between contour lines [m], 0 for none, of a `ground.Mesh`."""
    if ground is None:
        return 0.0
    vertices = ground.vertices[np.unique(ground.facets[: ground.ground])]
    return contour_interval(vertices[:, 2], float(np.ptp(vertices[:, :2], axis=0).max()))


def _liveliest(run, chosen):
    """Number, among the frames chosen, of the one with most motion; the last when nothing says."""
    energy = run.history.get("kinetic_energy")
    if energy is None or not np.isfinite(energy).any():
        return len(chosen) - 1
    most = run.history["time"][int(np.nanargmax(energy))]
    return int(np.abs(run.times[chosen] - most).argmin())


def _clipped(points, action):
    """Points within the surroundings of the action: what flies far off would make all else small."""
    lower, upper = action.box()
    return points[((points[:, :2] >= lower) & (points[:, :2] <= upper)).all(axis=1)]


def _ribbon(vertices, segments, width):
    """Vertices and triangles of the segments of a section, a `width` [m] deep."""
    a, b = segments.T
    n = len(vertices)
    return (np.concatenate([vertices, vertices + np.array([0.0, width, 0.0])]),
            np.concatenate([np.column_stack([a, b, a + n]), np.column_stack([b, b + n, a + n])]))


def _sun(view, flat):
    return [0.2, -0.75, 0.63] if flat else [float(x) for x in view.sun]


def _extremes(points):
    """Those of points (n, 3) that lie farthest along a few ways: what holds them holds about all."""
    ways = np.stack(np.meshgrid(*[(-1.0, 0.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return points[np.unique((points @ ways.T).argmax(axis=0))].astype(float).round(3)


def _start(view, points, flat):
    """Where the eye stands at first; the page chooses how near, for the shape of its window."""
    low, high = points.min(axis=0), points.max(axis=0)
    bearing, elevation = 180.0, 1.0
    if not flat:
        bearing, elevation = (float(part) for part in view.camera.bearing_and_elevation().split(","))
    return {"azimuth": np.radians(bearing), "elevation": min(np.radians(elevation), 1.5),
            "target": (0.5 * (low + high)).astype(float).tolist(), "distance": float(np.linalg.norm(high - low))}
