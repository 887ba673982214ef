"""A step of the powder layer: a layer of height h of air and ice over a steep ground, not Boussinesq.

With V = h / cos the volume over a unit of plan, I = c V that of ice, w the velocity in plan, s the slope of the ground,
G^-1 = I - s s / (1 + s^2), m = rho_a V + (rho_i - rho_a) I the mass and M the momentum over a unit of plan,

    dV/dt + div(V w) = e_a |w| / cos
    dI/dt + div(<cu> I w) = 0
    dM/dt + div((<uu> rho_a V + <cuu> (rho_i - rho_a) I) w w) = -(1/cos) G^-1 grad P - (rho_i - rho_a) I cos^2 g s
                                                               - (C_02 + C_top) (m / V) |w| w / cos
                                                               - k rho_a d(V w_n)/dt n where V grows
    M = (rho_a V + <cu> (rho_i - rho_a) I) w,   P = (rho - rho_a) g cos h^2 / 2 = g cos^3 (rho_i - rho_a) I V / 2

which are the equations of the guide (`docs/powder_layer.md`), with what the layers exchange left to `exchange`. Air
that is taken in is at rest. Cloud of the density of air feels neither weight nor pressure.

The last term is the air that the front pushes aside: that of TWODEE (Hankin and Britter 1999, J. Hazard. Mater. 66,
211, as the program RTWODEE2 has it), but for n, the direction of the front, in which V falls off. The momentum along a
front is left alone: clouds would lose speed at their sides, the more the finer the cells. Over a front that moves at U
the term adds up to k rho_a U^2 h, so that U^2 = (rho_2 - rho_a) g_n h / (2 k rho_a): a Froude number of 1 / sqrt(2 k)
with the density of air, whatever the cells.

Fluxes by HLL (Harten, Lax, van Leer 1983, doi:10.1137/1025002) from limited slopes of V, c and w; two stages (Shu,
Osher 1988, doi:10.1016/0021-9991(88)90177-5), each of which reckons drag with the new velocity. Of second order where
nothing but weight and pressure acts; of first order in time in drag, air and front, with states that do not change
exact. With sum |lambda| dt / dx below 1/2 over both axes V and I stay positive, and c within its bounds where profiles
are uniform. Velocities cross faces as in `depth.volumes.kernels`: turned from plane to plane without a change of speed,
and pressure counts against that within the cell.
"""

import functools
from typing import NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import strided, strides
from snowmpm.components.powder_layer.arrays import (
    ADDED,
    AIR,
    DRAG,
    FACES,
    FLUX,
    PULL,
    RATE,
    SLOPES,
    STATE,
    Below,
    Cloud,
    Numbers,
    Step,
    Tiles,
)
from snowmpm.components.powder_layer.closures import AIR as AIR_LAWS
from snowmpm.depth.kernel_api import TILE, carried, limited, surface_speed

AHEAD = 8
"""Of `arrays.SLOPES`: the first of the differences over two cells."""
LEAST = 1e-9
"""V [m] below which a cell has no velocity."""
COVERED = 1e-3
"""Depth [m] of moving snow below a cloud that keeps it from the drag of the ground."""
TOLD, DUSTY = 0.5, 0.1
"""Height [m] and excess of density over air [kg/m3] of a cloud from which it counts in the maps."""


class Kernels(NamedTuple):
    """Those of a stage, in their order."""

    slope: object
    cross: object
    advance: object


@ti.func
def slope_of(below: ti.template(), i, j):
    """s of the ground in a cell."""
    return ti.Vector([ti.cast(below.ground[i, j, 0], ti.f64), ti.cast(below.ground[i, j, 1], ti.f64)])


@ti.func
def cosine_in(below: ti.template(), i, j):
    """Of the slope of a cell."""
    return ti.cast(below.ground[i, j, 5], ti.f64)


@ti.func
def cosine_of(s):
    """Of the slope s."""
    return 1.0 / ti.sqrt(1.0 + s.dot(s))


@ti.func
def weight_of(numbers: ti.template(), V, ice):
    """Momentum over velocity [kg/m2]."""
    return numbers.air * V + numbers.cu * numbers.excess * ice


