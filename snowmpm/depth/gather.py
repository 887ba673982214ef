"""From the nodes back to the columns: their equation of motion over one step.

A column slides on the ground z = b(x): its velocity in plan w has the speed v^2 = |w|^2 + (w . s)^2, s = grad b, and

    dw/dt = -s (g + w.B w) / (1 + s^2) - grad phi + s (s . grad phi) / (1 + s^2) - friction,   B = grad grad b

(Lagrange's equations of a mass point on a surface; M^-1 = I - s s / (1 + s^2) for the plan metric M = I + s s). The
normal force of the ground per mass is N = cos (g + w.B w), not below 0, where w.B w, the centrifugal term, is
a choice. Friction
(`snowmpm.ground`) acts against the speed, dry (A) and growing with it (K v):

    v_new = max(0, v - dt A) / (1 + dt K),   K at the speed before the step

which stops a column without turning it back, holds one at rest, has the right steady speed for any dt, and is of second
order for drags with v^2. A column that stops within a step goes as far as until it stops.
"""

import functools
from typing import Any, NamedTuple

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, Real, grouped_kernel
from snowmpm.compiler.parallel import chunks, is_worker, worker
from snowmpm.depth.arrays import ColumnArrays, CoverArrays, GroundArrays, NodeArrays, Segments
from snowmpm.depth.nodes import NODE
from snowmpm.depth.plan_grid import MARGIN
from snowmpm.depth.scatter import INTAKE, SEGMENT, moved
from snowmpm.depth.spline import first_derivatives, second_derivatives, weights
from snowmpm.materials.parameters import named

SPEED2, WAVE2, LEFT, FRICTION_WORK, IMPULSE, TAKEN_UP, HEIGHT = 0, 1, 2, 3, 4, 6, 7
"""Columns of a segment's report: largest v^2 and c^2, columns that left, work taken by friction [J], impulse in plan of
ground and pressure (2) [N s], snow cover taken up [kg], and its sum of mass times height [kg m]."""
REPORT = 8

LEAST_DEPTH = 1e-3
"""Depth [m] below which friction takes a column for this deep."""


class Step(NamedTuple):
    """dt [s]; 1 / dx [1/m]; g [m/s2]; share of the centrifugal term that counts."""

    dt: Real
    inverse_dx: Real
    g: Real
    centrifugal: Real


