"""What flow and cloud exchange in a step: ice and momentum, each as much as the other loses.

    suspension   m12 of `closures.SUSPENSION`, with the velocity of the flow
    settling     m21 = rho_i w_s r_0 c on a unit of plan, with the velocity of the cloud: to the flow where it moves, to
                 the ground elsewhere
    drag         tau_12 = C_12 rho_2 |u_1 - u_2| (u_1 - u_2), where the flow moves

Each is solved by itself over the step: settling as I exp(-w_s r_0 t / V), drag as the decay of the difference of two
velocities. The flow is what its numbers can hold: mass and momentum that the cloud gets are those that the flow lost as
it is rounded. A cloud with less ice than DISPERSE goes over into the air.
"""

import functools

from snowmpm.compiler import ti
from snowmpm.compiler.groups import Array, grouped_kernel
from snowmpm.compiler.parallel import strided, strides
from snowmpm.components.powder_layer.arrays import (
    DISPERSED,
    DOWN,
    DUST,
    LAID,
    LIFT,
    RATE,
    TO_CORE,
    TO_GROUND,
    UP,
    WORK,
    Below,
    Cloud,
    Numbers,
    Step,
    Tiles,
)
from snowmpm.components.powder_layer.closures import BED, SUSPENSION
from snowmpm.components.powder_layer.kernels import (
    COVERED,
    LEAST,
    cosine_of,
    crossed,
    slope_of,
    velocity_in,
    weight_of,
)
from snowmpm.depth.kernel_api import TILE, surface_speed

DISPERSE = 1e-6
"""Ice [kg/m2] below which a cell holds no cloud."""
MOST = 0.5
"""Share of the flow in a cell that may leave it in a step."""


