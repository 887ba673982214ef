"""Crest and front are in the picture in every frame: bounds of the moving snow through the camera's projection."""

import subprocess
import sys

import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d

from snowmpm.io import Run
from snowmpm.render.run_film import view_of

SIZE = (1280, 720)
STRAYS = 0.005
"""Share of the moving snow ahead of its front, and behind its rear, as the front is defined."""
MOVING = 0.05
"""Share of the largest speed of a run from which snow moves."""

SCENES = {
    "avalanche_depth_averaged": {"output.interval": 4.0},
    "avalanche_on_raster": {"solver.dx": 3.0, "output.interval": 2.0},
    "column_collapse_2d": {"output.interval": 0.05},
    "column_collapse_3d": {"solver.dx": 0.04, "output.interval": 0.05},
    "crown_and_flanks": {"solver.dx": 0.5, "output.interval": 0.2},
    "impact_mast": {"solver.dx": 0.4, "output.interval": 0.2},
    "impact_wall_2d": {"output.interval": 0.1},
    "slab_release": {"solver.dx": 0.64, "output.interval": 0.5},
    "slab_release_2d": {"solver.dx": 0.1, "output.interval": 0.5},
    "slushflow": {"solver.dx": 10.0, "output.interval": 10.0},
}
"""Ten scenes of the library, coarser than they are."""


def camera_of(view, i):
    """The camera of frame `i`; of a section that is seen from near, that of the inset with the whole of it."""
    if view.run.dimension == 3:
        return view.camera
    return view.track.overview(SIZE) if view.track.close else view.track.camera(i)


def outside(camera, points):
    """Pixels by which the farthest of some points is out of the picture; negative within."""
    x, y, depth = camera.project(points)
    assert (depth > 0.0).all()
    return float(max(-x.min(), x.max() - camera.size[0], -y.min(), y.max() - camera.size[1]))


def ends(points):
    """Those of points (n, 3) that lie, along each axis and the direction in which they spread most, at the ends without
    strays."""
    middle = points.mean(axis=0)
    spread = np.linalg.svd(points[:: max(1, len(points) // 5000)] - middle, full_matrices=False)[2][0]
    rows = set()
    for values in ((points - middle) @ np.column_stack([np.eye(3), spread])).T:
        low, high = np.quantile(values, [STRAYS, 1.0 - STRAYS])
        rows |= {int(np.abs(values - low).argmin()), int(np.abs(values - high).argmin())}
    return points[sorted(rows)]


def worst_frame(run):
    """(pixels outside, frame) of the frame in which crest or ends of the moving snow are farthest out of the picture.

    The crest is the highest point of the snow that lay still at first and moves later.
    """
    view = view_of(run, SIZE, drawn=False)
    frames = [run.frame(i, ["velocity"]) for i in range(len(run))]
    speeds = [np.linalg.norm(np.nan_to_num(frame.fields["velocity"]), axis=1) for frame in frames]
    fastest = max(float(np.quantile(speed, 0.99)) for speed in speeds)
    moved = [frame.points[speed > MOVING * fastest] for frame, speed in zip(frames, speeds, strict=True)]
    known = [(i, points) for i, points in enumerate(moved) if len(points) > 20]
    assert len(known) > 3
    first = known[0][1]
    crest = first[[int(np.abs(first[:, 2] - np.quantile(first[:, 2], 1.0 - STRAYS)).argmin())]]
    return max((outside(camera_of(view, i), np.concatenate([crest, ends(points)])), i) for i, points in known)


@pytest.mark.parametrize("kind", ["section", "slope", "far away", "with obstacles"])
def test_made_up_avalanches(kind, tmp_path):
    if kind == "section":
        slab_2d(tmp_path, frames=7)
    else:
        slab_3d(tmp_path, particles=4000, frames=7, obstacles=kind == "with obstacles",
                origin=(6e5, 2e5, 1500.0) if kind == "far away" else (0.0, 0.0, 0.0))
    pixels, frame = worst_frame(Run(tmp_path))
    assert pixels < 0.0, f"frame {frame}: {pixels:.0f} px out of the picture"


def test_a_camera_of_the_release_alone_would_lose_the_front(tmp_path, monkeypatch):
    """The measure sees it."""
    from snowmpm.render import framing

    slab_3d(tmp_path, particles=4000, frames=7)
    usual = framing.moving_samples
    monkeypatch.setattr(framing, "moving_samples", lambda run: usual(run)[:2])
    pixels, frame = worst_frame(Run(tmp_path))
    assert pixels > 0.0 and frame > 2


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_scenes_of_the_library(name, tmp_path):
    settings = [word for key, value in SCENES[name].items() for word in ("--set", f"{key}={value}")]
    subprocess.run([sys.executable, "-m", "snowmpm", "run", name, "-o", str(tmp_path), "--threads", "1", *settings],
                   check=True, capture_output=True)
    pixels, frame = worst_frame(Run(tmp_path))
    assert pixels < 0.0, f"frame {frame}: {pixels:.0f} px out of the picture"