@ti.func
def density_of(cloud: ti.template(), numbers: ti.template(), c):
    """rho_2 [kg/m3]; that of air where there is no cloud."""
    return numbers.air + numbers.excess * cloud.state[c, 1] / ti.max(cloud.state[c, 0], LEAST)


@ti.func
def share_of(cloud: ti.template(), c):
    """c, the share of ice in the volume of a cell."""
    return cloud.state[c, 1] / ti.max(cloud.state[c, 0], 1e-300)


@ti.func
def smaller(a, b):
    """The smaller of two differences of one sign, 0 where they differ in it (minmod)."""
    return ti.select(a * b > 0.0, ti.select(ti.abs(a) < ti.abs(b), a, b), 0.0)


@ti.func
def velocity_in(cloud: ti.template(), numbers: ti.template(), c):
    """w of a cell [m/s]."""
    V, found = cloud.state[c, 0], ti.Vector([0.0, 0.0])
    if V > LEAST:
        m = weight_of(numbers, V, cloud.state[c, 1])
        found = ti.Vector([cloud.state[c, 2], cloud.state[c, 3]]) / m
    return found


@ti.func
def turned(cloud: ti.template(), below: ti.template(), numbers: ti.template(), c, at, s, cosine):
    """w of cell c at (2): i, j, turned into a plane of slope s."""
    return carried(velocity_in(cloud, numbers, c), slope_of(below, at[0], at[1]), cosine_in(below, at[0], at[1]), s,
                   cosine)


@ti.func
def signal(numbers: ti.template(), V, ice, u, stiff):
    """Slowest and fastest signal [m/s] along an axis with velocity u, and the speed of waves; stiff: g cos^3 and the
    metric of the face."""
    m = ti.max(numbers.air * V + numbers.excess * ice, 1e-300)
    c2 = stiff * numbers.cu * numbers.excess * ice * V / m
    beta = ti.max(numbers.uu, numbers.cuu / numbers.cu)
    wave = ti.sqrt(beta * (beta - 1.0) * u * u + c2)
    return ti.Vector([ti.min(u, beta * u) - wave, ti.max(u, beta * u) + wave, ti.sqrt(c2)])


@ti.func
def crossed(numbers: ti.template(), step: ti.template(), one, s):
    """Sum over both axes of the speed of the fastest signal over dx [1/s]; one: V, I, u, v."""
    cosine, found = cosine_of(s), 0.0
    for axis in ti.static(range(2)):
        stiff = step.g * cosine**4 * (1.0 + s[1 - axis] ** 2)
        both = signal(numbers, one[0], one[1], one[2 + axis], stiff)
        found += ti.max(both[1], -both[0])
    return found / step.dx


@ti.func
def drag_under(below: ti.template(), numbers: ti.template(), i, j):
    """C of the top, and of the ground where no snow moves on it."""
    bare = below.state[i, j, 0] < COVERED or (below.state[i, j, 1] == 0.0 and below.state[i, j, 2] == 0.0)
    return numbers.top_drag + ti.select(bare, numbers.ground_drag, 0.0)