@functools.cache
def exchange_kernel(real, suspension, bed, serial):
    """Kernel of an exchange. real: type of the flow's numbers; suspension, bed: names of `closures`. The report has the
    numbers of `arrays.PASSING`, and as the last one RATE's of a step."""
    suspended, near_bed = ti.func(SUSPENSION[suspension]), ti.func(BED[bed])

    @ti.func
    def core_momentum(core):
        """H w of the flow in a cell (H, u, v)."""
        return core[0] * ti.Vector([core[1], core[2]])

    @ti.func
    def rounded(core):
        """What the flow's numbers hold."""
        return ti.cast(ti.cast(core, real), ti.f64)

    @ti.func
    def lift(below: ti.template(), step: ti.template(), i, j, core, cosine):
        """Potential energy of a cell (H, u, v) over plan [J/m2]."""
        return below.rho * step.g * core[0] * (ti.cast(below.heights[i, j], ti.f64) + 0.5 * cosine**2 * core[0])

    @ti.func
    def rise(below: ti.template(), numbers: ti.template(), step: ti.template(), core, w, s):
        """What goes into the cloud from a cell (H, u, v) of the flow in a step -> the cell after."""
        slip = ti.Vector([core[1] - w[0], core[2] - w[1]])
        apart = surface_speed(slip[0], slip[1], s[0], s[1])
        state = ti.Vector([below.rho, surface_speed(core[1], core[2], s[0], s[1]), apart,
                           numbers.core_drag * numbers.air * apart * apart])
        rate = suspended(state, numbers.rate, numbers.stress) / cosine_of(s)
        most = ti.min(step.dt * rate / below.rho, MOST * core[0])
        return rounded(ti.Vector([core[0] - most, core[1], core[2]]))

    @ti.func
    def falling(cloud: ti.template(), numbers: ti.template(), step: ti.template(), c, w, s):
        """Volume of ice over plan [m] that settles in a step."""
        V, ice = ti.max(cloud.state[c, 0], LEAST), cloud.state[c, 1]
        shear = ti.sqrt(numbers.ground_drag) * surface_speed(w[0], w[1], s[0], s[1])
        most = near_bed(shear / ti.max(numbers.fall, 1e-12))
        return ice * (1.0 - ti.exp(-step.dt * numbers.fall * most / V))

    @ti.func
    def dragged(numbers: ti.template(), step: ti.template(), masses, slip, s, density):
        """Momentum (2) that the flow gives the cloud in a step; masses (2) over plan; slip: u_1 - u_2."""
        both = masses[0] * masses[1] / (masses[0] + masses[1])
        rate = numbers.core_drag * density / (cosine_of(s) * both)
        fast = step.dt * rate * surface_speed(slip[0], slip[1], s[0], s[1])
        return both * slip * (fast / (1.0 + fast))

    @grouped_kernel(ti.f64)
    def exchange(cloud: Cloud, below: Below, tiles: Tiles, numbers: Numbers, step: Step, report: Array):
        """Let flow and cloud exchange for dt."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                rate = 0.0
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    c = i * tiles.ny + j
                    if i < tiles.nx and j < tiles.ny and cloud.own[c] > 0:
                        core = ti.Vector([ti.cast(below.state[i, j, k], ti.f64) for k in ti.static(range(3))])
                        moves = core[0] >= COVERED and (core[1] != 0.0 or core[2] != 0.0)
                        if moves or cloud.state[c, 0] > 0.0:
                            s = slope_of(below, i, j)
                            was, ice, gain = core, cloud.state[c, 1], ti.Vector([0.0, 0.0])
                            if moves:
                                core = rise(below, numbers, step, core, velocity_in(cloud, numbers, c), s)
                                up = below.rho * (was[0] - core[0])
                                report[tile, UP] += up
                                ice += up / numbers.ice
                                cloud.state[c, 0] += up / numbers.ice
                                gain = below.rho * (core_momentum(was) - core_momentum(core))
                                cloud.state[c, 2] += gain[0]
                                cloud.state[c, 3] += gain[1]
                                cloud.state[c, 1] = ice
                            # settling
                            w = velocity_in(cloud, numbers, c)
                            fallen = falling(cloud, numbers, step, c, w, s)
                            mass, left = numbers.ice * fallen, ti.Vector([0.0, 0.0])
                            if fallen > 0.0:
                                if moves:
                                    deep = rounded(ti.Vector([core[0] + mass / below.rho, 0.0, 0.0]))[0]
                                    mass = below.rho * (deep - core[0])
                                    if mass < numbers.ice * ice:
                                        mixed = (below.rho * core_momentum(core) + mass * w) / (below.rho * deep)
                                        after = rounded(ti.Vector([deep, mixed[0], mixed[1]]))
                                        left = below.rho * (core_momentum(after) - core_momentum(core))
                                        gain -= left
                                        core = after
                                        report[tile, DOWN] += mass
                                    else:
                                        mass = 0.0
                                else:
                                    left = mass * w
                                    cloud.laid[c] += mass
                                    report[tile, LAID] += mass
                                    report[tile, TO_GROUND] += left[0]
                                    report[tile, TO_GROUND + 1] += left[1]
                                    report[tile, TO_GROUND + 2] += left.dot(s)
                                cloud.state[c, 0] = ti.max(0.0, cloud.state[c, 0] - mass / numbers.ice)
                                cloud.state[c, 1] = ti.max(0.0, ice - mass / numbers.ice)
                                for k in ti.static(range(2)):
                                    cloud.state[c, 2 + k] -= left[k]
                            # drag
                            V, ice_now = cloud.state[c, 0], cloud.state[c, 1]
                            if moves and V > LEAST:
                                w = velocity_in(cloud, numbers, c)
                                m = numbers.air * V + numbers.excess * ice_now
                                given = dragged(numbers, step, ti.Vector([below.rho * core[0],
                                                                          weight_of(numbers, V, ice_now)]),
                                                ti.Vector([core[1] - w[0], core[2] - w[1]]), s, m / V)
                                over = given / (below.rho * core[0])
                                after = rounded(ti.Vector([core[0], core[1] - over[0], core[2] - over[1]]))
                                given = below.rho * (core_momentum(core) - core_momentum(after))
                                for k in ti.static(range(2)):
                                    cloud.state[c, 2 + k] += given[k]
                                gain += given
                                core = after
                            if moves:
                                for k in ti.static(range(3)):
                                    below.state[i, j, k] = ti.cast(core[k], real)
                                report[tile, TO_CORE] -= gain[0]
                                report[tile, TO_CORE + 1] -= gain[1]
                                report[tile, TO_CORE + 2] -= gain.dot(s)
                                fast = surface_speed(was[1], was[2], s[0], s[1]), surface_speed(core[1], core[2], s[0], s[1])
                                report[tile, WORK] += 0.5 * below.rho * (core[0] * fast[1] ** 2 - was[0] * fast[0] ** 2)
                                report[tile, LIFT] += (lift(below, step, i, j, core, cosine_of(s))
                                                       - lift(below, step, i, j, was, cosine_of(s)))
                            if numbers.ice * cloud.state[c, 1] < DISPERSE:
                                dust, gone = numbers.ice * cloud.state[c, 1], ti.Vector([cloud.state[c, 2],
                                                                                         cloud.state[c, 3]])
                                report[tile, DISPERSED] += cloud.state[c, 0] - cloud.state[c, 1]
                                report[tile, DUST] += dust
                                cloud.laid[c] += dust
                                report[tile, TO_GROUND] += gone[0]
                                report[tile, TO_GROUND + 1] += gone[1]
                                report[tile, TO_GROUND + 2] += gone.dot(s)
                                for k in ti.static(range(4)):
                                    cloud.state[c, k] = 0.0
                            if cloud.state[c, 0] > LEAST:
                                w = velocity_in(cloud, numbers, c)
                                one = ti.Vector([cloud.state[c, 0], cloud.state[c, 1], w[0], w[1]])
                                rate = ti.max(rate, crossed(numbers, step, one, s))
                report[tile, ti.static(RATE + 13)] = rate

    return exchange
