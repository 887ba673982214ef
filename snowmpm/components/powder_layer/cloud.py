"""The powder layer in its cells: what it holds, its step, and its balances."""

import math
from typing import Any

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.compiler.parallel import runs_serially
from snowmpm.components.powder_layer import arrays, closures
from snowmpm.components.powder_layer.exchange import exchange_kernel
from snowmpm.components.powder_layer.kernels import kernels
from snowmpm.depth.kernel_api import MARGIN, TILE, WALLS

STRANGE = "a powder layer that is none of this scene"
"""What is wrong with a checkpoint."""
CFL = 0.45
"""Sum over both axes of what signals cross of a cell in a step; from 1/2 on volume and ice may fall below 0."""
LOOK = 4
"""Steps between two looks for live tiles: a cloud gets two cells on in one, and a tile has eight."""
EXCHANGE = 0.05
"""Longest part of a step between two exchanges [s]: what rises falls out a part later, and the cloud holds 4 % too much
ice (atlas: dusty_step)."""
CELL_STEP = 200e-9
"""Time of a step [s] a cell on one thread."""

SUMS = ("air", "dispersed", "left_air", "added", "suspended", "settled", "laid", "cover", "left_ice", "work", "lift")
"""Totals since time zero: volumes of air that was taken in, given back, and left [m3]; volume that kept cells from
running below empty [m3]; ice that came from the flow, went back to it, went to the ground, came from the snow cover,
and left [kg]; kinetic and potential energy that the flow got [J]."""
PASSED = {"suspended": arrays.UP, "settled": arrays.DOWN, "laid": arrays.LAID, "work": arrays.WORK, "lift": arrays.LIFT,
          "dispersed": arrays.DISPERSED, "cover": arrays.COVER}
"""Those of an exchange, by the number of its report."""
IMPULSES = ("pull", "faces", "drag", "core", "ground")
"""Momentum (3) since time zero [N s] that the cloud got by weight, by pressure of the ground and sides, by drag of
ground and air; that the flow got of it; that went to the ground with what settled."""


