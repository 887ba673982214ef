"""Seconds a picture of each look, and of the same scene drawn by PyVista alone, of runs that are there.

    python tests/benchmarks/looks.py RUN ... [--size 1280x720] [--csv FILE]

Each run: the median over three pictures, after one that warms up. `points` is the plainest that PyVista can do: ground,
obstacles and particles as shaded balls in the colours of the diagram, from its camera, without shadows, contours,
hollows, a see-through sheet, or words. The last line names machine, cores and versions.
"""

import argparse
import csv
import os
import platform
import time
from pathlib import Path

import numpy as np
import pyvista as pv

from snowmpm.io import Run
from snowmpm.render import light
from snowmpm.render.cinema.studio import Studio
from snowmpm.render.field_view import GROUND
from snowmpm.render.run_film import view_of
from snowmpm.render.snow import BALL
from snowmpm.render.solid import SOLID

LOOKS = {"diagram": {}, "diagram preview": {"quality": "preview"}, "cinematic": {"look": "cinematic"},
         "cinematic preview": {"look": "cinematic", "quality": "preview"}, "slice": {"look": "slice"}}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", nargs="+")
    parser.add_argument("--size", default="1280x720")
    parser.add_argument("--csv")
    choice = parser.parse_args()
    size, rows = tuple(int(side) for side in choice.size.split("x")), []
    for path in choice.runs:
        run = Run(path)
        filled = [i for i in range(len(run)) if run.n_points(i)]
        frames = [filled[round(share * (len(filled) - 1))] for share in (0.3, 0.5, 0.7)]
        row = {"run": run.name, "particles": max(run.n_points(i) for i in filled)}
        for name, wishes in LOOKS.items():
            # A slice needs a field, the others show snow
            view = view_of(run, size, None if name == "slice" else "snow", **wishes)
            row[name] = f"{median_time(view.picture, frames):.2f}"
        row["points"] = f"{median_time(points(view_of(run, size)), frames):.2f}"
        rows.append(row)
        print(", ".join(f"{name} {value}" for name, value in row.items()), flush=True)
    if choice.csv:
        with open(Path(choice.csv), "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f},"
          f" PyVista {pv.__version__}, NumPy {np.__version__}")


def median_time(picture, frames):
    picture(frames[0])
    took = []
    for i in frames:
        begun = time.perf_counter()
        picture(i)
        took.append(time.perf_counter() - begun)
    return float(np.median(took))


def points(view):
    """The function that draws a frame of a `SpaceView` by PyVista alone."""
    studio = Studio(lit=True)

    def picture(i):
        _, (places, spacing, colours, _) = view._frame(i)
        solid = view.solids(i)

        def add(plotter):
            for vertices, faces, colour in ([(view.relief.vertices, view.relief.facets, GROUND)] if view.relief else []
                                            ) + ([(*solid, light.encode(SOLID))] if len(solid[1]) else []):
                plotter.add_mesh(pv.PolyData.from_regular_faces(np.asarray(vertices, np.float32), np.asarray(faces)),
                                 color=[float(c) / 255.0 for c in colour], render=False, reset_camera=False)
            if len(places):
                cloud = pv.PolyData(np.asarray(places, np.float32))
                if colours is not None:
                    cloud["colour"] = light.encode(colours[:, :3])
                actor = plotter.add_mesh(cloud, style="points_gaussian", point_size=1, scalars=None if colours is None
                                         else "colour", rgb=colours is not None, render_points_as_spheres=True,
                                         render=False, reset_camera=False)
                actor.mapper.scale_factor = BALL * float(np.median(spacing))

        return studio.draw(add, view.camera, light.encode(light.sky(view.camera.size)))

    return picture


if __name__ == "__main__":
    main()
