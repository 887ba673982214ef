"""Water in the columns of a depth-averaged flow, over each of its steps."""

from snowmpm.compiler.arrays import real_array
from snowmpm.components.flow_water.couple import Mixture, Sizes, couple_kernel, drag_table
from snowmpm.components.flow_water.from_scene import flow_water
from snowmpm.components.flow_water.load import OnePhase, TwoPhases
from snowmpm.components.flow_water.two_phase import TwoPhaseWater
from snowmpm.stepping.component import Adapter


def adapter(model):
    """`WetColumns`, or `MixedColumns`, of a `Model`."""
    return wet_columns(flow_water(model))


def wet_columns(water):
    """Of a `one_phase.FlowWater`, or a `two_phase.TwoPhaseWater`."""
    return MixedColumns(TwoPhases(water)) if isinstance(water, TwoPhaseWater) else WetColumns(OnePhase(water))


class WetColumns(Adapter):
    """Water that moves with the columns of a `DepthSolver`; load: `load.OnePhase`."""

    name = "flow_water"
    scheme = "one_phase"

    def __init__(self, load):
        self.load = load

    def begin(self, solver):
        """Take the solver."""
        self._solver = solver
        solver.particles.constants["water_density"] = self.load.water.density

    def after_gather(self, dt):
        """The pressures go through the step."""
        solver = self._solver
        self.load.pores.consolidate(solver.particles, dt, solver.serial)

    def work(self):
        """Layers of the meshes of all columns."""
        layers = self.load.water.layers * self._solver.particles.count
        return {f"{self.scheme} layer": layers, f"{self.scheme} step": 1}

    def row(self):
        """Mass of water, a fixed share of each column, which has no balance of its own [kg]."""
        store = self._solver.particles
        held = float(store.column("volume")[:, 0] @ store.column("water")[:, 0])
        return {"water_mass": held, "removed_water": store.removed["carried"]}

    def state(self):
        """Pressures."""
        return self.load.pores.state()

    def restore(self, state):
        """Take over what `state()` gave."""
        self.load.pores.restore(state)


class MixedColumns(WetColumns):
    """Grains and water with columns of their own; load: `load.TwoPhases`."""

    scheme = "two_phase"

    def begin(self, solver):
        """Take the solver."""
        super().begin(solver)
        self._drag = real_array(drag_table(self.load.water.drag))

    def after_scatter(self, dt, pushed):
        """Put the phases of the nodes together (`couple`)."""
        solver, grid, water = self._solver, self._solver.grid, self.load.water
        g = -float(solver.gravity[2])
        couple_kernel(solver.real, solver.serial)(
            solver.nodes, self._drag,
            Sizes(grid.n_nodes, grid.n_tiles, *grid.tiles.tolist()[1:], *grid.shape.tolist()),
            Mixture(water.grain_density, water.density, g, grid.dx, solver.unit / grid.dx**2, dt,
                    solver.options.damping))
