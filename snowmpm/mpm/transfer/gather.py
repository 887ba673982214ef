"""Grid to particles, then the constitutive update: everything a particle learns from a step.

    v_grid = sum_i w v_i,   C <- D^-1 sum_i w v_i (x_i - x_p)^T,   x <- x + dt v_grid
    v  <- v_grid + flip_ratio (v + sum_i w dv_i - v_grid)        flip_ratio = 0 in PIC and APIC
    L = grad v: C with the gradient "affine", sum_i v_i grad w^T with "shape" (see `scatter`)
    f = I + dt L,  A = dt L;   law.update(h, A) -> h, tau, state;   J <- J det f

Components may change L (`kernel_api.Inlined.gradient`).

f is the deformation of the map x + dt v_grid(x) itself, so that stress and places stay one thing: v is that of the end
of the step over the geometry of its start, and in a rotation L has the part -omega^2 dt / 2 I, which leaves det f = 1 +
(omega dt)^4 / 4. exp(dt L) would hold J as well, but let the places swell by omega^2 dt t against it.

A CPU takes the particles of a block in packs (`gather_packs`), a GPU one a thread.
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import in_order
from snowmpm.mpm.node import SECOND
from snowmpm.mpm.report import report_functions
from snowmpm.mpm.transfer.arrays import Step, Tiles
from snowmpm.mpm.transfer.gather_packs import gradient_functions, pack_kernel
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.particles.arrays import ParticleArrays
from snowmpm.particles.response import response_functions
from snowmpm.particles.store import accessors
from snowmpm.stepping.step_report import BAD, BREAKING, EXCURSION, N_REPORT, STRAIN, STRAINED, SUMMED, WAVE2


def gather_kernel(layout, real, laws, scheme, atomic, serial=False, inlined=()):
    """Kernel of the second half of a step.

    laws: `LawFunctions` of a scene; scheme: `Scheme`; inlined: `kernel_api.Inlined` of components, in their order.
    atomic: as in `scatter_kernel`; serial: by one thread.
    """
    if atomic:
        return particle_kernel(layout, real, laws, scheme, inlined)
    return pack_kernel(layout, real, laws, scheme, inlined, serial)


@functools.cache
def particle_kernel(layout, real, laws, scheme, inlined):
    """The kernel for one particle a thread."""
    flip, basis, gradient, affine = scheme
    dim, sym_size = layout.dim, layout.sym_size
    access, at = accessors(layout), layout.offsets
    n_laws, updates = len(laws), [law.update for law in laws]
    shape = gradient == "shape"
    grid = interpolation(dim, real, basis, affine or not shape, shape, flip)
    judged = report_functions(dim, real, basis)
    particle = response_functions(layout, real, laws)
    bent = gradient_functions(layout, real, inlined)

    @ti.func
    def gather_particle(p, b, particles: ti.template(), places, tiles: ti.template(), step: ti.template()):
        """Advance one particle; -> its report."""
        dt, inverse_dx = step.dt, 1.0 / step.dx
        x = access.load(particles.reals, places, p, at["position"], dim)
        address, f, w, dw = grid.locate(x, b)
        v, moments, slopes = grid.interpolate(tiles.nodes, address, w, dw)
        C, L = grid.gradients(f, v, moments, slopes, inverse_dx)
        velocity = ti.Vector([v[i] for i in ti.static(range(dim))])
        x += (dt * inverse_dx) * velocity
        for k in ti.static(range(len(bent))):
            own = access.load(particles.reals, places, p, bent[k].at, bent[k].size)
            ratio = access.load(particles.reals, places, p, at["volume_ratio"], 1)[0]
            L, own = bent[k].act(L, velocity, ratio, own, dt, 1.0 / inverse_dx)
            if ti.static(bent[k].keeps):
                access.store(particles.reals, places, p, bent[k].at, own)
        if ti.static(flip):
            change = ti.Vector([v[SECOND + i] for i in ti.static(range(dim))])
            old = access.load(particles.reals, places, p, at["velocity"], dim)
            velocity = particle.blend(velocity, old + change, step.flip_ratio)
        A, growth, ratio = particle.deform(L, access.load(particles.reals, places, p, at["volume_ratio"], 1)[0], dt)
        h, tau = access.load(particles.reals, places, p, at["elastic"], sym_size), ti.Vector.zero(real, sym_size)
        state = access.load(particles.reals, places, p, at["state"], layout.state_size)
        work, iterations = ti.cast(0.0, real), 0
        strain, wave2, breaks = ti.cast(0.0, real), ti.cast(0.0, real), ti.cast(0.0, real)
        kind = particles.material[p]
        for k in ti.static(range(n_laws)):
            if particles.law_of[kind] == k:
                h, tau, state, work, iterations = updates[k](particle.parameters_of(k, particles.materials, kind), h,
                                                             state, A, dt)
                strain, wave2 = particle.extremes_of_law(k, particles.materials, kind, h, tau, state)
                breaks = particle.breaks(k, particles.materials, kind, state, work)
        access.store(particles.reals, places, p, at["position"], x)
        particle.store_motion(p, particles.reals, places, velocity, C)
        particle.store_response(p, particles.reals, places, h, tau, state, ratio)
        volume = access.load(particles.reals, places, p, at["volume"], 1)[0]
        report = judged.judge(x, velocity, L, growth, h, tau, work * volume, iterations)
        report[STRAIN], report[WAVE2], report[EXCURSION] = strain, wave2, judged.excursion(x, x)
        report[BREAKING], report[STRAINED] = breaks, judged.strained(strain)
        return report

    @grouped_kernel(real)
    def gather_atomic(particles: ParticleArrays, block_of: Array, tiles: Tiles, step: Step, reports: Array,
                      report: Array, count: int):
        for b, c in ti.ndrange(tiles.n, N_REPORT):
            reports[b, c] = 0.0
        for p in range(count):
            places = access.places(particles.reals, particles.slot_offset)
            one = gather_particle(p, block_of[p], particles, places, tiles, step)
            for c in ti.static(range(N_REPORT)):
                value = ti.cast(one[c], ti.f64)
                if ti.static(c == BAD):
                    value *= p + 1
                if ti.static(c in SUMMED):
                    ti.atomic_add(reports[block_of[p], c], value)
                elif value > reports[block_of[p], c]:
                    # What is seen may be old, but is never too large: looking spares nearly all of the atomics
                    ti.atomic_max(reports[block_of[p], c], value)
        ti.loop_config(serialize=ti.static(in_order()))
        for b in range(tiles.n):
            judged.add_row(reports, b, report)

    return gather_atomic
