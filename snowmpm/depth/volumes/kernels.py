"""One step of finite volumes for a flow over steep ground, of second order in space and time.

With H = h / cos the volume over a unit of plan, w the velocity in plan, s = grad b the slope of the ground and
G^-1 = I - s s / (1 + s^2) the inverse of the metric of its surface, a flow of thickness h normal to the ground obeys

    dH/dt + div(H w) = 0
    d(H w)/dt + div(H w w) = -(1 / cos) G^-1 grad P - H cos^2 (g + w.B w) s - friction,   P = g cos h^2 / 2,  B = grad s

(Savage and Hutter 1989, doi:10.1017/S0022112089000340, on curved ground as Bouchut et al. 2003,
doi:10.1016/S1631-073X(03)00117-1; columns, `depth.gather`, have the pressure of cos^2 H, which differs by H grad cos).
A step:

    friction dt/2;  slopes of H and w, each limited (`planes.limited`);  H and w half a step later in each cell
    (MUSCL-Hancock, van Leer 1984, doi:10.1137/0905001);  fluxes between cells by HLLC (Toro 2001, ISBN 0-471-98766-1,
    section 10.6), with the speed of a front on dry ground;  gravity;  friction dt/2

The metric of a face is that of the mean slope of its cells. What a face pushes is counted against the pressure within
each cell, so that even snow on bent ground is not pushed. What crosses a face is turned from the plane of one cell into
that of the other without a change of its speed, which is the term w.B w: bends as sharp as the cells, as gullies have
them, neither add energy nor take any. Cells at rest whose drive is below the dry friction are held: no mass crosses the
face between two of them, so that a deposit does not creep.
"""

import functools
from typing import Any, NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import strided, strides
from snowmpm.depth.arrays import CoverArrays
from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.volumes.arrays import (
    DRIVEN,
    DRY,
    FLUX,
    HEIGHT,
    HELD,
    LEAST_DEPTH,
    RATE,
    SLOPES,
    SPEED2,
    TAKEN_UP,
    TILE,
    WORK,
    Cells,
    Friction,
    Step,
    Tiles,
)
from snowmpm.depth.volumes.planes import carried, limited, slope_at, surface_speed, velocity_of
from snowmpm.materials.parameters import named


class Kernels(NamedTuple):
    """Those of a step, in their order."""

    rub: object
    predict: object
    cross: object
    drain: object
    update: object


