"""Grid to particles, then the constitutive update: everything a particle learns from a step.

    v_grid = sum_i w v_i,   C <- D^-1 sum_i w v_i (x_i - x_p)^T,   x <- x + dt v_grid
    v  <- v_grid + flip_ratio (v + sum_i w dv_i - v_grid)        flip_ratio = 0 in PIC and APIC
    L = grad v: C with the gradient "affine", sum_i v_i grad w^T with "shape" (see `scatter`)
    f = I + dt L,  A = dt L;   law.update(h, A) -> h, tau, state;   J <- J det f

f is the deformation of the map x + dt v_grid(x) itself, so that stress and places stay one thing: v is that of the end
of the step over the geometry of its start, and in a rotation L has the part -omega^2 dt / 2 I, which leaves det f = 1 +
(omega dt)^4 / 4. exp(dt L) would hold J as well, but let the places swell by omega^2 dt t against it.
"""

import functools

import taichi as ti

from snowmpm.blocks import EDGE
from snowmpm.material_table import DENSITY
from snowmpm.mpm.grid import TILE
from snowmpm.parallel import chunk, chunks, is_worker
from snowmpm.particles import MATERIAL, accessors
from snowmpm.stencil import STENCILS
from snowmpm.timestep import DEFORMATION_LIMIT, FREE_LIMIT

SPEED2, GRADIENT2, STRAIN, EXCURSION, DISSIPATION, UNCONVERGED, BAD, PLASTIC, WAVE2 = range(9)
"""Columns of a block's report: largest |v|^2, |grad v|^2 (less without stress), |be - I| of laws of constant
stiffness and excursion from home [cells]; sums of plastic work [J] and of particles whose return map failed; index + 1
of a particle that is not finite or inverted; number of particles that yielded; largest squared wave speed of the laws
that stiffen."""

N_REPORT = 9

FREE_SHARE = (DEFORMATION_LIMIT / FREE_LIMIT) ** 2
"""What the squared velocity gradient of a grain without stress counts."""

LARGEST_RATIO = 1e4
"""J at which a grain that flies alone stops to grow: its volume means nothing, and would overflow in the end. The law
sees no deformation then either, so that what it has to close again and J stay the same thing."""

FARTHEST_STEP = 1.5
"""Cells beyond the stencil's home limit that a sort can still bring back; farther means an unstable step."""

_SUMMED = (DISSIPATION, UNCONVERGED, PLASTIC)


