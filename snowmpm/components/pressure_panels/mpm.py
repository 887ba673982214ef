"""Pressure panels in explicit MPM: what the contact of an obstacle changes at nodes, summed up over an interval.

    p = -sum_i share_i sum_steps m_i (v_i' - v_i) . d / (A T)

v_i, v_i': velocity of node i before and after the obstacle acted, m_i its mass, d the direction of the push, share_i of
the node on the panel (`.face`), A the area of the panel, T the interval. Positive where the snow pushes along d.
"""

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.arrays import int_array, real_array
from snowmpm.components.pressure_panels.declare import interval_of
from snowmpm.components.pressure_panels.face import MARGIN, Face
from snowmpm.components.pressure_panels.push import Around, Nodes, push_kernels
from snowmpm.errors import InputError
from snowmpm.mpm.kernel_api import FREE, Plane
from snowmpm.stepping.component import Adapter

STEEP = 0.5
"""Least cosine between an axis of the face and the normal of what ends the snow along it."""
SERIES = "face_pressure"
"""Kind of record that `snowmpm.io.panels` reads."""
MOST_NODES = 100_000_000
"""Nodes of the box around an obstacle."""


def adapter(model):
    """`PressurePanels` of a `Model`."""
    return PressurePanels(model.scene, model.obstacles, model.surface)


class PressurePanels(Adapter):
    """The obstacles with panels of an `MpmSolver`."""

    name = "pressure_panels"

    def __init__(self, scene, obstacles, ground):
        """obstacles: of the model, those of the scene's tables first; ground: `TerrainSurface`, or None."""
        self._obstacles, self._ground, self._faces = obstacles, ground, []
        for i, spec in enumerate(scene.obstacles):
            if spec.panels:
                self._faces.append((i, spec.panels, interval_of(scene, spec.panels), scene.source))

    def begin(self, solver):
        """Find the nodes beside each obstacle."""
        self._solver = solver
        self._panels = [OnFace(solver, self._obstacles, self._ground, *one) for one in self._faces]
        self._of = {id(panels.surface): panels for panels in self._panels}

    def before_obstacle(self, grid, surface):
        """Note the velocities that an obstacle finds."""
        if self._solver.damping_factor == 1.0 and (panels := self._of.get(id(surface))):
            panels.note(grid)

    def after_obstacle(self, grid, surface):
        """Add what it has changed."""
        if self._solver.damping_factor == 1.0 and (panels := self._of.get(id(surface))):
            panels.add(grid)

    def end_step(self, dt):
        """End the intervals that are over."""
        for panels in self._panels:
            panels.follow(self._solver.time + dt)

    def restart(self):
        """Time zero is now."""
        for panels in self._panels:
            panels.restart()

    def take_series(self):
        """Rows since the last call, of each obstacle by its name."""
        return {SERIES: {panels.name: panels.take() for panels in self._panels}}

    def work(self):
        """Nodes that are looked at in a step."""
        return {"step": len(self._panels), "node": sum(panels.n for panels in self._panels)}

    @property
    def bytes(self):
        """Of the tables of nodes."""
        return sum(panels.bytes for panels in self._panels)

    def state(self):
        """Sums and rows of each obstacle, by its name."""
        return {panels.name: panels.state() for panels in self._panels}

    def restore(self, state):
        """Take over what `state()` gave."""
        for panels in self._panels:
            panels.restore(state[panels.name])


