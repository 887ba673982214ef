"""One change of volume (F-bar), or of volume and shape, for all particles of a cell in explicit steps.

Against volumetric locking, as in steps that are solved for (`.implicit`), with the cells between the knots of the
spline:

    f_bar = (j_bar / j)^(1/dim) f,    j_bar = sum_p v_p j_p / sum_p v_p,    j = det f,  f = I + dt grad v

v_p is the volume at the start of the step. Laws, and the volume of a particle, follow f_bar. Forces stay those of each
particle's stress: where the particles of a cell have the same pressure, as they have when they have changed their
volumes alike, these are the forces of the mean. Coombs et al. 2018, doi:10.1016/j.cma.2018.01.010.

Particles that come from another cell bring another pressure, and since all change their volumes alike, nothing would
ever even it out: in flow, pressures of one cell part until they throw particles about. So a particle has in each step

    j_bar + RELAXED (e_bar - e),    e = tr tau / 3K,    e_bar = sum_p v_p e_p / sum_p v_p

for j_bar, e its elastic change of volume: differences fade in 1 / RELAXED steps, and the volume of the cell stays.

With f_bar = "whole" the particles of a cell share the mean of grad v, weighted by volume, in the cells between nodes.
The quadratic spline spreads an opening between two rows of nodes as a hat over two cells: two particles an axis have
3/4 of it in the cell and 1/4 in each neighbour, which would crack too, or lock. Cells have means of 1/8, 3/4 and 1/8,
and nodes can open one cell with all others at rest: a crack is one cell wide (`materials.cohesive_crack`). Means in the
cells between knots would not see a zigzag of the nodes.
"""

from snowmpm.compiler import runtime, ti
from snowmpm.compiler.arrays import real_array
from snowmpm.components.f_bar.cell_means import CellMean, cell_kernels, sums_of
from snowmpm.particles.blocks import EDGE
from snowmpm.stepping.component import Adapter

SPARE = 1.25


def adapter(model):
    """`CellMeans` of the scene of a `Model`."""
    return CellMeans(model.scene.solver.f_bar, model.scene.dimension)


class CellMeans(Adapter):
    """What the particles of a cell of an `MpmSolver` share in a step."""

    name = "f_bar"

    def __init__(self, kind, dim):
        """kind: True, they change their volume as one; "whole", they deform as one."""
        size = dim * dim if kind == "whole" else 1
        self.columns, self.inlined = {CellMean.column: size}, CellMean(size)
        self._sums = None

    def begin(self, solver):
        """Take the solver's particles and grid."""
        self._solver, store, real = solver, solver.particles, runtime.DTYPES[solver.precision][0]
        self._per_stress = real_array([1.0 / (3.0 * law.bulk_modulus) for law in store.materials.laws])
        self._cells = (EDGE[solver.dim] + 2) ** solver.dim
        self._of_cell = ti.types.vector(sums_of(self.inlined.size), real)
        self._kernels = cell_kernels(store.layout, real, solver.basis, solver.gradient_form, solver.flip,
                                     self.inlined)

    def before_gather(self, dt):
        """Leave with each particle what those of its cell share, by the velocities of the nodes."""
        particles, grid, kernels = self._solver.particles, self._solver.grid, self._kernels
        n = max(1, len(particles.blocks)) * self._cells
        if self._sums is None or self._sums.shape[0] < n:
            self._sums = ti.ndarray(self._of_cell, (int(SPARE * n),))
        of_particles = particles.reals, particles.slot_offset, particles.start
        elastic = *of_particles, particles.material, self._per_stress, self._sums, particles.chunk_bounds
        kernels.add(*of_particles, grid.tiles, self._sums, dt, particles.dx, particles.chunk_bounds)
        if self.inlined.size == 1:
            kernels.add_elastic(*elastic)
        kernels.join(self._sums, grid.first_tile, grid.tiles_at, grid.node_chunk_bounds)
        kernels.spread(*elastic)

    def work(self):
        """Particles."""
        return {"particle": self._solver.particles.count}

    @property
    def bytes(self):
        """Of the sums."""
        if self._sums is None:
            return 0
        return self._sums.element_shape[0] * self._sums.shape[0] * (4 if self._solver.precision == "f32" else 8)