@functools.cache
def gather_kernel(layout, real, updates, stiffnesses, n_parameters, atomic, flip, basis="quadratic", gradient="affine",
                  affine=True):
    """Kernel of the second half of a step for the update functions of these laws, and the functions that give their
    stiffness, None where it is constant. atomic, basis and gradient as in `scatter_kernel`; affine: whether the
    transfer hands C on (APIC), and so needs it beside a grad v of the shape functions."""
    dim, edge, tile_edge = layout.dim, EDGE[layout.dim], TILE[layout.dim]
    load, store = accessors(layout)
    at = layout.offsets
    vec4 = ti.types.vector(4, real)
    stencil, shape = STENCILS[basis], gradient == "shape"
    width, reach, moving = stencil.width, stencil.reach, affine or not shape
    farthest = stencil.home_limit + FARTHEST_STEP
    stride = [tile_edge ** (dim - 1 - a) for a in range(dim)]
    n_laws, stiffens = len(updates), [function is not None for function in stiffnesses]

    @ti.func
    def larger(a, b):
        """Larger number or, entry by entry, vector; b where a is not a number. One instruction, unlike ti.max."""
        return ti.select(a > b, a, b)

    @ti.func
    def is_finite(x):
        """By the bits of the exponent: fast floating-point mode may optimise a comparison with NaN away."""
        finite = True
        if ti.static(real == ti.f32):
            finite = (ti.bit_cast(ti.cast(x, ti.f32), ti.i32) & 0x7F800000) != 0x7F800000
        else:
            finite = ((ti.bit_cast(ti.cast(x, ti.f64), ti.i64) >> 52) & 0x7FF) != 0x7FF
        return finite

    @ti.func
    def interpolate(tiles: ti.template(), b, base, f, w, dw, inverse_dx, moving: ti.template(), sloping: ti.template()):
        """Velocity [m/s] at a particle and, where asked for, its affine matrix C and the sum of v grad w^T [1/s]."""
        address = b * tile_edge**dim
        for a in ti.static(range(dim)):
            address += (base[a] + 1) * stride[a]
        v = vec4(0.0)
        moments, slopes = [vec4(0.0) for _ in ti.static(range(dim))], [vec4(0.0) for _ in ti.static(range(dim))]
        if ti.static(dim == 3):
            for i in ti.static(range(width)):
                plane, plane_moments, plane_slopes = sum_rows(tiles, address + i * stride[0], w, dw, moving, sloping)
                v += w[i, 0] * plane
                if ti.static(moving):
                    moments[0] += (float(i) * w[i, 0]) * plane
                    moments[1] += w[i, 0] * plane_moments[0, :]
                    moments[2] += w[i, 0] * plane_moments[1, :]
                if ti.static(sloping):
                    slopes[0] += dw[i, 0] * plane
                    slopes[1] += w[i, 0] * plane_slopes[0, :]
                    slopes[2] += w[i, 0] * plane_slopes[1, :]
        else:
            v, plane_moments, plane_slopes = sum_rows(tiles, address, w, dw, moving, sloping)
            for a in ti.static(range(dim)):
                moments[a], slopes[a] = plane_moments[a, :], plane_slopes[a, :]
        velocity, C, L = ti.Vector.zero(real, dim), ti.Matrix.zero(real, dim, dim), ti.Matrix.zero(real, dim, dim)
        for i in ti.static(range(dim)):
            velocity[i] = v[i]
            for a in ti.static(range(dim)):
                if ti.static(moving):
                    C[i, a] = (stencil.inverse_second_moment * inverse_dx) * (moments[a][i] - f[a] * v[i])
                if ti.static(sloping):
                    L[i, a] = inverse_dx * slopes[a][i]
        return velocity, C, L

    @ti.func
    def sum_rows(tiles: ti.template(), address, w, dw, moving: ti.template(), sloping: ti.template()):
        """Over the last two axes of a stencil: sum of w v, its two first moments, and the sums with the slopes of w."""
        total = vec4(0.0)
        moments, slopes = [vec4(0.0), vec4(0.0)], [vec4(0.0), vec4(0.0)]
        for j in ti.static(range(width)):
            row, moment, slope = vec4(0.0), vec4(0.0), vec4(0.0)
            for k in ti.static(range(width)):
                node = tiles[address + j * stride[dim - 2] + k]
                row += w[k, dim - 1] * node
                if ti.static(moving and k > 0):
                    moment += (float(k) * w[k, dim - 1]) * node
                if ti.static(sloping):
                    slope += dw[k, dim - 1] * node
            total += w[j, dim - 2] * row
            if ti.static(moving):
                moments[0] += (float(j) * w[j, dim - 2]) * row
                moments[1] += w[j, dim - 2] * moment
            if ti.static(sloping):
                slopes[0] += dw[j, dim - 2] * row
                slopes[1] += w[j, dim - 2] * slope
        return total, ti.Matrix.rows(moments), ti.Matrix.rows(slopes)

    @ti.func
    def excursion(lowest, highest):
        """Largest distance from home [cells] of positions between these."""
        return ti.max(0.0, (0.5 - lowest).max(), (highest - (edge + 0.5)).max())

    @ti.func
    def store_box(boxes: ti.template(), b, lowest, highest):
        """The nodes of the tile that stencils of positions between these touch."""
        for a in ti.static(range(dim)):
            first = ti.floor(lowest[a] - reach, ti.i32) + 1
            last = ti.floor(highest[a] - reach, ti.i32) + 1 + width
            boxes[b, 3 - dim + a] = ti.max(0, first)
            boxes[b, 6 - dim + a] = ti.min(tile_edge, last)

    @ti.func
    def gather_particle(p, b, reals: ti.template(), integers: ti.template(), materials: ti.template(),
                        law_of: ti.template(), tiles: ti.template(), changes: ti.template(), dt,
                        inverse_dx, flip_ratio):
        """Advance one particle; -> its report, its new position."""
        x = load(reals, p, at["position"], dim)
        base = ti.floor(x - reach, ti.i32)
        f = x - ti.cast(base, float)
        w, dw = stencil.weights(f), ti.Matrix.zero(real, width, dim)
        if ti.static(shape):
            dw = stencil.slopes(f)
        velocity, C, grad_v = interpolate(tiles, b, base, f, w, dw, inverse_dx, moving, shape)
        if ti.static(not shape):
            grad_v = C
        elif ti.static(not moving):
            C = grad_v
        x += (dt * inverse_dx) * velocity
        if ti.static(flip):
            change, _, _ = interpolate(changes, b, base, f, w, dw, inverse_dx, False, False)
            velocity += flip_ratio * (load(reals, p, at["velocity"], dim) + change - velocity)
        # Stored before the law starts, so that it has the registers
        store(reals, p, at["position"], x)
        store(reals, p, at["velocity"], velocity)
        for i in ti.static(range(dim)):
            store(reals, p, at["affine"] + i * dim, C[i, :])
        report = ti.Vector.zero(real, N_REPORT)
        report[SPEED2] = velocity.norm_sqr()
        A = dt * grad_v
        growth = (ti.Matrix.identity(real, dim) + A).determinant()
        ratio = load(reals, p, at["volume_ratio"], 1)[0]
        if ratio * growth > LARGEST_RATIO and growth > 1.0:
            A.fill(0.0)
        else:
            ratio *= growth
        material = integers[p, MATERIAL]
        h = load(reals, p, at["elastic"], layout.sym_size)
        tau = ti.Vector.zero(real, layout.sym_size)
        work, iterations = ti.cast(0.0, real), 0
        state = load(reals, p, at["state"], layout.state_size)
        parameters = ti.Vector.zero(real, n_parameters)
        for c in ti.static(range(n_parameters)):
            parameters[c] = materials[material, 1 + c]
        for k in ti.static(range(n_laws)):
            if law_of[material] == k:
                h, tau, state, work, iterations = updates[k](parameters, h, state, A, dt)
                if ti.static(stiffens[k]):
                    report[WAVE2] = stiffnesses[k](parameters, tau, state) / materials[material, DENSITY]
                else:
                    report[STRAIN] = h.norm_sqr()
        store(reals, p, at["state"], state)
        volume = load(reals, p, at["volume"], 1)[0]
        store(reals, p, at["elastic"], h)
        store(reals, p, at["stress"], tau)
        store(reals, p, at["volume_ratio"], ti.Vector([ratio]))
        strayed = (ti.abs(x - 0.5 * (edge + 1)) > 0.5 * edge + farthest).any()
        report[DISSIPATION] = work * volume
        report[GRADIENT2] = grad_v.norm_sqr() * ti.select(tau.norm_sqr() > 0.0, 1.0, FREE_SHARE)
        report[UNCONVERGED] = ti.select(iterations < 0, 1.0, 0.0)
        report[PLASTIC] = ti.select(iterations != 0, 1.0, 0.0)
        sound = is_finite(report[SPEED2] + report[GRADIENT2] + h.norm_sqr() + tau.sum())
        if growth <= 0.0 or strayed or not sound:
            report[BAD] = 1.0
        return report, x

    @ti.func
    def reduce_report(reports: ti.template(), report: ti.template(), n_tiles):
        for c in ti.static(range(N_REPORT)):
            report[c] = 0.0
        for b in range(n_tiles):
            for c in ti.static(range(N_REPORT)):
                if ti.static(c in _SUMMED):
                    report[c] += reports[b, c]
                else:
                    report[c] = ti.max(report[c], reports[b, c])

    @ti.kernel
    def gather_blocks(reals: ti.types.ndarray(), integers: ti.types.ndarray(), materials: ti.types.ndarray(),
                      law_of: ti.types.ndarray(), start: ti.types.ndarray(), boxes: ti.types.ndarray(),
                      tiles: ti.types.ndarray(dtype=vec4, ndim=1), changes: ti.types.ndarray(dtype=vec4, ndim=1),
                      dt: real, dx: real, flip_ratio: real, reports: ti.types.ndarray(), report: ti.types.ndarray(),
                      n_tiles: int, shares: ti.types.ndarray()):
        for i in range(chunks(shares)):
            if is_worker(i):
                first, last = chunk(i, shares)
                for b in range(first, last):
                    block = ti.Vector.zero(real, N_REPORT)
                    worst = 0
                    lowest, highest = ti.Vector.zero(real, dim) + 2.0 * edge, ti.Vector.zero(real, dim) - edge
                    for p in range(start[b], start[b + 1]):
                        one, x = gather_particle(p, b, reals, integers, materials, law_of, tiles, changes, dt, 1.0 / dx,
                                                 flip_ratio)
                        lowest, highest = -larger(-x, -lowest), larger(x, highest)
                        for c in ti.static(range(N_REPORT)):
                            if ti.static(c in _SUMMED):
                                block[c] += one[c]
                            else:
                                block[c] = larger(one[c], block[c])
                        if one[BAD] > 0.0:
                            worst = p + 1
                    store_box(boxes, b, lowest, highest)
                    block[EXCURSION] = excursion(lowest, highest)
                    for c in ti.static(range(N_REPORT)):
                        reports[b, c] = ti.cast(block[c], ti.f64)
                    reports[b, BAD] = ti.cast(worst, ti.f64)
        ti.loop_config(serialize=True)
        for _ in range(1):
            reduce_report(reports, report, n_tiles)

    @ti.kernel
    def gather_atomic(reals: ti.types.ndarray(), integers: ti.types.ndarray(), materials: ti.types.ndarray(),
                      law_of: ti.types.ndarray(), block_of: ti.types.ndarray(), boxes: ti.types.ndarray(),
                      tiles: ti.types.ndarray(dtype=vec4, ndim=1), changes: ti.types.ndarray(dtype=vec4, ndim=1),
                      dt: real, dx: real, flip_ratio: real, reports: ti.types.ndarray(), report: ti.types.ndarray(),
                      n_tiles: int, count: int):
        for b, c in ti.ndrange(n_tiles, N_REPORT):
            reports[b, c] = 0.0
        for p in range(count):
            one, x = gather_particle(p, block_of[p], reals, integers, materials, law_of, tiles, changes, dt, 1.0 / dx,
                                     flip_ratio)
            one[EXCURSION] = excursion(x, x)
            for c in ti.static(range(N_REPORT)):
                value = ti.cast(one[c], ti.f64)
                if ti.static(c == BAD):
                    value *= p + 1
                if ti.static(c in _SUMMED):
                    ti.atomic_add(reports[block_of[p], c], value)
                else:
                    ti.atomic_max(reports[block_of[p], c], value)
        ti.loop_config(serialize=True)
        for _ in range(1):
            reduce_report(reports, report, n_tiles)

    return gather_atomic if atomic else gather_blocks
