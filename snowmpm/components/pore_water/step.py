"""Water in the pores of the particles of explicit MPM, over each of its steps.

    before the step   tau <- tau - J p I     (total stress = effective stress - pore pressure, Kirchhoff)
    after the step    tau is again that of the law; porosity n = 1 - s / J; water flows (`flow`), p follows

s: volume of the grains per reference volume, constant since they are incompressible (Nøst 2019, 7.6). Mass of a
particle: V_0 (rho_dry + w), w the water per reference volume, which is state and changes by fluxes alone. Within a
cell, water spreads over the pores of its particles. Each cell then has one pressure, and particles carry it into the
next cell with exactly their share of the water.

The momentum equation is explicit, with the pressure of the last step; the pressure is implicit, at the deformation of
the step (the drained split of Kim 2010, one pass, with the skeleton's volume change known). Alone this is stable below
the undrained step only, which K_w sets. With the flux b grad (p' - p) in the mass balance (`flow`), a mode of the
skeleton of frequency w, with storage c, drainage d and b l of a step, whose volume the pressure moves with l, is stable
while

    dt² w² + dt² l / (c + d / 2 + b l) < 4,    dt² l / (...) <= 1 / s

(l is at most that of the two-point operator). So 1 / s is all that water takes of the margin of the drained step,
whatever compressibility and permeability are: s = s_0 / (1 - (dt / dt_c)²), dt_c the critical drained step. b smooths
changes over s^(1/2) c dt, less than a cell, and vanishes where flow is steady. This is the incremental projection of
Guermond, Minev and Shen 2006, doi:10.1016/j.cma.2005.10.010, a step late; Kularathna et al. 2021, doi:10.1002/nag.3207,
project within the step.
"""

import numpy as np

from snowmpm.annotations import derived
from snowmpm.compiler import runtime
from snowmpm.components.pore_water.flow import seep
from snowmpm.components.pore_water.outlets import SURFACE
from snowmpm.particles.blocks import EDGE
from snowmpm.water.adapter import WaterAdapter
from snowmpm.water.budget import Budget
from snowmpm.water.cells import MaterialCells
from snowmpm.water.particle_kernels import MASS, N_WATER, PRESSURE, RATIO, SOLID, YIELDED, read_columns, water_kernels

LONGEST = 0.95
"""Largest dt / dt_c that s follows."""

SOAKED_SHARE = 0.5
"""The C of the elastic limit over the critical one, of a scene that gives none: the errors of the coupling grow with
the square of the step and with 1 / (1 - share²), 11 times from here to `stepping.time_step.USUAL_SHARE`."""

WETNESS = "liquid_water"
"""Name of the state variable of laws that depend on the volume share of water."""

LEAST_POROSITY = 1e-3
"""Of snow pressed to ice, for which grains are no longer incompressible."""


class FilledPores(WaterAdapter):
    """fluid: `flow.Fluid`; permeability: function (places (cells, dim) [m], porosity (cells,)) -> K [m2]; outlets:
    `Outlets`."""

    name = "pore_water"

    def __init__(self, fluid, permeability, outlets):
        super().__init__()
        self.fluid, self.permeability, self.outlets = fluid, permeability, outlets

    @derived
    def density(self):
        """Of water [kg/m3]."""
        return self.fluid.density

    def first_rows(self, porosity, ratio, pressure, saturation):
        """Rows (n, N_WATER) that particles start with; porosity: at J = 1; ratio: J; saturation of those whose
        pressure is the floor."""
        solid = 1.0 - np.asarray(porosity, float)
        pores = np.maximum(ratio - solid, LEAST_POROSITY * ratio)
        fluid, rows = self.fluid, np.zeros((len(solid), N_WATER))
        held = fluid.content(np.asarray(pressure, float), pores)
        if fluid.suction is not None:
            partial = saturation < 1.0
            held = np.where(partial, saturation * fluid.content(-fluid.suction, pores), held)
            pressure = np.where(partial, -fluid.suction, np.maximum(pressure, -fluid.suction))
        rows[:, MASS], rows[:, PRESSURE] = fluid.density * held, pressure
        rows[:, SOLID], rows[:, RATIO] = solid, ratio
        return rows

    def begin(self, solver):
        """Take the solver, at time zero."""
        super().begin(solver)
        self.restart()

    def restart(self):
        """Time zero is now."""
        solver = self._solver
        water = solver.particles.column("water")
        names = [[variable.name for variable in law.STATE] for law in solver.particles.materials.laws]
        self._state_of = np.array([own.index(WETNESS) if WETNESS in own else -1 for own in names], np.int32)
        self.budget = Budget(start=float(solver.particles.column("volume")[:, 0] @ water[:, MASS]))
        with runtime.precision(solver.precision):
            self._moisten(solver, water)

    def _moisten(self, solver, water):
        """Tell laws that depend on it how much liquid water there is."""
        store = solver.particles
        if (self._state_of >= 0).any() and store.count:
            content = water[:, MASS] / self.fluid.density / store.column("volume_ratio")[:, 0]
            self._kernels(solver).moisten(store.reals, store.slot_offset, store.material, self._state_of,
                                          np.ascontiguousarray(content), store.count)

    @staticmethod
    def _kernels(solver):
        return water_kernels(solver.particles.layout, runtime.DTYPES[solver.precision][0])

    def work(self):
        """Particles."""
        return {"particle": self._solver.particles.count, "step": 1}

    def state(self):
        """All that a bitwise continuation needs beside the particles, by name."""
        return {**super().state(), "drained": dict(self.outlets.drained)}

    def restore(self, state):
        """Take over what `state()` gave."""
        super().restore(state)
        self.outlets.drained.update(state["drained"])