@functools.cache
def kernels(real, law, takes, serial):
    """`Kernels` for a law of friction (`snowmpm.ground`). takes: `law` of an `intake.Intake`, or None."""
    stress, names = law.stress, law.PARAMETERS
    intake: Any = takes.intake if takes else None
    cover_names = takes.PARAMETERS if takes else law.PARAMETERS
    taking = takes is not None
    n_numbers, n_cover = len(names._fields), len(cover_names._fields)

    @ti.func
    def within(tiles: ti.template(), i, j):
        """Whether a cell lies within the sides. Those beyond are images of such cells, or snow that leaves."""
        return MARGIN <= i < tiles.nx - MARGIN and MARGIN <= j < tiles.ny - MARGIN

    @ti.func
    def of_cover(cover: ti.template(), node):
        """Numbers of the snow cover at a node."""
        return ti.Vector([ti.cast(cover.numbers[cover.place[node], k], real) for k in ti.static(range(n_cover))])

    @ti.func
    def normal_of(cells: ti.template(), step: ti.template(), c, u, v):
        """Acceleration with which snow presses on the ground [m/s2]."""
        turn = cells.ground[c, 2] * u * u + cells.ground[c, 3] * v * v + 2.0 * cells.ground[c, 4] * u * v
        return ti.max(0.0 * u, cells.ground[c, 5] * (step.g + step.centrifugal * turn))

    @ti.func
    def resisted(cells: ti.template(), friction: ti.template(), cover: ti.template(), step: ti.template(), c, snow, dt):
        """u, v of snow (H, u, v) after friction for dt, dry resistance [m/s2] at rest, and the work of friction over
        rho and plan."""
        H, u, v = snow[0], snow[1], snow[2]
        sx, sy, cosine = cells.ground[c, 0], cells.ground[c, 1], cells.ground[c, 5]
        normal = normal_of(cells, step, c, u, v)
        depth = ti.max(ti.cast(LEAST_DEPTH, real), H * cosine)
        node = friction.node[c]
        at = ti.max(friction.place[node], 0)
        numbers = ti.Vector([ti.cast(friction.numbers[at, k], real) for k in ti.static(range(n_numbers))])
        speed = surface_speed(u, v, sx, sy)
        weight = friction.rho * depth
        tau = stress(named(names, numbers), friction.rho, weight * normal, speed, depth)
        if ti.static(taking):
            lasts = cover.mass[node] > 0.0
            if lasts:
                pull = stress(named(names, numbers), friction.rho, weight * cosine * step.g, speed, depth)
                tau *= intake(named(cover_names, of_cover(cover, node)), friction.rho, pull[0] + pull[1] * speed, speed,
                              depth)[1]
        slowed = ti.max(0.0 * H, speed - dt * tau[0] / weight) / (1.0 + dt * tau[1] / weight)
        if tau[1] < 0.0:  # a law that weakens with speed
            slowed = ti.max(0.0 * H, speed - dt * (tau[0] + tau[1] * speed) / weight)
        kept = slowed / ti.max(speed, ti.cast(1e-30, real))
        return ti.Vector([u * kept, v * kept, tau[0] / weight, 0.5 * H * (speed * speed - slowed * slowed)])

    @ti.func
    def pull_of(cells: ti.template(), friction: ti.template(), cover: ti.template(), step: ti.template(), c, H, u, v):
        """Snow cover [kg/m2 over plan, s] that a flow of depth H and velocity u, v would take up: by the friction of
        its weight. With that of the ground's bends, hollows would deepen that the flow makes itself, the faster the
        shorter they are."""
        cosine, node = cells.ground[c, 5], friction.node[c]
        depth, speed = (ti.max(ti.cast(LEAST_DEPTH, real), H * cosine),
                        surface_speed(u, v, cells.ground[c, 0], cells.ground[c, 1]))
        at = ti.max(friction.place[node], 0)
        numbers = ti.Vector([ti.cast(friction.numbers[at, k], real) for k in ti.static(range(n_numbers))])
        sigma = friction.rho * depth * cosine * step.g
        tau = stress(named(names, numbers), friction.rho, sigma, speed, depth)
        return intake(named(cover_names, of_cover(cover, node)), friction.rho, tau[0] + tau[1] * speed, speed,
                      depth)[0] / cosine

    @grouped_kernel(real)
    def rub(cells: Cells, friction: Friction, cover: CoverArrays, tiles: Tiles, step: Step, report: Array):
        """Friction for half a step; which cells are held."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                work = ti.cast(0.0, ti.f64)
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 0 < i < tiles.nx - 1 and 0 < j < tiles.ny - 1:
                        c = i * tiles.ny + j
                        H, u, v = cells.state[c, 0], cells.state[c, 1], cells.state[c, 2]
                        cells.held[c] = HELD
                        if H > DRY:
                            sx, sy, cosine = cells.ground[c, 0], cells.ground[c, 1], cells.ground[c, 5]
                            found = resisted(cells, friction, cover, step, c, ti.Vector([H, u, v]), 0.5 * step.dt)
                            state = 0
                            if found[0] == 0.0 and found[1] == 0.0:
                                # the steeper side counts: the edge of a deposit must be able to give way
                                up, down = cells.state[c + tiles.ny, 0] - H, H - cells.state[c - tiles.ny, 0]
                                left, right = cells.state[c + 1, 0] - H, H - cells.state[c - 1, 0]
                                gx = ti.select(ti.abs(up) > ti.abs(down), up, down) / step.dx
                                gy = ti.select(ti.abs(left) > ti.abs(right), left, right) / step.dx
                                push = step.g * cosine * cosine
                                along = cosine * cosine * (gx * sx + gy * sy)
                                ax, ay = -push * (gx - along * sx + sx), -push * (gy - along * sy + sy)
                                if surface_speed(ax, ay, sx, sy) > found[2]:
                                    state = DRIVEN
                                elif u == 0.0 and v == 0.0:
                                    state = HELD
                            if state == 0:
                                if within(tiles, i, j):
                                    work += ti.cast(found[3], ti.f64)
                                cells.state[c, 1], cells.state[c, 2] = found[0], found[1]
                            cells.held[c] = state
                report[tile, WORK] += work

    @ti.func
    def slopes_along(cells: ti.template(), c, step):
        """Limited differences of H, u, v across cell c, whose neighbours are `step` apart. Velocities of neighbours are
        turned into the plane of the cell, so that the ground's bends are no differences; dry ones have none."""
        H, own, cosine, up, down = cells.state[c, 0], slope_at(cells, c), cells.ground[c, 5], c + step, c - step
        w = velocity_of(cells, c)
        ahead = carried(velocity_of(cells, up), slope_at(cells, up), cells.ground[up, 5], own, cosine)
        behind = carried(velocity_of(cells, down), slope_at(cells, down), cells.ground[down, 5], own, cosine)
        found = ti.Vector([limited(cells.state[up, 0] - H, H - cells.state[down, 0]), 0.0 * H, 0.0 * H])
        if cells.state[up, 0] > DRY and cells.state[down, 0] > DRY:
            for k in ti.static(range(2)):
                found[1 + k] = limited(ahead[k] - w[k], w[k] - behind[k])
        return found

    @grouped_kernel(real)
    def predict(cells: Cells, tiles: Tiles, step: Step):
        """Slopes, and each cell half a step later by itself."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 0 < i < tiles.nx - 1 and 0 < j < tiles.ny - 1:
                        c = i * tiles.ny + j
                        H, u, v = cells.state[c, 0], cells.state[c, 1], cells.state[c, 2]
                        slopes = ti.Vector.zero(real, SLOPES)
                        ahead = ti.Vector([H, u, v])
                        if H > DRY and cells.held[c] != HELD:
                            along_x, along_y = slopes_along(cells, c, tiles.ny), slopes_along(cells, c, 1)
                            for k in ti.static(range(3)):
                                slopes[k], slopes[3 + k] = along_x[k], along_y[k]
                            sx, sy, cosine = cells.ground[c, 0], cells.ground[c, 1], cells.ground[c, 5]
                            cos2 = cosine * cosine
                            along = cos2 * (slopes[0] * sx + slopes[3] * sy)
                            push, pull = step.g * cos2, cos2 * step.g * step.dx
                            half = 0.5 * step.dt / step.dx
                            ahead[0] = ti.max(0.0 * H, H - half * (u * slopes[0] + H * slopes[1] + v * slopes[3]
                                                                   + H * slopes[5]))
                            ahead[1] = u - half * (u * slopes[1] + v * slopes[4] + push * (slopes[0] - along * sx)
                                                   + pull * sx)
                            ahead[2] = v - half * (u * slopes[2] + v * slopes[5] + push * (slopes[3] - along * sy)
                                                   + pull * sy)
                            if ahead[0] < 0.5 * ti.max(ti.abs(slopes[0]), ti.abs(slopes[3])):
                                # no depth below zero at a face
                                for a in ti.static(range(2)):
                                    most = 2.0 * ahead[0]
                                    slopes[3 * a] = ti.max(-most, ti.min(most, slopes[3 * a]))
                        for k in ti.static(range(3)):
                            cells.ahead[c, k] = ahead[k]
                        for k in ti.static(range(SLOPES)):
                            cells.slopes[c, k] = slopes[k]

    @ti.func
    def face(cells: ti.template(), step: ti.template(), a, b, axis: ti.template()):
        """What crosses the face between the cells a and b along an axis, per length of face (`Cells.flux`)."""
        n, t = ti.static(1 + axis), ti.static(2 - axis)
        flux = ti.Vector.zero(real, FLUX)
        HL = cells.ahead[a, 0] + 0.5 * cells.slopes[a, 3 * axis]
        HR = cells.ahead[b, 0] - 0.5 * cells.slopes[b, 3 * axis]
        if HL > DRY or HR > DRY:
            sx = 0.5 * (cells.ground[a, 0] + cells.ground[b, 0])
            sy = 0.5 * (cells.ground[a, 1] + cells.ground[b, 1])
            across = ti.select(axis == 0, sy, sx)
            cosine = 1.0 / ti.sqrt(1.0 + sx * sx + sy * sy)
            metric = cosine * (1.0 + across * across)
            mean, first = ti.Vector([sx, sy]), 3 * axis
            left, right = ti.Vector.zero(real, 2), ti.Vector.zero(real, 2)
            # the other face's depth weighs, so that the momentum of both is that of the cell
            behind = 0.5 * (cells.ahead[a, 0] - 0.5 * cells.slopes[a, first]) / ti.max(cells.ahead[a, 0], DRY)
            beyond = 0.5 * (cells.ahead[b, 0] + 0.5 * cells.slopes[b, first]) / ti.max(cells.ahead[b, 0], DRY)
            for k in ti.static(range(2)):
                left[k] = cells.ahead[a, 1 + k] + behind * cells.slopes[a, first + 1 + k]
                right[k] = cells.ahead[b, 1 + k] - beyond * cells.slopes[b, first + 1 + k]
            left = carried(left, slope_at(cells, a), cells.ground[a, 5], mean, cosine)
            right = carried(right, slope_at(cells, b), cells.ground[b, 5], mean, cosine)
            uL, uR, vL, vR = left[n - 1], right[n - 1], left[t - 1], right[t - 1]
            stiff = step.g * cosine**3
            pL, pR = 0.5 * stiff * HL * HL, 0.5 * stiff * HR * HR
            cL, cR = ti.sqrt(metric * stiff * HL), ti.sqrt(metric * stiff * HR)
            middle, wave = 0.5 * (uL + uR) + cL - cR, 0.5 * (cL + cR) + 0.25 * (uL - uR)
            low = ti.min(uL - cL, middle - ti.abs(wave))
            high = ti.max(uR + cR, middle + ti.abs(wave))
            if HL <= DRY:  # dry ground is reached at the speed of its front
                low, high = uR - 2.0 * cR, uR + cR
            if HR <= DRY:
                low, high = uL - cL, uL + 2.0 * cL
            low, high = ti.min(low, 0.0), ti.max(high, 0.0)
            wide = 1.0 / ti.max(high - low, ti.cast(1e-12, real))
            mass = (high * HL * uL - low * HR * uR + low * high * (HR - HL)) * wide
            flux[1] = (high * (HL * uL * uL + metric * pL) - low * (HR * uR * uR + metric * pR)
                       + low * high * (HR * uR - HL * uL)) * wide
            flux[3] = (high * pL - low * pR) * wide  # as much of either side as counts in the momentum
            if cells.held[a] == HELD and cells.held[b] == HELD:
                mass = 0.0 * mass
            flux[0] = mass
            flux[2] = mass * ti.select(mass > 0.0, vL, vR)
        return flux

    @grouped_kernel(real)
    def cross(cells: Cells, tiles: Tiles, step: Step):
        """Fluxes of the faces towards +x and +y."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 0 < i < tiles.nx - 2 and 0 < j < tiles.ny - 2:
                        c = i * tiles.ny + j
                        x, y = face(cells, step, c, c + tiles.ny, 0), face(cells, step, c, c + 1, 1)
                        for k in ti.static(range(FLUX)):
                            cells.flux[c, 0, k], cells.flux[c, 1, k] = x[k], y[k]

    @grouped_kernel(real)
    def drain(cells: Cells, tiles: Tiles, step: Step):
        """Which share of its outflow a cell has."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 1 < i < tiles.nx - 2 and 1 < j < tiles.ny - 2:
                        c, none = i * tiles.ny + j, ti.cast(0.0, real)
                        out = (ti.max(cells.flux[c, 0, 0], none) - ti.min(cells.flux[c - tiles.ny, 0, 0], none)
                               + ti.max(cells.flux[c, 1, 0], none) - ti.min(cells.flux[c - 1, 1, 0], none))
                        there = cells.state[c, 0] * step.dx / step.dt
                        # the rest of a film goes along, so that no dust is left behind
                        empties = out > 0.0 and there - out < ti.cast(DRY, real) * step.dx / step.dt
                        cells.share[c] = there / out if empties else ti.cast(1.0, real)

    @ti.func
    def kept_back(cells: ti.template(), a, b, axis: ti.template()):
        """The share of the flux from a to b that its giver does not have."""
        return 1.0 - ti.select(cells.flux[a, axis, 0] > 0.0, cells.share[a], cells.share[b])

    @ti.func
    def crossing(cells: ti.template(), a, b, axis: ti.template()):
        """Mass that goes from a to b."""
        return cells.flux[a, axis, 0] * (1.0 - kept_back(cells, a, b, axis))

    @ti.func
    def pushed(cells: ti.template(), step: ti.template(), a, b, c, axis: ti.template()):
        """Momentum (2) that crosses the face from a to b into or out of c, against the pressure in c."""
        sx = 0.5 * (cells.ground[a, 0] + cells.ground[b, 0])
        sy = 0.5 * (cells.ground[a, 1] + cells.ground[b, 1])
        cosine = 1.0 / ti.sqrt(1.0 + sx * sx + sy * sy)
        across = ti.select(axis == 0, sy, sx)
        stiff = step.g * cells.ground[c, 5] ** 3
        own = 0.5 * stiff * cells.ahead[c, 0] ** 2
        less = kept_back(cells, a, b, axis)
        giver = ti.select(cells.flux[a, axis, 0] > 0.0, cells.ahead[a, 1 + axis], cells.ahead[b, 1 + axis])
        n, t = (cells.flux[a, axis, 1] - less * cells.flux[a, axis, 0] * giver - cosine * (1.0 + across * across) * own,
                (1.0 - less) * cells.flux[a, axis, 2] - cosine * sx * sy * (cells.flux[a, axis, 3] - own))
        if cells.held[a] == HELD and cells.held[b] == HELD:
            # As what holds it is reckoned, by the gradient: deep snow that stands does not push a film beside it away
            other = ti.select(c == a, cells.ahead[b, 0], cells.ahead[a, 0])
            excess = 0.5 * stiff * cells.ahead[c, 0] * (other - cells.ahead[c, 0])
            n, t = cosine * (1.0 + across * across) * excess, -cosine * sx * sy * excess
        return carried(ti.Vector([n, t] if ti.static(axis == 0) else [t, n]), ti.Vector([sx, sy]), cosine,
                       slope_at(cells, c), cells.ground[c, 5])

    @grouped_kernel(real)
    def update(cells: Cells, friction: Friction, cover: CoverArrays, heights: Array, tiles: Tiles, step: Step,
               report: Array):
        """What crossed the faces, gravity, the second half of friction, and snow cover that is taken up."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                rate, work, fastest = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
                taken_up, height = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    if 1 < i < tiles.nx - 2 and 1 < j < tiles.ny - 2:
                        c = i * tiles.ny + j
                        H, u, v = cells.state[c, 0], cells.state[c, 1], cells.state[c, 2]
                        left, below = c - tiles.ny, c - 1
                        if (H == 0.0 and cells.flux[c, 0, 0] == 0.0 and cells.flux[c, 1, 0] == 0.0
                                and cells.flux[left, 0, 0] == 0.0 and cells.flux[below, 1, 0] == 0.0):
                            continue
                        share = step.dt / step.dx
                        gain = (crossing(cells, left, c, 0) - crossing(cells, c, c + tiles.ny, 0)
                                + crossing(cells, below, c, 1) - crossing(cells, c, c + 1, 1))
                        into, out = pushed(cells, step, left, c, c, 0), pushed(cells, step, c, c + tiles.ny, c, 0)
                        under, over = pushed(cells, step, below, c, c, 1), pushed(cells, step, c, c + 1, c, 1)
                        new = ti.max(0.0 * H, H + share * gain)
                        sx, sy, cosine = cells.ground[c, 0], cells.ground[c, 1], cells.ground[c, 5]
                        # of the mean mass: what is left of a cell that runs dry does not bear the pull of all
                        pull = 0.5 * step.dt * (H + new) * cosine * cosine * step.g
                        mx = H * u + share * (into[0] - out[0] + under[0] - over[0]) - pull * sx
                        my = H * v + share * (into[1] - out[1] + under[1] - over[1]) - pull * sy
                        # where the first half did not act, all of it is due here
                        rest = ti.select(cells.held[c] > 0, 1.0, 0.5) * step.dt
                        u, v = 0.0 * H, 0.0 * H
                        if new > DRY:
                            u, v = mx / new, my / new
                        if new > DRY and (u != 0.0 or v != 0.0):
                            found = resisted(cells, friction, cover, step, c, ti.Vector([new, u, v]), rest)
                            u, v = found[0], found[1]
                            own = within(tiles, i, j)
                            if own:
                                work += ti.cast(found[3], ti.f64)
                            if ti.static(taking):
                                node, area = friction.node[c], ti.cast(step.dx * step.dx, ti.f64)
                                speed = surface_speed(u, v, sx, sy)
                                if own and cover.mass[node] > 0.0 and speed > 0.0:
                                    # by the midpoint rule, since what is taken up makes the flow deeper and slower
                                    half = 1.0 + 0.5 * step.dt / (friction.rho * new) * pull_of(
                                        cells, friction, cover, step, c, new, u, v)
                                    wanted = step.dt * pull_of(cells, friction, cover, step, c, new * half, u / half,
                                                               v / half)
                                    taken = ti.min(ti.cast(wanted, ti.f64) * area, cover.mass[node])
                                    cover.mass[node] -= taken
                                    heights[c] -= taken * cover.lowering[node]
                                    taken_up += taken
                                    height += taken * heights[c]
                                    deeper = new + ti.cast(taken / (ti.cast(friction.rho, ti.f64) * area), real)
                                    slower = new / deeper
                                    work += 0.5 * ti.cast(new * speed * speed * (1.0 - slower), ti.f64)
                                    new, u, v = deeper, u * slower, v * slower
                        cells.state[c, 0], cells.state[c, 1], cells.state[c, 2] = new, u, v
                        if new > DRY:
                            wave = ti.sqrt(step.g * new * cosine**4)
                            wide = wave * (ti.sqrt(1.0 + sx * sx) + ti.sqrt(1.0 + sy * sy))
                            rate = ti.max(rate, ti.cast((ti.abs(u) + ti.abs(v) + wide) / step.dx, ti.f64))
                            fastest = ti.max(fastest, ti.cast(surface_speed(u, v, sx, sy) ** 2, ti.f64))
                report[tile, RATE], report[tile, SPEED2] = rate, fastest
                report[tile, TAKEN_UP], report[tile, HEIGHT] = taken_up, height
                report[tile, WORK] += work

    return Kernels(rub, predict, cross, drain, update)
