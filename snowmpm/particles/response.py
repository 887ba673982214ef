"""What a particle makes of a step's velocity gradient: its deformation, its law, the columns that it then stores."""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.materials.parameters import named
from snowmpm.particles.material_table import DENSITY
from snowmpm.particles.store import accessors

LARGEST_RATIO = 1e4
"""J at which a grain that flies alone stops to grow: its volume means nothing, and would overflow in the end. The law
sees no deformation then either, so that what it has to close again and J stay the same thing."""


@functools.cache
def response_functions(layout, real, laws):
    """Taichi functions of one particle. laws: `LawFunctions` of a scene."""
    dim, sym_size = layout.dim, layout.sym_size
    access, at = accessors(layout), layout.offsets
    stiffnesses, names = [law.stiffness for law in laws], [law.names for law in laws]
    stiffens = [function is not None for function in stiffnesses]
    sizes = [len(fields._fields) for fields in names]
    breakable, bonds_at = [law.bonds is not None for law in laws], [law.bonds or 0 for law in laws]

    @ti.func
    def deform(L, ratio, dt):
        """Deformation of a step: A, det f and the new J."""
        A = dt * L
        growth = (ti.Matrix.identity(real, dim) + A).determinant()
        ends = (ratio * growth > LARGEST_RATIO) & (growth > 1.0)
        return ti.select(ends, 0.0, 1.0) * A, growth, ti.select(ends, ratio, ratio * growth)

    @ti.func
    def parameters_of(k: ti.template(), materials: ti.template(), material):
        """The numbers of a material of law k by name, read once."""
        numbers = ti.Vector.zero(real, sizes[k])
        for c in ti.static(range(sizes[k])):
            numbers[c] = materials[material, DENSITY + 1 + c]
        return named(names[k], numbers)

    @ti.func
    def extremes_of_law(k: ti.template(), materials: ti.template(), material, h, tau, state):
        """STRAIN and WAVE2 of a particle of law k."""
        strain, wave2 = h.norm_sqr(), ti.cast(0.0, real)
        if ti.static(stiffens[k]):
            wave2 = stiffnesses[k](parameters_of(k, materials, material), tau, state) / materials[material, DENSITY]
            strain = 0.0
        return strain, wave2

    @ti.func
    def breaks(k: ti.template(), materials: ti.template(), material, state, work):
        """1 where a particle of law k lost bonds in the step that led to `state`, by its plastic work per volume, and
        has some left; else 0."""
        found = ti.cast(0.0, real)
        if ti.static(breakable[k]):
            lasting = state[ti.static(bonds_at[k])] < materials[material, DENSITY + 1 + sizes[k]]
            breaking = lasting & (work > materials[material, DENSITY + 2 + sizes[k]])
            found = ti.select(breaking, ti.cast(1.0, real), found)
        return found

    @ti.func
    def blend(velocity, changed, flip_ratio):
        """Velocity of FLIP or AFLIP from that on the grid and the particle's own with its change."""
        return velocity + flip_ratio * (changed - velocity)

    @ti.func
    def store_motion(p, reals: ti.template(), places, velocity, C):
        """Columns that follow each other are stored as one vector, so that whole rows are written."""
        motion = ti.Vector.zero(real, dim + dim * dim)
        for i in ti.static(range(dim)):
            motion[i] = velocity[i]
            for a in ti.static(range(dim)):
                motion[dim + i * dim + a] = C[i, a]
        access.store(reals, places, p, at["velocity"], motion)

    @ti.func
    def store_response(p, reals: ti.template(), places, h, tau, state, ratio):
        response = ti.Vector.zero(real, 2 * sym_size + layout.state_size + 1)
        for k in ti.static(range(sym_size)):
            response[k], response[sym_size + k] = h[k], tau[k]
        for k in ti.static(range(layout.state_size)):
            response[2 * sym_size + k] = state[k]
        response[2 * sym_size + layout.state_size] = ratio
        access.store(reals, places, p, at["elastic"], response)

    return SimpleNamespace(deform=deform, parameters_of=parameters_of, extremes_of_law=extremes_of_law, breaks=breaks,
                           blend=blend, store_motion=store_motion, store_response=store_response)