@functools.cache
def gather_kernel(real, law, takes, load, serial):
    """Kernel that takes all columns through the second half of a step.

    law: class of the friction law (`snowmpm.ground`); takes: `law` of an `intake.Intake`, or None; load: class of a
    `column_load.ColumnLoad`, or None.
    """
    stress, names = law.stress, law.PARAMETERS
    intake: Any = takes.intake if takes else None
    cover_names = takes.PARAMETERS if takes else law.PARAMETERS
    taking = takes is not None
    n_numbers, n_cover = len(names._fields), len(cover_names._fields)
    loaded, parted = load is not None, load is not None and load.sets > 1
    pushed: Any = load.pushed(real) if load else None
    bears: Any = load.borne(real) if load else None
    n_beside, steep = (load.node_size - NODE, load.steep) if parted else (0, 0)

    @grouped_kernel(real)
    def gather(columns: ColumnArrays, nodes: NodeArrays, ground: GroundArrays, cover: CoverArrays, burden: Array,
               segments: Segments, step: Step):
        ti.loop_config(serialize=serial)
        for worker_at in range(chunks(segments.bounds)):
            if is_worker(worker_at):
                for segment in range(segments.bounds[worker(worker_at)], segments.bounds[worker(worker_at) + 1]):
                    speed2, wave2, left = ti.cast(0.0, real), ti.cast(0.0, real), 0
                    work, impulse = ti.cast(0.0, ti.f64), ti.Vector.zero(ti.f64, 2)
                    taken_up, height = ti.cast(0.0, ti.f64), ti.cast(0.0, ti.f64)
                    for p in range(segment * SEGMENT, ti.min((segment + 1) * SEGMENT, segments.n)):
                        cell = columns.cells[p]
                        column = columns.reals[p]
                        f, old = ti.Vector([column[0], column[1]]), ti.Vector([column[2], column[3]])
                        wx, wy = weights(f[0]), weights(f[1])
                        dx, dy = first_derivatives(f[0]), first_derivatives(f[1])
                        ddx, ddy = second_derivatives(f[0]), second_derivatives(f[1])
                        s, push, mean = ti.Vector.zero(real, 2), ti.Vector.zero(real, 2), ti.Vector.zero(real, 2)
                        bend = ti.Vector.zero(real, 3)
                        own, slope = 0, ti.Vector.zero(real, 2)
                        beside = ti.Vector.zero(real, ti.static(max(1, n_beside)))
                        if ti.static(parted):
                            own = nodes.set_of[columns.material[p]]
                        under = (cell[0] + MARGIN) * ground.stride + cell[1] + MARGIN
                        middle = ground.bed[under]
                        depth, rate, level = ti.cast(0.0, real), ti.cast(0.0, real), ti.cast(0.0, real)
                        for i in ti.static(range(3)):
                            row = own + nodes.lookup[0, cell[0] + (i - 1 + MARGIN)]
                            # sums along y first: b, b', b'' of the ground, phi and phi', depth, beta, beta u
                            heights, phi = ti.Vector.zero(real, 3), ti.Vector.zero(real, 2)
                            snow, beta = ti.cast(0.0, real), ti.Vector.zero(real, 3)
                            for j in ti.static(range(3)):
                                values = nodes.values[row + nodes.lookup[1, cell[1] + (j - 1 + MARGIN)]]
                                b = ti.cast(ground.bed[under + (i - 1) * ground.stride + (j - 1)] - middle, real)
                                heights += b * ti.Vector([wy[j], dy[j], ddy[j]])
                                phi += values[0] * ti.Vector([wy[j], dy[j]])
                                snow += values[1] * wy[j]
                                if ti.static(parted):
                                    for k in ti.static(range(n_beside)):
                                        beside[k] += values[NODE + k] * wx[i] * wy[j]
                                    slope += values[steep] * ti.Vector([dx[i] * wy[j], wx[i] * dy[j]])
                                beta += wy[j] * ti.Vector([values[2], values[3], values[4]])
                            level += wx[i] * heights[0]
                            s += ti.Vector([dx[i] * heights[0], wx[i] * heights[1]])
                            bend += ti.Vector([ddx[i] * heights[0], wx[i] * heights[2], dx[i] * heights[1]])
                            push += ti.Vector([dx[i] * phi[0], wx[i] * phi[1]])
                            depth += wx[i] * snow
                            rate += wx[i] * beta[0]
                            mean += wx[i] * ti.Vector([beta[1], beta[2]])
                        if ti.static(parted):
                            push = pushed(burden, p, beside, slope, push)
                        s, push, bend = s * step.inverse_dx, push * step.inverse_dx, bend * step.inverse_dx**2
                        metric = 1.0 + s.dot(s)
                        cosine = 1.0 / ti.sqrt(metric)
                        # midpoint rule, since the ground's curvature makes the force depend on the velocity
                        across = push - s * (s.dot(push) / metric)
                        turn = bend[0] * old[0] ** 2 + bend[1] * old[1] ** 2 + 2.0 * bend[2] * old[0] * old[1]
                        half = old - 0.5 * step.dt * (s * ((step.g + turn) / metric) + across)
                        turn = bend[0] * half[0] ** 2 + bend[1] * half[1] ** 2 + 2.0 * bend[2] * half[0] * half[1]
                        new = old - step.dt * (s * ((step.g + turn) / metric) + across)
                        new += mean - rate * old
                        speed = ti.sqrt(new.dot(new) + new.dot(s) ** 2)
                        before = ti.sqrt(old.dot(old) + old.dot(s) ** 2)
                        normal = cosine * (step.g + step.centrifugal * turn)
                        if normal < 0.0:
                            normal = ti.cast(0.0, real)
                        thickness = ti.max(LEAST_DEPTH, depth * cosine)
                        rho = ti.cast(columns.density[columns.material[p]], real)
                        at = ground.place[nodes.lookup[0, cell[0] + MARGIN] + nodes.lookup[1, cell[1] + MARGIN]]
                        if at < 0:
                            left, at = left + 1, 0
                        numbers = ti.Vector([ti.cast(ground.friction[at, k], real)
                                             for k in ti.static(range(n_numbers))])
                        own_rho, own_share, dry_part = rho, ti.cast(1.0, real), ti.cast(1.0, real)
                        sigma = rho * normal * thickness
                        if ti.static(loaded):
                            found = bears(burden, p, own, rho, beside, depth, normal, thickness)
                            rho, own_rho, own_share, dry_part, sigma = found[0], found[1], found[2], found[3], found[4]
                        tau = stress(named(names, numbers), rho, sigma, before, thickness)
                        weight = rho * thickness
                        if ti.static(parted):
                            tau[0] *= dry_part
                            rho = ti.cast(columns.density[columns.material[p]], real)
                        mass, volume, wanted, taken = rho * column[4], column[4], ti.cast(0.0, real), ti.cast(0.0, real)
                        here = nodes.lookup[0, cell[0] + MARGIN] + nodes.lookup[1, cell[1] + MARGIN]
                        bed_numbers = ti.Vector.zero(real, n_cover)
                        if ti.static(taking):
                            for k in ti.static(range(n_cover)):
                                bed_numbers[k] = ti.cast(cover.numbers[cover.place[here], k], real)
                            share = nodes.values[own + here][NODE - 1]
                            taken = step.dt * column[INTAKE] * share
                            # by the friction of its weight: see `volumes.kernels`
                            sigma = ti.max(ti.cast(0.0, real), sigma - rho * thickness * (normal - cosine * step.g))
                            pull = stress(named(names, numbers), own_rho, sigma, before, thickness)
                            borne = intake(named(cover_names, bed_numbers), own_rho, pull[0] + pull[1] * before, before,
                                           thickness)[1]
                            tau *= 1.0 + share * (borne - 1.0)
                        slowed = ti.max(0.0, speed - step.dt * tau[0] / weight) / (1.0 + step.dt * tau[1] / weight)
                        if tau[1] < 0.0:  # a law that weakens with speed
                            slowed = ti.max(0.0, speed - step.dt * (tau[0] + tau[1] * before) / weight)
                        slid = slowed
                        slowed *= mass / (mass + taken)
                        kept = slowed / ti.max(speed, 1e-30)
                        new *= kept
                        # curvature again, at the mean of the velocities before and after friction
                        half = 0.5 * (old + new)
                        again = bend[0] * half[0] ** 2 + bend[1] * half[1] ** 2 + 2.0 * bend[2] * half[0] * half[1]
                        new -= kept * step.dt * s * ((again - turn) / metric)
                        if ti.static(taking):
                            # wanted in the next step, at its middle if speed and volume go on like this
                            next_speed = ti.max(0.0, 1.5 * slowed - 0.5 * before)
                            pull = stress(named(names, numbers), own_rho, sigma, next_speed, thickness)
                            wanted = (volume + 1.5 * taken / rho) / thickness * intake(
                                named(cover_names, bed_numbers), own_rho, pull[0] + pull[1] * next_speed, next_speed,
                                thickness)[0]
                            if ti.static(parted):
                                wanted /= own_share
                        heavier = ti.cast(mass + taken, ti.f64)
                        stop = ti.cast(1.0, real)  # share of the step until it stopped
                        if slowed <= 0.0 and speed > 0.0:
                            stop = speed * weight / (step.dt * (tau[0] + ti.min(0.0, tau[1]) * before))
                        # its impulse times the mean speed, and what taking up snow at rest costs
                        given = (ti.cast(before + slid, ti.f64) * (ti.cast(speed, ti.f64) - slid)
                                 - ti.cast((1.0 - stop) * before, ti.f64) * (ti.cast(speed, ti.f64) - before))
                        work += 0.5 * (mass * (given + ti.cast(slid, ti.f64) ** 2)
                                       - heavier * ti.cast(slowed, ti.f64) ** 2)
                        taken_up += ti.cast(taken, ti.f64)
                        height += ti.cast(taken, ti.f64) * (middle + ti.cast(level, ti.f64))
                        volume += taken / rho
                        # one that stopped within the step goes no further than that
                        cell, f = moved(cell, f, 0.5 * step.dt * step.inverse_dx * (new - (1.0 - stop) * old))
                        speed2 = ti.max(speed2, slowed**2)
                        wave2 = ti.max(wave2, step.g * depth / metric)
                        for a in ti.static(range(2)):
                            at_node = ti.cast(cell[a], real) + f[a] + 0.5
                            if ground.walls[a, 0] == 1 and at_node < 0.0:
                                cell[a], f[a], new[a] = -1 - cell[a], -f[a], -new[a]
                            elif ground.walls[a, 1] == 1 and at_node >= ground.walls[a, 2]:
                                cell[a], f[a], new[a] = 2 * ground.walls[a, 2] - 1 - cell[a], -f[a], -new[a]
                            elif ground.walls[a, 3] == 1:
                                if cell[a] < 0:
                                    cell[a] += ground.walls[a, 2]
                                elif cell[a] >= ground.walls[a, 2]:
                                    cell[a] -= ground.walls[a, 2]
                            elif at_node < 0.0 or at_node >= ground.walls[a, 2]:
                                left += 1
                        for a in ti.static(range(2)):
                            impulse[a] += heavier * ti.cast(new[a], ti.f64) - ti.cast(mass * old[a], ti.f64)
                        columns.cells[p] = cell
                        columns.reals[p] = ti.Vector([f[0], f[1], new[0], new[1], volume, depth * cosine, new.dot(s),
                                                      wanted])
                    segments.report[segment, SPEED2], segments.report[segment, WAVE2] = speed2, wave2
                    segments.report[segment, LEFT] = left
                    segments.report[segment, FRICTION_WORK] = work
                    segments.report[segment, TAKEN_UP], segments.report[segment, HEIGHT] = taken_up, height
                    for a in ti.static(range(2)):
                        segments.report[segment, IMPULSE + a] = impulse[a]

    return gather
