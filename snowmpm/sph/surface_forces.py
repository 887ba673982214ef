"""What becomes of the forces that the dummies or images of one surface sum up to, and what the surface gave.

A mirror gives them as they are. A surface that slips keeps only their normal part, and Coulomb's friction, at most mu
times that and at most what ends the sliding; one that separates does not pull. A barrier stops what would sink below
BARRIER within the step. Columns of a pack (`momentum`): wall, the force of the surface, and with weights that sum up to
share: height above it, normal, wall_v, its velocity; inner, all other forces over mass, times dx; earlier, those of
the surfaces before it among them [m2/s2].
"""

import functools
from types import SimpleNamespace

from snowmpm.compiler import ti
from snowmpm.materials.packs import read_lane
from snowmpm.sph.neighbours import BLOCK, COUNT
from snowmpm.stepping.contact_velocity import SEPARATE, STICK

BARRIER = 0.1
"""Height above a wall [cells] below which nothing gets by itself."""

def tally_width(dim):
    """Numbers summed up of each surface: impulse, its moment about the frame's origin [cells], energy given."""
    return {2: 4, 3: 7}[dim]


@functools.cache
def surface_functions(dim, real, width, barrier):
    """Functions on packs of `width` lanes: clear(...) before a surface, apply_contact(...) after its sum,
    apply_loads(...) for the loads of events; barrier: whether surfaces also stop what comes too close."""
    n_moment = 1 if dim == 2 else 3

    @ti.func
    def clear(pack: ti.template()):
        for lane in range(width):
            pack["share"][0][lane], pack["height"][0][lane] = 0.0, 0.0
            for a in ti.static(range(dim)):
                pack["wall"][a][lane], pack["normal"][a][lane], pack["wall_v"][a][lane] = 0.0, 0.0, 0.0

    @ti.func
    def apply_contact(pack: ti.template(), k, surface, mirrored, lists: ti.template(), walls: ti.template(),
                      tallies: ti.template(), step: ti.template()):
        """Let one surface act on pack k: pack["wall"] is added to pack["inner"], and what it gave is summed up."""
        block, tally, dt, inverse_dx = lists.table[k, BLOCK], tallies.of[k], step.dt, 1.0 / step.dx
        volume = ti.cast(step.dx, real) ** dim
        g = ti.Vector([ti.cast(step.gravity[a], real) for a in ti.static(range(dim))])
        for lane in range(lists.table[k, COUNT]):
            given = read_lane(pack["wall"], lane)
            code, friction = ti.cast(walls.surfaces[surface, 0], ti.i32), ti.cast(walls.surfaces[surface, 1], real)
            normal = read_lane(pack["normal"], lane)
            normal = normal / ti.max(normal.norm(), 1e-20)
            share = ti.max(pack["share"][0][lane], 1e-20)
            along = given.dot(normal)
            # What the particle would do along the wall without it
            free = read_lane(pack["v"], lane) + dt * (inverse_dx * read_lane(pack["inner"], lane) + g)
            free -= read_lane(pack["wall_v"], lane) / share
            if mirrored == 0 and code == SEPARATE:
                along = ti.max(0.0, along)
            if ti.static(barrier):  # noqa: SIM102 (one is compile time)
                if mirrored == 0 and pack["share"][0][lane] > 1e-6:
                    clearance = ti.max(0.0, pack["height"][0][lane] / share - BARRIER)
                    sinking = -free.dot(normal) - dt * inverse_dx * along
                    along += ti.max(0.0,
                                    sinking / ti.max(dt * inverse_dx, 1e-30) - clearance / (dt * dt * inverse_dx**2))
            if mirrored == 0 and code == STICK:
                given += (along - given.dot(normal)) * normal
            if mirrored == 0 and code != STICK:
                sliding = free - free.dot(normal) * normal
                speed = sliding.norm()
                held = ti.min(friction * ti.max(0.0, along), speed / ti.max(dt * inverse_dx, 1e-30))
                given = along * normal - (held / ti.max(speed, 1e-30)) * sliding
            for a in ti.static(range(dim)):
                pack["inner"][a][lane] += given[a]
            if tally >= 0:
                J = ti.cast(given * (pack["m"][0][lane] * volume * dt * inverse_dx), ti.f64)
                x, v = ti.Vector.zero(ti.f64, dim), ti.Vector.zero(ti.f64, dim)
                for a in ti.static(range(dim)):
                    x[a], v[a] = pack["x"][a][lane] + tallies.corners[block, a], pack["v"][a][lane]
                    tallies.sums[tally, surface, a] += J[a]
                if ti.static(dim == 2):
                    tallies.sums[tally, surface, dim] += x[0] * J[1] - x[1] * J[0]
                else:
                    moment = x.cross(J)
                    for a in ti.static(range(3)):
                        tallies.sums[tally, surface, dim + a] += moment[a]
                # The work of a force is with the velocity in the middle of the kick. What two surfaces do to each
                # other's work is all booked by the later one, which alone knows of both
                kicked = read_lane(pack["inner"], lane) + read_lane(pack["earlier"], lane)
                middle = v + 0.5 * ti.cast(dt * (inverse_dx * kicked + g), ti.f64)
                tallies.sums[tally, surface, dim + n_moment] += J.dot(middle)
            for a in ti.static(range(dim)):
                pack["earlier"][a][lane] += given[a]

    @ti.func
    def apply_loads(pack: ti.template(), k, lists: ti.template(), tallies: ti.template(), step: ti.template()):
        """Loads of events on pack k: accelerations within a radius."""
        block, tally, last = lists.table[k, BLOCK], tallies.of[k], tallies.total.shape[0] - 1
        volume = ti.cast(step.dx, real) ** dim
        for lane in range(lists.table[k, COUNT]):
            for q in range(step.n_loads):
                square = ti.cast(0.0, ti.f64)
                for a in ti.static(range(dim)):
                    square += (pack["x"][a][lane] + tallies.corners[block, a] - step.loads[q, a]) ** 2
                if square < step.loads[q, dim] ** 2:
                    for a in ti.static(range(dim)):
                        gain = ti.cast(step.loads[q, dim + 1 + a], real)
                        pack["inner"][a][lane] += step.dx * gain
                        tallies.sums[tally, last, a] += ti.cast(pack["m"][0][lane] * volume * step.dt * gain,
                                                                ti.f64)

    return SimpleNamespace(clear=clear, apply_contact=apply_contact, apply_loads=apply_loads)
