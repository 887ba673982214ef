"""The powder layer above a flow by finite volumes. After each step of the flow it exchanges with it and moves on."""

import numpy as np

from snowmpm.components.powder_layer.arrays import Below
from snowmpm.components.powder_layer.cloud import PowderCloud, numbers_from
from snowmpm.depth.kernel_api import MARGIN
from snowmpm.errors import SimulationError
from snowmpm.quantities.classes import PRESSURES
from snowmpm.quantities.powder import EXPERIMENT, HISTORY
from snowmpm.stepping.component import Adapter

MAPS = {"cloud_peak_height_experiment": ("m", 0), "cloud_peak_pressure_experiment": ("Pa", 1),
        "cloud_peak_foot_pressure_experiment": ("Pa", 2), "cloud_peak_speed_experiment": ("m/s", 3)}
"""Maps: unit, and which of `arrays.PEAKS` it is."""
MOVES = 0.01
"""Share of the largest momentum of its ice down to which the cloud moves: the air goes on for minutes."""

UNITS = {one.name: one.unit for one in HISTORY}
"""Of its columns of the history."""


def adapter(model):
    """`PowderLayerInCells` of the scene of a `Model`."""
    return PowderLayerInCells(model.scene.powder_layer)


class PowderLayerInCells(Adapter):
    """A cloud above the snow of a `VolumeSolver`. options: `declare.PowderLayer`; cloud: `PowderCloud`."""

    name = "powder_layer"

    def __init__(self, options):
        self._options = options
        self._most = 0.0

    def begin(self, solver):
        """Lay its cells over those of the flow."""
        self._solver, store = solver, solver.particles
        below = Below(store.state_array, store.ground, solver.heights, float(store.density))
        self.cloud = PowderCloud(below, solver.grid, solver.sides, solver.bed.holes, -float(solver.gravity[2]),
                                 self._options)
        self.cloud.wake()

    def restart(self):
        """Time zero is now."""
        self.cloud.restart()

    def end_step(self, dt):
        """Exchange with the flow, and move on."""
        self.changes_mass = self.cloud.advance(dt)
        momentum = self.cloud.ice_momentum()
        if not np.isfinite(momentum + self.cloud.inner.sum()):
            i, j = np.argwhere(~np.isfinite(self.cloud.inner).all(axis=2))[0]
            raise SimulationError(f"powder layer: cell ({i}, {j}) has no finite height or velocity, at t ="
                                  f" {self._solver.time:.6g} s, step {self._solver.steps}:\nlower solver.cfl, or check"
                                  " the numbers of powder_layer")
        self._most = max(self._most, momentum)
        if self.changes_mass:
            self._solver.particles.changed()

    def to_come(self, time):
        """Whether the cloud still moves: it may do so where the flow has stopped."""
        return self.cloud.ice_momentum() > MOVES * self._most

    def given(self, lift):
        """Energy that the flow got of the cloud; negative, since it loses snow and speed to it."""
        sums = self.cloud.sums
        return {"cloud_energy": sums["work"] + sums["lift"] + (sums["settled"] - sums["suspended"]) * lift}

    def impulses(self):
        """That which the flow got of the cloud."""
        return [self.cloud.impulses["core"]]

    def row(self):
        """Its columns of the history."""
        cloud, sums = self.cloud, self.cloud.sums
        momentum, residuals = cloud.momentum(), cloud.residuals()
        masses = (sums["suspended"], sums["settled"], sums["laid"], sums["cover"], sums["left_ice"],
                  cloud.ice_mass)
        values = (*masses, cloud.air, sums["air"], float(np.linalg.norm(momentum)), *momentum.tolist(), *residuals)
        return dict(zip((name for name in UNITS if name != "cloud_energy"), values, strict=True))

    def units(self):
        """Their units."""
        return UNITS

    def maps(self, grid):
        """Peaks so far over the cells of a map: the largest of the cells whose middles lie in it, and of that in which
        its own middle lies; NaN without."""
        plan, peaks = self._solver.grid, self.cloud.peaks[MARGIN:-MARGIN, MARGIN:-MARGIN]
        i, j = np.moveaxis(np.floor((plan.places() - grid.lower) / grid.cell).astype(int), -1, 0)
        held = (peaks[..., 0] > 0.0) & (i >= 0) & (i < grid.shape[0]) & (j >= 0) & (j < grid.shape[1])
        middles = np.stack(np.meshgrid(*(low + (np.arange(n) + 0.5) * grid.cell for low, n in zip(
            grid.lower, grid.shape, strict=True)), indexing="ij"), axis=-1)
        at = np.floor((middles - plan.places()[0, 0] + 0.5 * plan.dx) / plan.dx).astype(int)
        inside = ((at >= 0) & (at < plan.shape)).all(axis=-1)
        under = np.zeros(grid.shape, bool)
        under[inside] = peaks[tuple(at[inside].T)][:, 0] > 0.0
        at = tuple(at[under].T)
        found = {}
        for name, (unit, k) in MAPS.items():
            values = np.full(grid.shape, np.nan)
            np.fmax.at(values, (i[held], j[held]), peaks[held][:, k])
            values[under] = np.fmax(values[under], peaks[at][:, k])
            found[name] = values, unit
        return found

    def choices(self):
        """Its keys: words as they are, numbers with their names."""
        words = [value if isinstance(value, str) else f"{name.replace('_', ' ')} {value:g}"
                 for name, value in self._options.model_dump(exclude_none=True).items()]
        return {"powder layer": f"an experiment; {', '.join(words)}"}

    def numbers(self, grid):
        """Largest values of its maps, and areas by pressure."""
        maps = {name: np.nan_to_num(values) for name, (values, _) in self.maps(grid).items()}
        found = {f"largest_cloud_{one}{EXPERIMENT}": float(maps[f"cloud_peak_{one}{EXPERIMENT}"].max())
                 for one in ("height", "pressure", "speed")}
        found[f"largest_cloud_density{EXPERIMENT}"] = float(self.cloud.peaks[..., 4].max())
        pressure = maps[f"cloud_peak_pressure{EXPERIMENT}"]
        return found | {f"cloud_area_above_{p / 1e3:g}_kPa{EXPERIMENT}": float((pressure >= p).sum()) * grid.cell**2
                        for p in PRESSURES}

    def apart(self):
        """Ice in the cloud and on the ground, but for that of the snow cover; ice that left."""
        sums = self.cloud.sums
        return self.cloud.ice_mass + sums["laid"] - sums["cover"], sums["left_ice"]

    def work(self):
        """Cells that a step looks at."""
        return {"step": 1, "cell": self.cloud.live_cells}

    @property
    def bytes(self):
        """Of its cells."""
        return 8 * 39 * self.cloud.laid.size

    def state(self):
        """The cloud."""
        return {**self.cloud.to_dict(), "most": self._most}

    def restore(self, state):
        """Take over what `state()` gave. Raises ValueError for a cloud that no run leaves."""
        self.cloud.take(state)
        self._most = numbers_from(state["most"], ())