@functools.cache
def kernels(air_law, serial):
    """`Kernels` for a law of air entrainment (`closures.AIR`)."""
    entrained = ti.func(AIR_LAWS[air_law])

    @grouped_kernel(ti.f64)
    def slope(cloud: Cloud, below: Below, tiles: Tiles, numbers: Numbers):
        """Limited differences across cells. Velocities of neighbours are turned into the plane of the cell."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 0 < i < tiles.nx - 1 and 0 < j < tiles.ny - 1:
                        c = i * tiles.ny + j
                        for k in ti.static(range(SLOPES)):
                            cloud.slopes[c, k] = 0.0
                        for axis in ti.static(range(2)):
                            step = ti.select(axis == 0, tiles.ny, 1)
                            cloud.slopes[c, AHEAD + axis] = cloud.state[c + step, 0] - cloud.state[c - step, 0]
                        if cloud.state[c, 0] > LEAST:
                            s, w = slope_of(below, i, j), velocity_in(cloud, numbers, c)
                            cosine = cosine_in(below, i, j)
                            for axis in ti.static(range(2)):
                                step = ti.select(axis == 0, tiles.ny, 1)
                                up, down = c + step, c - step
                                cloud.slopes[c, 4 * axis] = limited(cloud.state[up, 0] - cloud.state[c, 0],
                                                                    cloud.state[c, 0] - cloud.state[down, 0])
                                if cloud.state[up, 0] > LEAST and cloud.state[down, 0] > LEAST:
                                    part = share_of(cloud, c)
                                    cloud.slopes[c, 4 * axis + 1] = smaller(share_of(cloud, up) - part,
                                                                            part - share_of(cloud, down))
                                    over = ti.Vector([i + 1 - axis, j + axis])
                                    under = ti.Vector([i - 1 + axis, j - axis])
                                    ahead = turned(cloud, below, numbers, up, over, s, cosine)
                                    behind = turned(cloud, below, numbers, down, under, s, cosine)
                                    for k in ti.static(range(2)):
                                        cloud.slopes[c, 4 * axis + 2 + k] = limited(ahead[k] - w[k], w[k] - behind[k])

    @ti.func
    def side(cloud: ti.template(), below: ti.template(), numbers: ti.template(), place, towards, plane,
             axis: ti.template()):
        """V, I, u, v on a side of a face; place (3): number of the cell, i, j; towards: 1/2 or -1/2; plane (3): the
        slope of the face and its cosine."""
        c = place[0]
        w, s, V = velocity_in(cloud, numbers, c), slope_of(below, place[1], place[2]), cloud.state[c, 0]
        for k in ti.static(range(2)):
            w[k] += towards * cloud.slopes[c, 4 * axis + 2 + k]
        w = carried(w, s, cosine_in(below, place[1], place[2]), ti.Vector([plane[0], plane[1]]), plane[2])
        change = towards * cloud.slopes[c, 4 * axis]
        # the volume on the other side weighs, so that the ice of both is that of the cell, and c within its bounds
        part = share_of(cloud, c) + towards * cloud.slopes[c, 4 * axis + 1] * (V - change) / ti.max(V, LEAST)
        return ti.Vector([V + change, (V + change) * part, w[0], w[1]])

    @ti.func
    def through(numbers: ti.template(), one, stiff, metric, axis: ti.template()):
        """Flux of a side of a face, and what it is the flux of: volume, ice, momentum across, along; the pressure."""
        V, ice, u, v = one[0], one[1], one[2 + axis], one[3 - axis]
        m = weight_of(numbers, V, ice)
        carries = numbers.uu * numbers.air * V + numbers.cuu * numbers.excess * ice
        pressure = 0.5 * stiff * numbers.excess * ice * V
        push = carries * u * u + metric * pressure
        return (ti.Vector([V * u, numbers.cu * ice * u, push, carries * u * v, pressure]),
                ti.Vector([V, ice, m * u, m * v, 0.0]))

    @ti.func
    def pushed(cloud: ti.template(), below: ti.template(), numbers: ti.template(), step: ti.template(), mean, place,
               plane, axis: ti.template()):
        """Momentum (2) that crosses a face of this plane (3), as of `through`, less the pressure in the cell of `place`
        (3: number, i, j), in the plane of that."""
        c, own, cosine = place[0], cosine_in(below, place[1], place[2]), plane[2]
        pressure = 0.5 * step.g * own**3 * numbers.excess * cloud.state[c, 1] * cloud.state[c, 0]
        n = mean[2] - cosine * (1.0 + plane[1 - axis] ** 2) * pressure
        t = mean[3] - cosine * plane[0] * plane[1] * (mean[4] - pressure)
        return carried(ti.Vector([n, t] if ti.static(axis == 0) else [t, n]), ti.Vector([plane[0], plane[1]]), cosine,
                       slope_of(below, place[1], place[2]), own)

    @grouped_kernel(ti.f64)
    def cross(cloud: Cloud, below: Below, tiles: Tiles, numbers: Numbers, step: Step):
        """Fluxes of the faces towards +x and +y."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 0 < i < tiles.nx - 2 and 0 < j < tiles.ny - 2:
                        a = i * tiles.ny + j
                        for axis in ti.static(range(2)):
                            b = a + ti.select(axis == 0, tiles.ny, 1)
                            flux = ti.Vector.zero(ti.f64, FLUX)
                            if cloud.state[a, 0] > LEAST or cloud.state[b, 0] > LEAST:
                                mid = 0.5 * (slope_of(below, i, j) + slope_of(below, i + 1 - axis, j + axis))
                                cosine = cosine_of(mid)
                                plane = ti.Vector([mid[0], mid[1], cosine])
                                metric, stiff = cosine * (1.0 + plane[1 - axis] ** 2), step.g * cosine**3
                                one, other = ti.Vector([a, i, j]), ti.Vector([b, i + 1 - axis, j + axis])
                                left = side(cloud, below, numbers, one, 0.5, plane, axis)
                                right = side(cloud, below, numbers, other, -0.5, plane, axis)
                                first = signal(numbers, left[0], left[1], left[2 + axis], metric * stiff)
                                last = signal(numbers, right[0], right[1], right[2 + axis], metric * stiff)
                                low, high = ti.min(first[0], last[0]), ti.max(first[1], last[1])
                                if left[0] <= LEAST:  # still air is reached at the speed of a front
                                    low, high = right[2 + axis] - 2.0 * last[2], last[1]
                                if right[0] <= LEAST:
                                    low, high = first[0], ti.max(first[1], left[2 + axis] + 2.0 * first[2])
                                if left[0] <= LEAST:
                                    low = ti.min(low, last[0])
                                low, high = ti.min(low, 0.0), ti.max(high, 0.0)
                                fluxes, had = through(numbers, left, stiff, metric, axis)
                                others, has = through(numbers, right, stiff, metric, axis)
                                mean = high * fluxes - low * others + low * high * (has - had)
                                mean /= ti.max(high - low, 1e-12)
                                here = pushed(cloud, below, numbers, step, mean, one, plane, axis)
                                there = pushed(cloud, below, numbers, step, mean, other, plane, axis)
                                flux = ti.Vector([mean[0], mean[1], here[0], here[1], there[0], there[1]])
                            for k in ti.static(range(FLUX)):
                                cloud.flux[a, axis, k] = flux[k]

    @ti.func
    def gained(cloud: ti.template(), tiles: ti.template(), c):
        """Sum of what crosses the faces of a cell: volume, ice, momentum (2), each times dx."""
        left, under, found = c - tiles.ny, c - 1, ti.Vector.zero(ti.f64, STATE)
        for k in ti.static(range(2)):
            found[k] = (cloud.flux[left, 0, k] - cloud.flux[c, 0, k] + cloud.flux[under, 1, k] - cloud.flux[c, 1, k])
            found[2 + k] = (cloud.flux[left, 0, 4 + k] - cloud.flux[c, 0, 2 + k] + cloud.flux[under, 1, 4 + k]
                            - cloud.flux[c, 1, 2 + k])
        return found

    @ti.func
    def in_space(push, s):
        """A momentum (2) along the plane of slope s, in space (3)."""
        return ti.Vector([push[0], push[1], push.dot(s)])

    @ti.func
    def told(cloud: ti.template(), numbers: ti.template(), c, cosine, speed):
        """Peaks of a cell."""
        V, ice = cloud.state[c, 0], cloud.state[c, 1]
        height, part = V * cosine, ice / ti.max(V, 1e-300)
        if height > TOLD and numbers.excess * part > DUSTY:
            head = speed * speed
            cloud.peaks[c, 0] = ti.max(cloud.peaks[c, 0], height)
            cloud.peaks[c, 1] = ti.max(cloud.peaks[c, 1], (numbers.air + numbers.excess * part) * head)
            cloud.peaks[c, 2] = ti.max(cloud.peaks[c, 2], (numbers.foot_uu * numbers.air
                                                           + numbers.foot_cuu * numbers.excess * part) * head)
            cloud.peaks[c, 3] = ti.max(cloud.peaks[c, 3], speed)
            cloud.peaks[c, 4] = ti.max(cloud.peaks[c, 4], numbers.air + numbers.excess * part)

    @grouped_kernel(ti.f64)
    def advance(cloud: Cloud, below: Below, tiles: Tiles, numbers: Numbers, step: Step, report: Array):
        """What crossed the faces, weight, air and drag; in the second stage the mean with the start of the step."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                rate, air, filled = 0.0, 0.0, 0.0
                pulled, pushes, dragged = (ti.Vector([0.0, 0.0, 0.0]), ti.Vector([0.0, 0.0, 0.0]),
                                           ti.Vector([0.0, 0.0, 0.0]))
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 1 < i < tiles.nx - 2 and 1 < j < tiles.ny - 2:
                        c = i * tiles.ny + j
                        if (cloud.state[c, 0] == 0.0 and cloud.first[c, 0] == 0.0 and cloud.flux[c, 0, 0] == 0.0
                                and cloud.flux[c, 1, 0] == 0.0 and cloud.flux[c - tiles.ny, 0, 0] == 0.0
                                and cloud.flux[c - 1, 1, 0] == 0.0):
                            continue
                        s, w = slope_of(below, i, j), velocity_in(cloud, numbers, c)
                        cosine, own = cosine_in(below, i, j), cloud.own[c] > 0
                        V, ice = cloud.state[c, 0], cloud.state[c, 1]
                        got = step.dt / step.dx * gained(cloud, tiles, c)
                        push = ti.Vector([got[2], got[3]])
                        momentum = ti.Vector([cloud.state[c, 2], cloud.state[c, 3]]) + push
                        new, left = V + got[0], ice + got[1]
                        added = ti.max(0.0, -new) + ti.max(0.0, -left)
                        new, left = ti.max(0.0, new), ti.max(0.0, left)
                        pull, lost, taken = 0.0 * push, 0.0 * push, 0.0
                        if own:
                            speed = surface_speed(w[0], w[1], s[0], s[1])
                            pull = -step.dt * step.g * cosine**2 * numbers.excess * ice * s
                            momentum += pull
                            if new > LEAST:
                                # the air ahead takes of the momentum across the front, not of that along it
                                m = weight_of(numbers, new, left)
                                rise = ti.Vector([cloud.slopes[c, AHEAD], cloud.slopes[c, AHEAD + 1]])
                                up = rise - rise.dot(s) * cosine**2 * s
                                if new > V and momentum.dot(rise) < 0.0:
                                    still = numbers.front_drag * numbers.air
                                    across, before = momentum.dot(rise), V * w.dot(rise)
                                    change = (across + still * before) * (m / (m + still * new)) - across
                                    lost = change / rise.dot(up) * up
                                momentum += lost
                            if V > LEAST:
                                richardson = (numbers.excess / numbers.air * step.g * cosine**2 * ice
                                              / ti.max(speed * speed, 1e-12))
                                taken = step.dt * entrained(richardson) * speed / cosine
                                new += taken
                            if new > LEAST:
                                drag = drag_under(below, numbers, i, j) * speed / (cosine * new)
                                share = (numbers.air * new + numbers.excess * left) / weight_of(numbers, new, left)
                                # by the speed of the stage's start: a state of balance is one of the step as well
                                rubbed = momentum * (1.0 / (1.0 + step.dt * drag * share) - 1.0)
                                momentum += rubbed
                                lost += rubbed
                        if new <= LEAST:
                            lost -= momentum
                            momentum *= 0.0
                        if step.stage == 1:
                            new, left = 0.5 * (cloud.first[c, 0] + new), 0.5 * (cloud.first[c, 1] + left)
                            for k in ti.static(range(2)):
                                momentum[k] = 0.5 * (cloud.first[c, 2 + k] + momentum[k])
                        cloud.state[c, 0], cloud.state[c, 1] = new, left
                        cloud.state[c, 2], cloud.state[c, 3] = momentum[0], momentum[1]
                        filled += added
                        if own:
                            air += taken
                            pulled += in_space(pull, s)
                            pushes += in_space(push, s)
                            dragged += in_space(lost, s)
                            if step.stage == 1 and new > LEAST:
                                w = velocity_in(cloud, numbers, c)
                                told(cloud, numbers, c, cosine, surface_speed(w[0], w[1], s[0], s[1]))
                                rate = ti.max(rate, crossed(numbers, step, ti.Vector([new, left, w[0], w[1]]), s))
                report[tile, RATE] = rate
                report[tile, ADDED] += 0.5 * filled  # of either stage half counts in the end
                report[tile, AIR] += 0.5 * air
                for k in ti.static(range(3)):
                    report[tile, PULL + k] += 0.5 * pulled[k]
                    report[tile, FACES + k] += 0.5 * pushes[k]
                    report[tile, DRAG + k] += 0.5 * dragged[k]

    return Kernels(slope, cross, advance)