class PowderCloud:
    """A cloud over the cells of a plan grid. state (nx + 2 MARGIN, ny + 2 MARGIN, 4): V [m], I [m], M [kg/m/s]; laid
    and cover (...): ice on the ground, and snow cover that may be taken up [kg/m2 in plan]; peaks (..., 5): of
    `arrays.PEAKS` so far; sums, impulses: SUMS and IMPULSES by name."""

    longest = EXCHANGE
    """Part of a step between two exchanges, at most [s]."""

    def __init__(self, below, grid, sides, holes, g, options):
        """below: `arrays.Below`; grid: `depth.plan_grid.PlanGrid`; sides (2, 2): names of what stands at its ends;
        holes (nx, ny): cells without ground; g [m/s2]; options: `declare.PowderLayer`."""
        self.below, self.grid, self.sides, self.g, self.options = below, grid, sides, float(g), options
        self._real = runtime.DTYPES["f64" if below.state.dtype == np.float64 else "f32"][0]
        nx, ny = self.shape = tuple(int(n) + 2 * MARGIN for n in grid.shape)
        n = nx * ny
        self.state, self.peaks = np.zeros((nx, ny, arrays.STATE)), np.zeros((nx, ny, arrays.PEAKS))
        self.laid, own = np.zeros((nx, ny)), np.zeros((nx, ny), np.int32)
        own[MARGIN:-MARGIN, MARGIN:-MARGIN] = ~holes
        self.cover = np.divide(options.cover_load, below.ground[..., 5], out=np.zeros((nx, ny)), where=own > 0)
        self._own, self._image = own > 0, self._images()
        self._first, self._slopes, self._flux = (np.zeros((n, size)) for size in (
            arrays.STATE, arrays.SLOPES, 2 * arrays.FLUX))
        self._cells = arrays.Cloud(self.state.reshape(n, -1), self._first, self._slopes,
                                   self._flux.reshape(n, 2, arrays.FLUX), self.peaks.reshape(n, -1), self.laid.ravel(),
                                   self.cover.ravel(),
                                   own.ravel())
        rows = -(-ny // TILE)
        live = np.zeros(-(-nx // TILE) * rows, np.int32)
        self._tiles, self._live = arrays.Tiles(live, len(live), rows, nx, ny), live.reshape(-1, rows)
        self._passing, self._report = (np.zeros((len(live), size)) for size in (arrays.PASSING, arrays.REPORT))
        self.numbers = numbers_of(options, self.g)
        self._serial = runs_serially(CELL_STEP * int(np.count_nonzero(below.state[..., 0])))
        self.restart()

    def _images(self):
        """Cells (nx, ny) beyond walls and periodic sides, which are images of others."""
        found = np.zeros(self.shape, bool)
        for axis in (0, 1):
            for end, part in ((0, slice(0, MARGIN)), (1, slice(-MARGIN, None))):
                if self.sides[axis][end] in (*WALLS, "periodic"):
                    np.moveaxis(found, axis, 0)[part] = True
        return found

    def restart(self):
        """Time zero is now."""
        self._slopes_before = self.below.ground[..., :2].copy()
        self.sums: dict[str, float] = dict.fromkeys(SUMS, 0.0)
        self.impulses: dict[str, Any] = {name: np.zeros(3) for name in IMPULSES}
        self._start = {"air": self.air, "ice": self.ice_mass, "momentum": self.momentum()}

    @property
    def inner(self):
        """State of the cells within the sides (nx, ny, 4)."""
        return self.state[MARGIN:-MARGIN, MARGIN:-MARGIN]

    @property
    def area(self):
        """Of a cell in plan [m2]."""
        return self.grid.dx**2

    @property
    def air(self):
        """Volume of air in the cloud [m3]."""
        return float((self.inner[..., 0] - self.inner[..., 1]).sum()) * self.area

    @property
    def ice_mass(self):
        """[kg]"""
        return float(self.inner[..., 1].sum()) * self.area * closures.ICE_DENSITY

    def momentum(self):
        """In space (3,) [kg m/s]."""
        M, s = self.inner[..., 2:], self.below.ground[MARGIN:-MARGIN, MARGIN:-MARGIN, :2].astype(float)
        return self.area * np.append(M.sum(axis=(0, 1)), (M * s).sum())

    def ice_momentum(self):
        """Sum over the cells of the size of the momentum of the ice in plan [kg m/s]."""
        V, ice = self.inner[..., 0], self.inner[..., 1]
        weight = self.numbers.air * V + self.numbers.cu * self.numbers.excess * ice
        share = np.divide(self.numbers.ice * ice, weight, out=np.zeros_like(V), where=V > 0.0)
        return self.area * float((share * np.hypot(self.inner[..., 2], self.inner[..., 3])).sum())

    # ---- the step ---------------------------------------------------------------------------------------------

    def advance(self, dt):
        """What the layers exchange in a step of the flow of dt [s], in parts of `longest` at most, and after each part
        the cloud by steps of its own; -> whether the flow changed."""
        self._follow_ground()
        changed, parts = False, max(1, math.ceil(dt / self.longest * (1.0 - 1e-9)))
        for _ in range(parts):
            self.wake()
            with runtime.precision("f64"):
                changed |= self._exchange(dt / parts)
            self.move(dt / parts, float(self._passing[:, arrays.FASTEST].max()))
        return changed

    def _follow_ground(self):
        """Where the ground has turned since the last step, the cloud turns with it, and the ground gives the momentum
        that this takes."""
        slopes = self.below.ground[..., :2]
        if not np.array_equal(slopes, self._slopes_before):
            inner = np.s_[MARGIN:-MARGIN, MARGIN:-MARGIN]
            turned = slopes[inner].astype(float) - self._slopes_before[inner]
            self.impulses["faces"] = self.impulses["faces"] + np.array(
                [0.0, 0.0, self.area * float((self.inner[..., 2:] * turned).sum())])
            self._slopes_before = slopes.copy()

    def move(self, dt, rate):
        """The cloud by itself for dt [s], in steps of CFL. rate: sum over both axes of its signals over dx [1/s], 0
        where there is none."""
        launch, left, count = kernels(self.options.air_entrainment, self._serial), dt, 0
        with runtime.precision("f64"):
            while rate > 0.0 and left > 0.0:
                number = max(1, math.ceil(left * rate / CFL * (1.0 - 1e-9)))
                part = left / number
                if count % LOOK == 0:
                    self.wake(False)
                rate, left, count = self._step(launch, part), left - part if number > 1 else 0.0, count + 1

    def _exchange(self, dt):
        options = self.options
        self._passing[:] = 0.0
        exchange_kernel(self._real, options.suspension, options.bed_concentration, self._serial)(
            self._cells, self.below, self._tiles, self.numbers, arrays.Step(dt, self.grid.dx, self.g, 0), self._passing)
        found = self._passing.sum(axis=0) * self.area
        for name, at in PASSED.items():
            self.sums[name] += float(found[at])
        self.sums["laid"] += float(found[arrays.DUST])
        for name, at in (("core", arrays.TO_CORE), ("ground", arrays.TO_GROUND)):
            self.impulses[name] = self.impulses[name] + found[at : at + 3]
        return bool(found[[arrays.UP, arrays.DOWN]].any() or found[arrays.TO_CORE : arrays.TO_CORE + 3].any())

    def _step(self, launch, dt):
        """A step of dt [s] of the cloud by itself; -> sum of its signals over dx [1/s]."""
        self._report[:] = 0.0
        for stage in (0, 1):
            step = arrays.Step(dt, self.grid.dx, self.g, stage)
            self._fill()
            if stage == 0:
                self._first[:] = self._cells.state
            launch.slope(self._cells, self.below, self._tiles, self.numbers)
            launch.cross(self._cells, self.below, self._tiles, self.numbers, step)
            launch.advance(self._cells, self.below, self._tiles, self.numbers, step, self._report)
        self._lose()
        found = self._report.sum(axis=0) * self.area
        self.sums["air"] += float(found[arrays.AIR])
        self.sums["added"] += float(found[arrays.ADDED])
        for name, at in (("pull", arrays.PULL), ("faces", arrays.FACES), ("drag", arrays.DRAG)):
            self.impulses[name] = self.impulses[name] + found[at : at + 3]
        return float(self._report[:, arrays.RATE].max())

    def _fill(self):
        """Cells beyond walls, the mirror image, and beyond periodic sides, the other end."""
        for axis in (0, 1):
            view, n = np.moveaxis(self.state, axis, 0), int(self.grid.shape[axis])
            for end in (0, 1):
                beyond = slice(0, MARGIN) if end == 0 else slice(n + MARGIN, None)
                if self.sides[axis][end] == "periodic":
                    view[beyond] = view[n : n + MARGIN] if end == 0 else view[MARGIN : 2 * MARGIN]
                elif self.sides[axis][end] in WALLS:
                    view[beyond] = (view[MARGIN : 2 * MARGIN] if end == 0 else view[n : n + MARGIN])[::-1]
                    view[beyond, ..., 2 + axis] *= -1.0

    def wake(self, flow=True):
        """Look which tiles hold cloud, or flow where that counts, or have it next to them. Fluxes of others are 0."""
        self._fill()
        held = np.zeros((self._live.shape[0] * TILE, self._live.shape[1] * TILE), bool)
        held[: self.shape[0], : self.shape[1]] = (self.state[..., 0] > 0.0) | (flow & (self.below.state[..., 0] > 0.0))
        wide = np.pad(held.reshape(self._live.shape[0], TILE, -1, TILE).any(axis=(1, 3)), 1)
        rows, columns = self._live.shape
        near = np.any([wide[i : i + rows, j : j + columns] for i in range(3) for j in range(3)], axis=0)
        for array in (self._flux, self._slopes):
            cells = array.reshape(*self.shape, -1)
            for i, j in np.argwhere((self._live > 0) & ~near):
                cells[i * TILE : (i + 1) * TILE, j * TILE : (j + 1) * TILE] = 0.0
        self._live[:] = near

    @property
    def live_cells(self):
        """Cells that a step looks at."""
        return int(self._live.sum()) * TILE**2

    def _lose(self):
        """What left over an open side, or came to cells without ground, is gone."""
        lost = ~self._own & ((self.state[..., 0] > 0.0) | (self.state[..., 1] > 0.0))
        if lost.any():
            gone = self.state[lost & ~self._image]
            self.sums["left_air"] += float((gone[:, 0] - gone[:, 1]).sum()) * self.area
            self.sums["left_ice"] += float(gone[:, 1].sum()) * self.area * closures.ICE_DENSITY
            self.state[lost] = 0.0

    # ---- balances ---------------------------------------------------------------------------------------------

    def residuals(self):
        """What is left open of the balances of ice, air and momentum, each over its largest term."""
        sums, impulses, start = self.sums, self.impulses, self._start
        ice = [self.ice_mass, -start["ice"], -sums["suspended"], -sums["cover"], sums["settled"], sums["laid"],
               sums["left_ice"]]
        air = [self.air, -start["air"], -sums["air"], sums["dispersed"], sums["left_air"]]
        momentum = [self.momentum(), -start["momentum"], -impulses["pull"], -impulses["faces"], -impulses["drag"],
                    impulses["core"], impulses["ground"]]
        sizes = [max(map(abs, terms)) for terms in (ice, air)] + [max(np.linalg.norm(term) for term in momentum)]
        left = abs(sum(ice)), abs(sum(air)), float(np.linalg.norm(np.sum(momentum, axis=0)))
        return tuple(one / size if size > 0.0 else 0.0 for one, size in zip(left, sizes, strict=True))

    def to_dict(self):
        """All that changes, by name."""
        return {"state": self.state.copy(), "laid": self.laid.copy(), "cover": self.cover.copy(),
                "peaks": self.peaks.copy(), "sums": {**self.sums},
                "impulses": {name: one.copy() for name, one in self.impulses.items()},
                "start_air": self._start["air"], "start_ice": self._start["ice"],
                "start_momentum": self._start["momentum"].copy(), "slopes": self._slopes_before.copy()}

    def take(self, found):
        """Take over a `to_dict()`. Raises ValueError for one that no cloud of this scene leaves."""
        own = {"state": self.state, "laid": self.laid, "cover": self.cover, "peaks": self.peaks}
        taken = {name: numbers_from(found[name], array.shape) for name, array in own.items()}
        state = taken["state"]
        if any((one < 0.0).any() for one in (state[..., :2], *(taken[name] for name in ("laid", "cover", "peaks")))):
            raise ValueError(STRANGE)
        # profiles carry ice faster than volume, so that only uniform ones keep their share below 1
        too_much = self.numbers.cu == 1.0 and (state[..., 1] > state[..., 0] * (1.0 + 1e-6) + 1e-9).any()
        if too_much or (state[~self._own & ~self._image] != 0.0).any():
            raise ValueError(STRANGE)
        sums = {name: numbers_from(found["sums"][name], ()) for name in SUMS}
        impulses = {name: numbers_from(found["impulses"][name], (3,)) for name in IMPULSES}
        start = {name: numbers_from(found[f"start_{name}"], (3,) if name == "momentum" else ()) for name in self._start}
        slopes = numbers_from(found["slopes"], self._slopes_before.shape)
        for name, array in own.items():
            array[:] = taken[name]
        self.sums, self.impulses, self._start = sums, impulses, start
        self._slopes_before = slopes.astype(self._slopes_before.dtype)


def numbers_from(found, shape):
    """Finite real numbers of this shape, one as a float; else ValueError."""
    found = np.asarray(found)
    if found.shape != shape or found.dtype.kind != "f" or not np.isfinite(found).all():
        raise ValueError(STRANGE)
    return found.astype(float) if shape else float(found)


def numbers_of(options, g=9.81):
    """`arrays.Numbers` of a table `declare.PowderLayer`."""
    rate = options.suspension_rate
    fall = closures.fall_speed(options.grain_diameter, g) if options.fall_speed is None else options.fall_speed
    return arrays.Numbers(
        closures.AIR_DENSITY, closures.ICE_DENSITY - closures.AIR_DENSITY, closures.ICE_DENSITY,
        *closures.SHAPE[options.profile], options.ground_drag, options.core_drag, options.top_drag, options.front_drag,
        fall, closures.USUAL_RATE[options.suspension] if rate is None else rate, options.suspension_stress,
        options.cover_rate, options.cover_stress)
