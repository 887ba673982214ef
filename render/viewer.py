"""A run as an interactive page: the scene in three dimensions, turned with the mouse, in one HTML file."""

import json
import zlib
from pathlib import Path

import numpy as np

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import light
from snowmpm.render.ground import contour_interval, ground_colour
from snowmpm.render.page import encoded, escaped, page, script, write_page
from snowmpm.render.run_film import view_of
from snowmpm.render.solid import placed
from snowmpm.render.surface_points import surface_points

FRAMES = 48
POINTS = 1_000_000  # of all frames together: some megabytes
COARSEST = 8.0  # particle spacings: side of the cells that stand for the snow, at most
TERRAIN = 200  # cells of the ground along its longer side
BALL = 1.7  # diameter of a point in cells
SCALE = 65535
NEVER = 1e9  # m: a distance between contours that draws none
PLAY = "\u25b6"
PLAIN = np.tile(np.array([[243, 247, 252]], np.uint8), (256, 1))


def render_page(run_path: PathLike | Run, output: PathLike, *, color: str | None = None,
                camera: str | None = None) -> Path:
    """Write the interactive page of a run; -> its path. color, camera and errors as of `render_run`."""
    run = run_path if isinstance(run_path, Run) else Run(run_path)
    if not str(output).lower().endswith(".html"):
        raise InputError.at("output", str(output), "must end in .html")
    view = view_of(run, (1280, 720), color, camera)
    body = f"{viewer(run, view)}\n{script('viewer.js')}"
    return write_page(output, page(view.title.replace("_", " "), body, whole=True))


def viewer(run, view, frames=FRAMES, points=POINTS):
    """The element that shows a run, for a page that ends in `script("viewer.js")`.

    view: the `run_film` view whose colours and camera it starts with; frames, points: how many at most
    """
    chosen = np.unique(np.linspace(0, len(run) - 1, min(frames, len(run))).round().astype(int))
    flat = run.dimension == 2
    cell = _cell(run, view, chosen, points, flat)
    snow = [_snow(view, int(i), cell, flat) for i in chosen]
    solids = [placed(run, int(i)) for i in chosen] if run.obstacles else []
    terrain = _section_ground(view) if flat else _ground(view)
    everything = [s.points for s in snow if len(s.points)] + [v for v, _ in solids]
    if not flat:
        everything = [_clipped(p, view.action) for p in everything]
    corners = np.concatenate([*everything, *([terrain[0]] if terrain else [])])
    low, high = corners.min(axis=0).astype(float), corners.max(axis=0).astype(float)
    span = np.maximum(high - low, 1e-6)
    parts, counts = [], []
    if terrain:
        parts += [_quantised(terrain[0], low, span), terrain[1].astype(np.uint8), terrain[2].astype(np.uint32)]
    if solids:
        facets = solids[0][1]
        facets = facets if facets.shape[1] == 3 else _ribbon_facets(len(solids[0][0]), facets)
        parts.append(facets.astype(np.uint32))
    for k, one in enumerate(snow):
        inside = ((one.points >= low) & (one.points <= high)).all(axis=1)
        counts.append(int(inside.sum()))
        parts += [_quantised(one.points[inside], low, span), np.round(127 * one.normals[inside]).astype(np.int8),
                  np.round(255 * one.values[inside]).astype(np.uint8)]
        if solids:
            vertices = solids[k][0]
            behind = np.array([0.0, 0.02 * span[0], 0.0])
            vertices = np.concatenate([vertices, vertices + behind]) if flat else vertices
            parts.append(_quantised(np.clip(vertices, low, high), low, span))
    scale = view.scale
    head = {
        "low": low.tolist(), "span": span.tolist(), "reach": float(np.linalg.norm(span)), "frames": counts,
        "times": [round(float(run.times[i]), 6) for i in chosen], "size": BALL * cell, "sun": _sun(view, flat),
        "interval": _contours(None if flat else terrain) or NEVER,
        "table": (PLAIN if scale is None else (255 * scale.table()).astype(np.uint8)).ravel().tolist(),
        "terrain": {"vertices": len(terrain[0]), "facets": len(terrain[2])} if terrain else None,
        "solids": {"vertices": len(solids[0][0]) * (2 if flat else 1), "facets": len(facets)} if solids else None,
        "camera": _start(view, corners if flat else view.action.points, flat), "pause": max(40.0, 6000.0 / len(chosen)),
        "start": _liveliest(run, chosen),
    }
    data = zlib.compress(b"".join(np.ascontiguousarray(part).tobytes() for part in parts), 6)
    title = escaped(view.title.replace("_", " "))
    about = json.dumps(head, allow_nan=False).replace("<", "\\u003c")
    return (f'<div class="viewer"><canvas aria-label="{title} in three dimensions"></canvas>\n'
            f'<div class="title">{title}</div><div class="said"></div>{_legend(scale)}\n'
            f'<div class="bar"><button title="play">{PLAY}</button>'
            f'<input type="range" min="0" value="0" aria-label="time"><span class="clock"></span></div>\n'
            f'<script type="application/json">{about}</script>\n'
            f'<script type="text/plain" class="data">{encoded(data)}</script></div>')


