"""From columns in plan to particles in space.

Columns are spread over the lattice of the particles (`handover.spreading`): over each of its points then stands snow of
volume V, depth H = V / a^2 above the ground, which is filled with layers of particles about as far apart, normal to the
ground, as the new method wants. Snow for less than half a particle is brought together with that beside it. Mass,
centre of mass in plan and momentum in plan stay to round-off. All over a place moves at its velocity along the ground.

The stress is that of a sheet that slides on the ground without deforming: along the normal the weight above, along the
sheet K_0 of it, and the shear stress that the ground's friction carries,

    tau = rho d [ (g.n) (n n + K_0 (I - n n)) + f (g_t n + n g_t) ],   f = min(1, mu |g.n| / |g_t|)

where the law can take it, else none. A law with bonds starts with broken ones, and then without shear (K_0 = 1).
"""

import numpy as np

from snowmpm import memory
from snowmpm.handover.handed import Handed, first_numbers
from snowmpm.handover.heaps import Heaps
from snowmpm.handover.spreading import spread
from snowmpm.materials import pack
from snowmpm.particles.population import Population
from snowmpm.setup.initial_stress import geostatic_stress

LEAST = 0.5
"""Particles for which the snow over a place must suffice, or it is brought together with its neighbours."""

DEPTH, HEIGHT = -2, -1
"""Columns of `Heaps.more`: vertical depth of the snow, and height of the ground [m]."""


def filled(fields, start, ground, wide, part, laws, below=None):
    """`Handed` particles of columns.

    fields: `particles.fields.ParticleFields`; start (numbers, 3) [m]: where each was at time zero, by number; ground:
    surface with `height` and `normal`; wide [m]: cell of the columns' grid; part: scene of the method that takes over;
    laws: its laws by material; below: places in plan (k, 2) [m] -> vertical depth (k,) [m] of other snow there, on
    which it is laid; None where there is none.
    """
    spacing, n_bodies = part.solver.spacing(3), len(part.bodies)
    m = max(1, round(wide / spacing))
    heaps = _large_enough(_over_lattice(fields, start, ground, wide, m), spacing, wide / m)
    material = np.zeros(n_bodies, int)
    material[fields["body"]] = fields["material"]
    normal = _upward(ground.normal(heaps.plan))
    layers = np.maximum(1, np.round(heaps.volume * normal[:, 2] / (spacing * (wide / m) ** 2))).astype(int)
    memory.require(memory.PER_PARTICLE[3] * layers.sum(), "switch: the particles that columns become",
                   "a coarser switch.solver.dx needs less")
    rows = np.repeat(np.arange(len(heaps)), layers)
    place = np.arange(len(rows)) - np.repeat(np.cumsum(layers) - layers, layers)
    over, whole = _under_and_whole(heaps, wide / m)
    if below is not None:
        there = below(heaps.plan)
        over, whole = over + there, whole + there
    above = over[rows] + heaps.more[rows, DEPTH] * (place + 0.5) / layers[rows]  # the ground, vertically
    velocity = np.column_stack([heaps.velocity, -(heaps.velocity * normal[:, :2]).sum(axis=1) / normal[:, 2]])
    population = Population(
        np.column_stack([heaps.plan[rows], heaps.more[rows, HEIGHT] + above]), (heaps.volume / layers)[rows],
        material[heaps.body[rows]], velocity[rows])
    _give_stress(population, (whole[rows] - above) * normal[rows, 2], normal[rows], part, laws)
    return Handed(population, first_numbers(heaps.body[rows], n_bodies), heaps.more[rows, :3])


def _over_lattice(fields, start, ground, wide, m):
    """`Heaps` of all columns over the lattice, each body by itself."""
    position, body = fields["position"], fields["body"]
    height, slope = ground.height(position[:, :2]), _upward(ground.normal(position[:, :2]))
    columns = Heaps(position[:, :2], fields.column("volume")[:, 0], fields["velocity"][:, :2],
                    np.column_stack([start[fields["id"]], fields["depth"] / slope[:, 2], height]), body)
    columns, parts = columns.chosen(np.argsort(body, kind="stable")), []
    corner = columns.plan.min(axis=0)
    for one in np.unique(columns.body):
        on_lattice, left = spread(columns.chosen(columns.body == one), corner, wide, m, ground.height)
        on_lattice.more[:, DEPTH] = on_lattice.volume * (m / wide) ** 2
        on_lattice.more[:, HEIGHT] = ground.height(on_lattice.plan)
        parts += [on_lattice, left]
    return Heaps.joined(parts)


def _large_enough(heaps, spacing, side):
    """Heaps of half a particle at least, where there is so much snow near them."""
    for squares in (2.0, 4.0, 8.0):
        small = heaps.volume < LEAST * spacing**3
        if small.any():
            heaps = Heaps.joined([heaps.chosen(~small), heaps.chosen(small).merged(squares * side)])
    return heaps


def _under_and_whole(heaps, side):
    """Vertical depth [m] of the bodies below each heap, and of all over its place: bodies lie in their order."""
    _, place = np.unique(np.floor(heaps.plan / side).astype(np.int64), axis=0, return_inverse=True)
    depth, whole = heaps.more[:, DEPTH], np.zeros(place.max(initial=-1) + 1)
    under = np.zeros(len(heaps))
    for one in np.unique(heaps.body):
        own = heaps.body == one
        under[own] = whole[place.reshape(-1)[own]]
        np.maximum.at(whole, place.reshape(-1)[own], under[own] + depth[own])
    return under, whole[place.reshape(-1)]


def _upward(normals):
    """Normals (n, 3), vertical where there is no ground."""
    return np.where(np.isnan(normals).any(axis=1)[:, None], [0.0, 0.0, 1.0], normals)


def _give_stress(population, depth, normal, part, laws):
    """Stress, elastic strain and state of a sliding sheet; depth (n,) [m]: of the snow above, along the normal."""
    gravity, mu = np.array(part.gravity_vector), coefficient(part.terrain)
    width = max([1, *(len(law.STATE) for law in laws)])
    population.state = np.full((len(depth), width), np.nan)
    along = np.linalg.norm(gravity - (normal @ gravity)[:, None] * normal, axis=1)
    held = np.minimum(1.0, mu * np.abs(normal @ gravity) / np.maximum(along, 1e-30))
    for index, law in enumerate(laws):
        own = population.material == index
        severed = law.severed_state()
        if severed is not None:
            population.state[own, : len(severed)] = severed
        k0, shear = (law.lateral_pressure, held[own]) if severed is None else (1.0, 0.0)
        tau = geostatic_stress(population.positions[own], law.density * depth[own], normal[own], gravity,
                               np.full(own.sum(), k0), shear)
        elastic = law.h_from_stress(tau)
        can = np.isfinite(elastic).all(axis=(1, 2))[:, None]
        population.stress[own] = np.where(can, pack(tau), 0.0)
        population.elastic[own] = np.where(can, pack(elastic), 0.0)


def coefficient(terrain):
    """Coulomb coefficient of the ground, 0 where it has none."""
    given = terrain.friction
    found = given if isinstance(given, int | float) else given.get("mu", 0.0)
    return float(found) if isinstance(found, int | float) and terrain.contact != "slip" else 0.0
