"""What the ground bears of wet columns: those of one phase, and those of grains and of water."""

from snowmpm.compiler import ti
from snowmpm.components.flow_water.bearing import BUOYANT, LIGHTNESS, LOAD, NOW, WATER, effective_stress
from snowmpm.components.flow_water.couple import APART, HEAVY, LEAST_SHARE, LIGHT, LOOSE, NUMBERS, OWN
from snowmpm.components.flow_water.pore_pressure import SIZES, PorePressure
from snowmpm.depth.kernel_api import NODE, ColumnLoad


class OnePhase(ColumnLoad):
    """Of a `one_phase.FlowWater`, whose pressure takes a part of the normal stress off the friction."""

    sizes = SIZES
    mass_column = "water"

    def __init__(self, water):
        self.water = water

    @staticmethod
    def borne(real):
        """`ColumnLoad.borne`: the effective stress."""

        @ti.func
        def of_skeleton(pores: ti.template(), p, own, density, beside, depth, normal, thickness):
            bearing = pores[p][BUOYANT] * normal * thickness
            sigma = effective_stress(pores[p], density * normal * thickness, bearing)
            pores[p][NOW] = bearing
            return ti.Vector([density, density, ti.cast(1.0, real), ti.cast(1.0, real), sigma])

        return of_skeleton

    def densities(self, of_laws):
        """`ColumnLoad.densities`."""
        return of_laws, of_laws + self.water.water

    def fill(self, columns, cells, material):
        """`ColumnLoad.fill`."""
        grid = columns.grid
        drained = grid.flat(self.water.drained(grid.places().reshape(-1, 2)).reshape(grid.shape))
        self.pores = PorePressure(self.water, material, drained[grid.number(*cells.T)], drained, columns.precision)

    @property
    def numbers(self):
        """`bearing`'s."""
        return self.pores.pores

    def take(self, keep):
        """`ColumnLoad.take`."""
        self.pores.take(keep)

    def copied(self, rows):
        """`ColumnLoad.copied`."""
        return self.pores.copied(rows)

    def share(self, material, thickness, time):
        """`ColumnLoad.share`."""
        return self.water.borne(material, thickness, time)

    @property
    def bytes_per_column(self):
        """Of its numbers."""
        return self.pores.bytes_per_column


class TwoPhases(OnePhase):
    """Of a `two_phase.TwoPhaseWater`: the ground feels the mixture around a column."""

    sets = 2
    node_size = NUMBERS
    steep = HEAVY

    @property
    def set_of(self):
        """The second one is that of the water."""
        return self.water.second

    def densities(self, of_laws):
        """`ColumnLoad.densities`: of grains without the pores between them, and of water."""
        return self.water.dry, self.water.dry + self.water.water

    @staticmethod
    def pushed(real):
        """`ColumnLoad.pushed`: h / m follows that around as the phases move apart."""

        @ti.func
        def by_both(pores: ti.template(), p, beside, slope, push):
            light, loose = beside[ti.static(LIGHT - NODE)], beside[ti.static(LOOSE - NODE)]
            lightness = pores[p][LIGHTNESS]
            lightness += (1.0 - ti.exp(-loose)) * (light - lightness)
            if pores[p][LOAD] < 0.0:
                lightness = light
            pores[p][LIGHTNESS] = lightness
            return push + lightness * slope

        return by_both

    @staticmethod
    def borne(real):
        """`ColumnLoad.borne`: dry friction acts on the grains, and drag hands it on."""

        @ti.func
        def of_mixture(pores: ti.template(), p, own, density, beside, depth, normal, thickness):
            alone = beside[ti.static(OWN - NODE)]
            share = ti.min(1.0, ti.max(LEAST_SHARE, alone / ti.max(depth, 1e-30)))
            own_density = density * share
            solid, water = share, density - pores[p][BUOYANT]
            if own > 0:
                solid, water = 1.0 - share, density
            apart = ti.min(1.0, beside[ti.static(APART - NODE)])
            dry_part = 1.0 - apart
            mixed = water + solid * pores[p][BUOYANT]
            if own == 0:
                dry_part += apart * mixed / own_density
            pores[p][WATER] = water / ti.max(LEAST_SHARE, solid)
            sigma = mixed * normal * thickness
            bearing = pores[p][BUOYANT] * normal * thickness
            bearing *= 1.0 - alone / ti.max(depth, 1e-30) if own > 0 else share
            sigma = effective_stress(pores[p], sigma, bearing)
            pores[p][NOW] = bearing
            return ti.Vector([mixed, own_density, share, dry_part, sigma])

        return of_mixture