def _contours(terrain):
    """Distance in height between contour lines [m], 0 for none, of ground from `_ground`."""
    if terrain is None or not len(terrain[0]):
        return 0.0
    vertices = terrain[0]
    return contour_interval(vertices[:, 2], float(np.ptp(vertices[:, :2], axis=0).max()))


def _liveliest(run, chosen):
    """Number, among the frames chosen, of the one with most motion; the last when nothing says."""
    energy = run.history.get("kinetic_energy")
    if energy is None or not np.isfinite(energy).any():
        return len(chosen) - 1
    most = run.history["time"][int(np.nanargmax(energy))]
    return int(np.abs(run.times[chosen] - most).argmin())


def _legend(scale):
    if scale is None:
        return ""
    stops = ", ".join("rgb({},{},{})".format(*(255 * colour).astype(int)) for colour in scale.table()[::16])
    ends = f"<span>{escaped(f'{scale.low:g}')}</span><span>{escaped(f'{scale.high:g}')}</span>"
    if scale.names:
        ends = "".join(f"<span>{escaped(name.replace('_', ' '))}</span>" for name in scale.names)
    return (f'<div class="legend">{escaped(scale.title)}<div class="strip" style="background:linear-gradient(90deg,'
            f'{stops})"></div><div class="ends">{ends}</div></div>')


def _cell(run, view, chosen, points, flat):
    """Side of the cells [m] with which all frames together have about as many points as wanted."""
    sample = [int(i) for i in chosen[:: max(1, len(chosen) // 4)]]
    cell = 1.15 * view.spacing
    while cell < COARSEST * view.spacing:
        count = np.mean([len(_snow(view, i, cell, flat).points) for i in sample]) * len(chosen)
        if count <= points:
            break
        # The points of a surface go with the square of the cell
        cell *= max(1.1, 0.95 * (count / points) ** 0.5)
    return cell


def _snow(view, i, cell, flat):
    frame = view.fields_of(i)
    if view.scale is None:
        share = np.zeros(len(frame))
    else:
        share = np.nan_to_num(view.scale.share(view.scale.numbers(frame)))
        if view.layer:  # all but the weak layer is as sound
            share = np.where(frame.fields["material"] == view.layer.weak, share, 0.0)
    return surface_points(frame.points, share, cell, flat)


def _clipped(points, action):
    """Points within the surroundings of the action: what flies far off would make all else small."""
    lower, upper = action.box()
    return points[((points[:, :2] >= lower) & (points[:, :2] <= upper)).all(axis=1)]


def _quantised(points, low, span):
    return np.round(np.clip((points - low) / span, 0.0, 1.0) * SCALE).astype(np.uint16)


def _ground(view):
    """(vertices, colours, facets) of the ground on a regular grid, with walls below its rim; None without ground."""
    relief = view.relief
    if relief is None:
        return None
    step = max(1, -(-max(relief.heights.shape) // TERRAIN))
    heights = relief.heights[::step, ::step]
    rows, columns = np.indices(heights.shape)
    x, y = relief.x0 + columns * step * relief.cell, relief.y0 + rows * step * relief.cell
    known = np.isfinite(heights)
    number = np.where(known, known.ravel().cumsum().reshape(known.shape) - 1, -1)
    vertices = np.stack([x[known], y[known], heights[known]], axis=-1)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    whole = (np.stack([a, b, c, d]) >= 0).all(axis=0)
    a, b, c, d = (n[whole] for n in (a, b, c, d))
    facets = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    colours = light.encode(ground_colour(relief, vertices, view.sun, view.cover))
    return vertices, colours, facets


def _section_ground(view):
    """The ground of a section as a ribbon from its profile downwards."""
    if view.profile is None:
        return None
    x, z = view.profile.x, view.profile.z
    depth = 0.12 * float(np.ptp(x))
    # Below the lowest ground it ends evenly
    low = np.full_like(z, z.min() - 0.25 * depth)
    top = np.column_stack([x, np.full_like(x, 1e-3 * depth), z])
    bottom = np.column_stack([x, np.full_like(x, 1e-3 * depth), low])
    n = len(x)
    a = np.arange(n - 1)
    facets = np.concatenate([np.column_stack([a, a + n, a + 1]), np.column_stack([a + 1, a + n, a + n + 1])])
    shade = np.concatenate([np.tile([[150, 138, 126]], (n, 1)), np.tile([[96, 90, 88]], (n, 1))])
    return np.concatenate([top, bottom]), shade, facets


def _ribbon_facets(n, segments):
    """Triangles between segments of n vertices and the same again, numbered from n on."""
    a, b = segments.T
    return np.concatenate([np.column_stack([a, b, a + n]), np.column_stack([b, b + n, a + n])])


def _sun(view, flat):
    return [0.2, -0.75, 0.63] if flat else [float(x) for x in view.sun]


def _start(view, corners, flat):
    low, high = corners.min(axis=0), corners.max(axis=0)
    target = (0.5 * (low + high)).astype(float).tolist()
    if flat:
        return {"azimuth": np.pi, "elevation": 0.02, "target": target,
                "distance": 1.05 * float(max(high[0] - low[0], 1.8 * (high[2] - low[2])))}
    bearing, elevation = (float(part) for part in view.camera.bearing_and_elevation().split(","))
    return {"azimuth": np.radians(bearing), "elevation": min(np.radians(elevation), 1.5), "target": target,
            "distance": 1.55 * float(np.linalg.norm(high - low))}