class OnFace:
    """Panels of one obstacle: the nodes beside it, what they gave since the last row, and rows."""

    def __init__(self, solver, obstacles, ground, index, spec, interval, source):
        own = obstacles[index]

        def bounds(points, axis):
            return _ends(solver, ground, points, axis)

        self._face = face = Face.of(own.shape, spec, bounds, f"obstacles.{index}.panels.size", source)
        self.name, self._interval, self._dim = own.name, interval, solver.dim
        frame, dx = solver.frame, solver.dx
        self.surface = solver.obstacles[index]
        self._surface_index = solver.surfaces.index(self.surface)
        places, points, normals = self._nodes(own, frame.origin, dx)
        self.n = len(points)
        self._shares = face.shares(points, normals, dx, lambda axis: bounds(points, axis))
        self._around = Around(*(int_array(table) for table in places))
        self._before = real_array(np.zeros(max(1, self.n)))
        self._given = real_array(np.zeros(max(1, self.n)))
        self._direction = real_array(face.direction)
        self._note, self._add = push_kernels(solver.dim, runtime.DTYPES[solver.precision][0], solver.serial)
        self._contact, self._rows = None, int_array([0])
        self.restart()

    def _nodes(self, own, origin, dx):
        """(lower (dim,), shape (dim,), index of each node of the box, -1 of those that are too far), points (n, dim)
        [m] and normals (n, dim) of the others."""
        vertices = own.shape.drawing()[0]
        lower = np.floor((vertices.min(axis=0) - origin) / dx - MARGIN).astype(int)
        upper = np.ceil((vertices.max(axis=0) - origin) / dx + MARGIN).astype(int) + 1
        shape = upper - lower
        if np.prod(shape.astype(float)) > MOST_NODES:
            raise InputError(f"obstacle {own.name}: panels need at most {MOST_NODES:.0e} nodes around it, not"
                             f" {np.prod(shape.astype(float)):.1e}: give a part of it as an obstacle of its own")
        index, points, normals = np.full(np.prod(shape), -1, np.int32), [], []
        sheet = int(np.prod(shape[1:]))
        for k in range(shape[0]):
            rest = np.stack(np.unravel_index(np.arange(sheet), shape[1:]), axis=1)
            x = (np.column_stack([np.full(sheet, k), rest]) + lower) * dx + origin
            distance, normal = own.shape.query(x)
            chosen = np.flatnonzero(np.abs(distance) <= MARGIN * dx)
            index[k * sheet + chosen] = sum(map(len, points)) + np.arange(len(chosen))
            points.append(x[chosen])
            normals.append(normal[chosen])
        return (lower, shape, index), np.concatenate(points), np.concatenate(normals)

    def note(self, grid):
        """Velocities along the push, of nodes that the obstacle may meet."""
        if self._find(grid):
            self._note(self._of(grid), self._around, self._direction, self._before)

    def add(self, grid):
        """What they have lost since then."""
        if self._n_rows:
            self._add(self._of(grid), self._around, self._direction, self._before, self._given)

    def _of(self, grid):
        return Nodes(grid.nodes, grid.contact_offset, grid.contact.coordinates, self._rows, self._n_rows)

    def _find(self, grid):
        """Contact blocks near the obstacle; -> their number."""
        if self._contact is not grid.contact:
            self._contact = grid.contact
            slots = grid.contact.of_surface[self._surface_index]
            rows = grid.contact.index_of[slots != FREE]
            self._n_rows = len(rows)
            self._rows = int_array(rows if len(rows) else [0])
        return self._n_rows

    def follow(self, time):
        """Write a row where an interval ends at `time` [s] or has ended before."""
        self._time = time
        if time >= self._next * (1.0 - 1e-12):
            self._row()
            self._next = self._interval * (np.floor(time / self._interval * (1.0 + 1e-12)) + 1.0)

    def _row(self):
        given = self._given.to_numpy()[: self.n]
        on_panels = self._shares @ given
        span = self._time - self._since
        self._times.append(self._time)
        self._pressures.append(on_panels / (self._face.area * span))
        self._beside.append((given.sum() - on_panels.sum()) / span)
        self._given.fill(0.0)
        self._since = self._time

    def take(self):
        """Rows since the last call, up to now: (about, {name: (values (k, ...), unit)})."""
        if self._time > self._since * (1.0 + 1e-12):
            self._row()
        across, up = self._face.counts
        k = len(self._times)
        rows = {"time": (np.array(self._times), "s"),
                "pressure": (np.array(self._pressures, np.float32).reshape(k, up, across), "Pa"),
                "force_beside": (np.array(self._beside), "N/m" if self._dim == 2 else "N")}
        self._times, self._pressures, self._beside = [], [], []
        return {**self._face.about(), "interval": self._interval}, rows

    def restart(self):
        """Time zero is now."""
        self._n_rows = 0
        self._time = self._since = 0.0
        self._next = self._interval
        self._times, self._pressures, self._beside = [], [], []
        self._given.fill(0.0)

    @property
    def bytes(self):
        """Of the tables of nodes."""
        return 16 * self.n + 4 * self._around.index.shape[0]

    def state(self):
        """All that a continuation needs, by name."""
        across, up = self._face.counts
        return {"given": self._given.to_numpy(), "time": self._time, "since": self._since, "next": self._next,
                "times": np.array(self._times, float), "beside": np.array(self._beside, float),
                "pressures": np.array(self._pressures, float).reshape(-1, across * up)}

    def restore(self, state):
        """Take over what `state()` gave."""
        self._given.from_numpy(np.asarray(state["given"], float))
        self._time, self._since, self._next = (float(state[name]) for name in ("time", "since", "next"))
        self._times, self._beside = state["times"].tolist(), state["beside"].tolist()
        self._pressures = list(state["pressures"])


def _ends(solver, ground, points, axis):
    """Lower and upper end of the snow (n,) [m] along an axis (dim,) through each of points (n, dim): ground, and closed
    sides of the domain that lie across it."""
    along, ends = points @ axis, [np.full(len(points), -np.inf), np.full(len(points), np.inf)]
    if ground is not None and abs(axis[-1]) > STEEP:
        above = np.nan_to_num(ground.height(points[:, :-1]) - points[:, -1], nan=-np.inf)
        ends[0] = along + above * axis[-1]
    for surface in solver.surfaces:
        side = surface.geometry
        if isinstance(side, Plane) and abs(axis[side.axis]) > STEEP:
            left = side.level * solver.dx + solver.frame.origin[side.axis] - points[:, side.axis]
            at, end = along + left * axis[side.axis], 0 if side.sign * axis[side.axis] > 0.0 else 1
            ends[end] = (np.maximum, np.minimum)[end](ends[end], at)
    return ends