class PoreWater(FilledPores):
    """`FilledPores` of an `MpmSolver`.

    share: s_0 above, 0 for steps below the undrained one; shorten: whether to keep the steps to `SOAKED_SHARE` of the
    critical one, of a scene that gives no C."""

    def __init__(self, fluid, permeability, outlets, share, shorten=True):
        super().__init__(fluid, permeability, outlets)
        self.share, self._shorten = share, shorten
        self.rounds = 0
        self._coordinates = None

    def begin(self, solver):
        """Take the solver, at time zero."""
        if self._shorten:
            solver.shorten_steps(SOAKED_SHARE)
        super().begin(solver)

    def restart(self):
        """Time zero is now."""
        super().restart()
        self._note(self._solver, self._solver.particles.column("water"))

    def _note(self, solver, water):
        """Keep what the choice of the next step needs: the wave speed of undrained snow."""
        fluid = self.fluid
        self.wave_speed = 0.0
        if self.share > 0.0 or not len(water):
            return
        porosity = np.maximum(1.0 - water[:, SOLID] / water[:, RATIO], LEAST_POROSITY)
        least = solver.materials.density.min()
        # A lone grain swells along all axes at once (`time_step`)
        stiffness = solver.dim * fluid.bulk_modulus / porosity / (least + water[:, MASS])
        self.wave_speed = float(np.sqrt(solver.materials.fastest_wave**2 + stiffness.max()))

    # ---- the step -------------------------------------------------------------------------------------------------

    def before_step(self, dt, pushed):
        """Before the forces of a step."""
        solver, store = self._solver, self._solver.particles
        self._kernels(solver).pressurise(store.reals, store.slot_offset, store.count)
        store.changes += 1
        return pushed

    def end_step(self, dt):
        """After a step of dt [s]: what the pressure did, and where the water went."""
        with runtime.precision(self._solver.precision):
            self._flow(self._solver, dt)

    def _flow(self, solver, dt):
        store, frame = solver.particles, solver.frame
        if store.count == 0:
            return
        columns, width = read_columns(solver.dim)
        rows = np.empty((store.count, width))
        self._kernels(solver).read(store.reals, store.slot_offset, rows, store.count)
        volume, ratio, water = rows[:, columns["volume"]], rows[:, columns["ratio"]], rows[:, columns["water"]]
        cells, codes = self._material_cells(solver, rows[:, columns["position"]])
        pores = volume * np.maximum(ratio - water[:, SOLID], LEAST_POROSITY * ratio)
        self.budget.work += float((volume * water[:, PRESSURE]) @ (ratio - water[:, RATIO]))
        if solver.damping_factor < 1.0:  # pressures hold while an initial state settles
            self._hold(solver, water, volume, pores, ratio)
            return
        mass = volume * water[:, MASS]
        in_pores, held = cells.sums(pores), cells.sums(mass) / self.fluid.density
        bulk = cells.sums(volume * ratio)
        dry = store.materials.density[store.material.to_numpy()[: store.count]]
        rain = self._rain(cells, codes, frame, dt)
        self.budget.added += self.fluid.density * float(rain.sum())
        places = frame.origin + frame.dx * (cells.coordinates + 0.5)
        done = seep(cells, frame.dx, self.fluid, dt, water=held + rain, pores=in_pores,
                    before=cells.mean(water[:, PRESSURE], pores), drained=self.outlets.open(codes),
                    permeability=self.permeability(places, in_pores / bulk), gravity=solver.gravity,
                    density=cells.sums(volume * dry + mass) / bulk, share=self._share_of(solver, dt),
                    free=self.outlets.free(codes), yielded=cells.sums(volume * water[:, YIELDED]))
        self.rounds = done.rounds
        self.budget.drained += self.fluid.density * float(done.out.sum())
        new = (self.fluid.density * done.water / in_pores)[cells.of] * pores
        self._carry(solver, rows, columns, new - mass)
        water[:, MASS], water[:, PRESSURE], water[:, RATIO] = new / volume, done.pressure[cells.of], ratio
        water[:, YIELDED] = (done.yielded / in_pores)[cells.of] * pores / volume
        store.mass = float(volume @ dry + new.sum())
        self._write(solver, water)

    def _share_of(self, solver, dt):
        """s of a step of dt [s]."""
        if self.share == 0.0:
            return 0.0
        ratio = min(dt / solver.critical_elastic_dt(), LONGEST)
        return self.share / (1.0 - ratio**2)

    def _carry(self, solver, rows, columns, gained):
        """Book momentum and energy of the water (n,) [kg] that particles gained."""
        v, x = rows[:, columns["velocity"]], solver.particles.positions(rows[:, columns["position"]])
        solver.add_impulse(gained @ v)
        square = (v**2).sum(axis=1) + solver.second_moment() * rows[:, columns["affine2"]]
        falling = np.where(solver.particles.repeats, 0.0, solver.gravity)
        self.budget.carried_energy += float(gained @ (0.5 * square - x @ falling))
        self.budget.carried_mass += float(gained.sum())

    def _hold(self, solver, water, volume, pores, ratio):
        fluid = self.fluid
        full = np.ones(len(water), bool) if fluid.suction is None else water[:, PRESSURE] > -fluid.suction
        filled = fluid.density * fluid.content(water[:, PRESSURE], pores) / volume
        water[:, MASS], water[:, RATIO], water[:, YIELDED] = np.where(full, filled, water[:, MASS]), ratio, 0.0
        self._write(solver, water)
        solver.particles.mass = float(solver.particles.masses().sum())

    def _write(self, solver, water):
        store = solver.particles
        self._kernels(solver).write(store.reals, store.slot_offset, np.ascontiguousarray(water), store.count)
        store.changes += 1
        self._moisten(solver, water)
        self._note(solver, water)

    def _material_cells(self, solver, local):
        """Cells of the particles and the codes of their border faces, made anew only where they changed."""
        store, blocks = solver.particles, solver.particles.blocks
        corner = EDGE[solver.dim] * np.repeat(blocks.coordinates, np.diff(blocks.start), axis=0)
        coordinates = np.floor(local).astype(np.int64) + corner
        same = self._coordinates is not None and np.array_equal(coordinates, self._coordinates)
        if not same:
            self._coordinates, self._cells = coordinates, MaterialCells(coordinates, store.period)
        if not same or self.outlets.moving:
            self._codes = self.outlets.codes(self._cells, solver.frame, solver.time)
        return self._cells, self._codes

    def _rain(self, cells, codes, frame, dt):
        """Volume (cells,) [m3] that rain adds in dt to the highest cell of each column under the sky."""
        added, up = np.zeros(len(cells)), cells.coordinates.shape[1] - 1
        if not self.rain:
            return added
        top = cells.border[(cells.border_axis == up) & (cells.border_sign > 0) & (codes == SURFACE)]
        plan = cells.coordinates[top, :up]
        _, last = np.unique(plan[::-1], axis=0, return_index=True)  # rows of a column grow upwards
        top = top[len(top) - 1 - last]
        places = frame.origin[:up] + frame.dx * (cells.coordinates[top, :up] + 0.5)
        for rate, inside in self.rain.values():
            added[top] += dt * rate / self.fluid.density * frame.dx**up * inside(places)
        return added

    # ---- checkpoint -----------------------------------------------------------------------------------------------

    def restore(self, state):
        """Take over what `state()` gave."""
        super().restore(state)
        self._coordinates = None
        self._note(self._solver, self._solver.particles.column("water"))
