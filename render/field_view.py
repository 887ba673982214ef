"""Pictures of a field within the snow of a run in 3-D, by PyVista: a slice, arrows, streamlines."""

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render import light
from snowmpm.render.cinema.studio import Studio
from snowmpm.render.gridded import COUNT, gridded, numbers_of
from snowmpm.render.overlay import Overlay
from snowmpm.render.solid import SOLID
from snowmpm.render.space_view import SpaceView

LOOKS = ("slice", "arrows", "streamlines")
AXES = "xyz"

ARROWS = 2500
"""At most."""

LINES = 250
"""Streamlines at most."""

TUBE = 0.12
"""Radius of a streamline, in cells."""

LONGEST = 4.0
"""Longest arrow, in cells of the grid after every so manieth of them is left out."""

FACING = 0.35
"""Cosine between the view and the normal of a slice from which on what is before the slice is taken away."""

GROUND = light.encode(light.decode([0.80, 0.80, 0.78]))


class FieldView(SpaceView):
    """A field of the snow: on a plane through it, or its velocity as arrows or streamlines, over plain ground."""

    def __init__(self, run, size, look, color=None, camera="auto", path=None, at=None, quality=None):
        """at: "x=12" and the like, in the scene's coordinates [m], of a slice; by default through the middle of what
        moves, along its way."""
        super().__init__(run, size, color, camera, path=path, ground="summer", drawn=False, quality=quality)
        if self.scale is None:
            raise InputError.at("color", color, f'goes without look = "{look}", which shows a field')
        if look != "slice" and "velocity" not in run.field_names:
            raise InputError.at("look", look, f"needs the field velocity; {run.path} holds"
                                f" {', '.join(run.field_names)}")
        if at is not None and look != "slice":
            raise InputError.at("at", at, 'goes with look = "slice" only')
        self.look, self._plane = look, self._plane_of(at)
        self._studio = Studio(lit=True)

    def _plane_of(self, at):
        """(axis, place [m] from the run's origin) of a slice."""
        if at is None:
            across = int(abs(self.action.direction[0]) > abs(self.action.direction[1]))
            middle = np.median(self.action.points, axis=0)
            return across, float(middle[across])
        name, _, value = str(at).partition("=")
        try:
            axis, place = AXES.index(name.strip()), float(value)
        except ValueError:
            raise InputError.at("at", at, 'must be "x=", "y=" or "z=" and a number of metres, such as "y=13"') from None
        return axis, place - float(self.run.origin[axis])

    def picture(self, i):
        """(height, width, 3) uint8 of frame `i`."""
        time = float(self.run.times[i])
        camera = self.camera if self.path is None else self.path.camera(time, self.size)
        seen = self.quality.camera(camera)
        grid = gridded(self.run, i, list(dict.fromkeys([self.scale.field, *(
            ["velocity"] if self.look != "slice" else [])])))
        grid.cell_data["number"] = numbers_of(grid.cell_data[self.scale.field])
        solid = self.solids(i)

        def add(plotter):
            self._add_ground(plotter, solid, camera)
            {"slice": self._add_slice, "arrows": self._add_arrows, "streamlines": self._add_streamlines}[self.look](
                plotter, grid)

        picture = self._studio.draw(add, seen, light.encode(light.sky(seen.size)))
        overlay = Overlay(self.quality.enlarged(picture, camera.size))
        if not self.plain:
            self._legend(overlay, time, self.side)
            if self.look == "slice":
                axis, place = self._plane
                overlay.note(f"{AXES[axis]} = {place + self.run.origin[axis]:.6g} m",
                             "left" if self.side == "right" else "right")
        return overlay.picture()

    def _add_ground(self, plotter, solid, camera):
        """Ground and obstacles, before a slice without what lies between it and the camera."""
        import pyvista as pv

        axis, place = self._plane
        towards = float(-camera.axes[2, axis])
        origin, normal = np.zeros(3), np.zeros(3)
        origin[axis], normal[axis] = place, np.sign(towards)
        bodies = [(self.relief.vertices, self.relief.facets, GROUND)] if self.relief else []
        bodies += [(*solid, light.encode(SOLID))] if len(solid[1]) else []
        for vertices, faces, colour in bodies:
            mesh = pv.PolyData.from_regular_faces(np.asarray(vertices, np.float32), np.asarray(faces))
            if self.look == "slice" and abs(towards) > FACING:
                mesh = mesh.clip(normal=normal, origin=origin)
            if not mesh.n_cells:
                continue
            plotter.add_mesh(mesh, color=[float(c) / 255.0 for c in colour], smooth_shading=False, render=False,
                             reset_camera=False)

    def _colours(self):
        return {"scalars": "number", "cmap": self.scale.colormap, "clim": (self.scale.low, self.scale.high),
                "show_scalar_bar": False, "render": False, "reset_camera": False, "lighting": False,
                "nan_opacity": 0.0}

    def _add_slice(self, plotter, grid):
        axis, place = self._plane
        origin = np.array(grid.center)
        origin[axis] = place
        held = grid.threshold(0.5, scalars=COUNT)
        cut = held.slice(normal=np.eye(3)[axis], origin=origin)
        if cut.n_cells:
            plotter.add_mesh(cut, **self._colours())

    def _add_arrows(self, plotter, grid):
        import pyvista as pv

        held = np.flatnonzero(np.asarray(grid.cell_data[COUNT]) > 0)
        step = max(1, -(-len(held) // ARROWS))
        some = np.random.default_rng(0).permutation(held)[: -(-len(held) // step)]
        cloud = pv.PolyData(np.asarray(grid.cell_centers().points)[some])
        velocity = np.asarray(grid.cell_data["velocity"])[some]
        cloud["velocity"], cloud["number"] = velocity, np.asarray(grid.cell_data["number"])[some]
        fastest = float(np.nanmax(np.linalg.norm(velocity, axis=1), initial=1e-9))
        length = LONGEST * grid.spacing[0] * step ** (1.0 / 3.0) / fastest
        arrows = cloud.glyph(orient="velocity", scale="velocity", factor=length, geom=pv.Arrow(
            tip_radius=0.12, shaft_radius=0.04, tip_resolution=8, shaft_resolution=6))
        plotter.add_mesh(arrows, **self._colours())

    def _add_streamlines(self, plotter, grid):
        """Of the velocity of this moment; they end where the snow does."""
        held = np.asarray(grid.cell_data[COUNT]) > 0
        for name in ("velocity", "number"):
            grid.cell_data[name] = np.nan_to_num(grid.cell_data[name])
        field = grid.cell_data_to_point_data(pass_cell_data=True)
        seeds = np.random.default_rng(0).permutation(np.flatnonzero(held))[:LINES]
        import pyvista as pv

        lines = field.streamlines_from_source(
            pv.PolyData(np.asarray(grid.cell_centers().points)[seeds]), vectors="velocity",
            integration_direction="both", max_length=float(np.linalg.norm(grid.dimensions) * grid.spacing[0]),
            terminal_speed=1e-3 * max(float(np.abs(field["velocity"]).max()), 1e-9), initial_step_length=0.3)
        if lines.n_points:
            plotter.add_mesh(lines.tube(radius=TUBE * grid.spacing[0], n_sides=6), **self._colours())
