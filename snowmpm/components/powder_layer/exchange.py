"""What flow and cloud exchange in a step: ice and momentum, each as much as the other loses.

    suspension   m12 of `closures.SUSPENSION`, with the velocity of the flow
    settling     m21 = rho_i w_s r_0 c on a unit of plan, with the velocity of the cloud: to the flow where it moves, to
                 the ground elsewhere
    snow cover   m02 = k max(0, tau - tau_s) / |u_2|, tau = C_02 rho_2 |u_2|^2, from rest, where no flow moves and while
                 the cover lasts; of the form of `closures.by_shear_excess`, and chosen
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
    COVER,
    DISPERSED,
    DOWN,
    DUST,
    FASTEST,
    LAID,
    LIFT,
    STATE,
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
from snowmpm.components.powder_layer.closures import BED, SUSPENSION, by_shear_excess
from snowmpm.components.powder_layer.kernels import (
    COVERED,
    LEAST,
    cosine_of,
    crossed,
    density_of,
    slope_of,
    velocity_in,
    weight_of,
)
from snowmpm.depth.kernel_api import TILE, surface_speed

DISPERSE = 1e-6
"""Ice [kg/m2] below which a cell holds no cloud."""
SMALLEST = {ti.f32: 2.0**-22, ti.f64: 2.0**-51}
"""Two units in the last place of 1."""
MOST = 0.5
"""Share of the flow in a cell that may leave it in a step."""


@ti.func
def core_momentum(core):
    """H w of the flow in a cell (H, u, v)."""
    return core[0] * ti.Vector([core[1], core[2]])


@ti.func
def give(cloud: ti.template(), numbers: ti.template(), c, mass, momentum):
    """Add ice [kg/m2], by its volume, and momentum (2) to a cell."""
    cloud.state[c, 0] = ti.max(0.0, cloud.state[c, 0] + mass / numbers.ice)
    cloud.state[c, 1] = ti.max(0.0, cloud.state[c, 1] + mass / numbers.ice)
    for k in ti.static(range(2)):
        cloud.state[c, 2 + k] += momentum[k]


@ti.func
def book(report: ti.template(), tile, first: ti.template(), momentum, s):
    """Add a momentum (2) along the plane of slope s, as one in space (3), to a report."""
    report[tile, first] += momentum[0]
    report[tile, first + 1] += momentum[1]
    report[tile, first + 2] += momentum.dot(s)


@ti.func
def to_ground(cloud: ti.template(), numbers: ti.template(), report: ti.template(), place, mass, momentum, s):
    """Lay ice [kg/m2] of a cloud down with its momentum; place (2): tile and cell."""
    cloud.laid[place[1]] += mass
    give(cloud, numbers, place[1], -mass, -momentum)
    book(report, place[0], TO_GROUND, momentum, s)


@ti.func
def energy(below: ti.template(), step: ti.template(), at, core, s):
    """Kinetic and potential energy of the flow in a cell over plan [J/m2]; at (2): i, j."""
    height = ti.cast(below.heights[at[0], at[1]], ti.f64)
    return below.rho * core[0] * ti.Vector([0.5 * surface_speed(core[1], core[2], s[0], s[1]) ** 2,
                                            step.g * (height + 0.5 * core[0] * cosine_of(s) ** 2)])


from_cover = ti.func(by_shear_excess)


@ti.func
def taken_up(cloud: ti.template(), numbers: ti.template(), step: ti.template(), c, w, s):
    """Ice [kg/m2] that goes into the cloud from the snow cover."""
    speed = surface_speed(w[0], w[1], s[0], s[1])
    stress = numbers.ground_drag * density_of(cloud, numbers, c) * speed * speed
    rate = from_cover(ti.Vector([0.0, speed, speed, stress]), numbers.cover_rate, numbers.cover_stress)
    mass = ti.min(cloud.cover[c], step.dt * rate / cosine_of(s))
    cloud.cover[c] -= mass
    give(cloud, numbers, c, mass, ti.Vector([0.0, 0.0]))
    return mass


@functools.cache
def exchange_kernel(real, suspension, bed, serial):
    """Kernel of an exchange. real: type of the flow's numbers; suspension, bed: names of `closures`. The report has the
    numbers of `arrays.PASSING`."""
    smallest = SMALLEST[real]
    suspended, near_bed = ti.func(SUSPENSION[suspension]), ti.func(BED[bed])

    @ti.func
    def rounded(H, u, v):
        """The flow in a cell as its numbers hold it."""
        return ti.cast(ti.cast(ti.Vector([H, u, v]), real), ti.f64)

    @ti.func
    def falling(cloud: ti.template(), numbers: ti.template(), step: ti.template(), c, w, s):
        """Ice [kg/m2] that settles in a step."""
        shear = ti.sqrt(numbers.ground_drag) * surface_speed(w[0], w[1], s[0], s[1])
        more = near_bed(shear / ti.max(numbers.fall, 1e-12))
        emptied = 1.0 - ti.exp(-step.dt * numbers.fall * more / ti.max(cloud.state[c, 0], LEAST))
        return numbers.ice * cloud.state[c, 1] * emptied

    @ti.func
    def settled(cloud: ti.template(), below: ti.template(), numbers: ti.template(), c, core, w, mass):
        """The flow in a cell after ice of a cloud with velocity w has settled on it."""
        after = core
        # of a thin cloud almost all settles, and the flow, as it is rounded, must not ask for more than there is
        fits = ti.min(mass, numbers.ice * cloud.state[c, 1] - smallest * (below.rho * core[0] + mass))
        if fits > 0.0:
            mixed = (below.rho * core_momentum(core) + fits * w) / (below.rho * core[0] + fits)
            after = rounded(core[0] + fits / below.rho, mixed[0], mixed[1])
            give(cloud, numbers, c, below.rho * (core[0] - after[0]),
                 below.rho * (core_momentum(core) - core_momentum(after)))
        return after

    @ti.func
    def risen(cloud: ti.template(), below: ti.template(), numbers: ti.template(), step: ti.template(), c, core, s):
        """The flow in a cell after snow of it has gone into the cloud."""
        w, speed = velocity_in(cloud, numbers, c), surface_speed(core[1], core[2], s[0], s[1])
        apart = surface_speed(core[1] - w[0], core[2] - w[1], s[0], s[1])
        stress = numbers.core_drag * density_of(cloud, numbers, c) * apart * apart
        rate = suspended(ti.Vector([below.rho, speed, apart, stress]), numbers.rate, numbers.stress) / cosine_of(s)
        after = rounded(core[0] - ti.min(step.dt * rate / below.rho, MOST * core[0]), core[1], core[2])
        give(cloud, numbers, c, below.rho * (core[0] - after[0]),
             below.rho * (core_momentum(core) - core_momentum(after)))
        return after

    @ti.func
    def dragged(cloud: ti.template(), below: ti.template(), numbers: ti.template(), step: ti.template(), c, core, s):
        """The flow in a cell after the drag of the cloud."""
        after, V = core, cloud.state[c, 0]
        if V > LEAST:
            w, own = velocity_in(cloud, numbers, c), weight_of(numbers, V, cloud.state[c, 1])
            slip, bears = ti.Vector([core[1], core[2]]) - w, below.rho * core[0]
            both = bears * own / (bears + own)
            rate = numbers.core_drag * density_of(cloud, numbers, c) / (cosine_of(s) * both)
            fast = step.dt * rate * surface_speed(slip[0], slip[1], s[0], s[1])
            change = both / bears * fast / (1.0 + fast) * slip
            after = rounded(core[0], core[1] - change[0], core[2] - change[1])
            give(cloud, numbers, c, 0.0, below.rho * (core_momentum(core) - core_momentum(after)))
        return after

    @grouped_kernel(ti.f64)
    def exchange(cloud: Cloud, below: Below, tiles: Tiles, numbers: Numbers, step: Step, report: Array):
        """Let flow and cloud exchange for dt: settling, suspension, drag."""
        ti.loop_config(serialize=serial)
        for turn in range(strides(tiles.n)):
            tile = strided(turn, tiles.n)
            if tile < tiles.n and tiles.live[tile] > 0:
                for inner in range(TILE * TILE):
                    i, j = tile // tiles.rows * TILE + inner // TILE, tile % tiles.rows * TILE + inner % TILE
                    c = i * tiles.ny + j
                    if i < tiles.nx and j < tiles.ny and cloud.own[c] > 0:
                        core = ti.Vector([ti.cast(below.state[i, j, k], ti.f64) for k in ti.static(range(3))])
                        moves = core[0] >= COVERED and (core[1] != 0.0 or core[2] != 0.0)
                        s, w, place = slope_of(below, i, j), velocity_in(cloud, numbers, c), ti.Vector([tile, c])
                        mass = 0.0
                        if cloud.state[c, 0] > LEAST:
                            mass = falling(cloud, numbers, step, c, w, s)
                        if moves:
                            first = core
                            core = settled(cloud, below, numbers, c, core, w, mass)
                            report[tile, DOWN] += below.rho * (core[0] - first[0])
                            before = core[0]
                            core = risen(cloud, below, numbers, step, c, core, s)
                            report[tile, UP] += below.rho * (before - core[0])
                            core = dragged(cloud, below, numbers, step, c, core, s)
                            for k in ti.static(range(3)):
                                below.state[i, j, k] = ti.cast(core[k], real)
                            book(report, tile, TO_CORE, below.rho * (core_momentum(core) - core_momentum(first)), s)
                            at = ti.Vector([i, j])
                            if core[0] != first[0] or core[1] != first[1] or core[2] != first[2]:
                                gain = energy(below, step, at, core, s) - energy(below, step, at, first, s)
                                report[tile, WORK] += gain[0]
                                report[tile, LIFT] += gain[1]
                        elif cloud.state[c, 0] > LEAST:
                            to_ground(cloud, numbers, report, place, mass, mass * w, s)
                            report[tile, LAID] += mass
                            if cloud.cover[c] > 0.0:
                                report[tile, COVER] += taken_up(cloud, numbers, step, c, w, s)
                        if cloud.state[c, 0] > 0.0 and numbers.ice * cloud.state[c, 1] < DISPERSE:
                            report[tile, DISPERSED] += cloud.state[c, 0] - cloud.state[c, 1]
                            report[tile, DUST] += numbers.ice * cloud.state[c, 1]
                            to_ground(cloud, numbers, report, place, numbers.ice * cloud.state[c, 1],
                                      ti.Vector([cloud.state[c, 2], cloud.state[c, 3]]), s)
                            for k in ti.static(range(STATE)):
                                cloud.state[c, k] = 0.0
                        if cloud.state[c, 0] > LEAST:
                            w = velocity_in(cloud, numbers, c)
                            one = ti.Vector([cloud.state[c, 0], cloud.state[c, 1], w[0], w[1]])
                            report[tile, FASTEST] = ti.max(report[tile, FASTEST], crossed(numbers, step, one, s))

    return exchange
