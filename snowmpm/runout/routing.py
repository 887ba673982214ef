"""Routing of snow over an elevation raster: where it can get to from each cell of a release, and with how much energy.

The Flow-Py model (D'Amboise et al. 2022, doi:10.5194/gmd-15-2423-2022; Horton et al. 2013,
doi:10.5194/nhess-13-869-2013; Holmgren 1994). From each release cell on its own, with flux 1, a cell b gives to those
of its 8 neighbours n that the energy line reaches:

    delta_n = min(delta_b + (z_b - z_n) - (L_n - L_b) tan(alpha), most),   delta_n > 0           (energy height [m])
    r_n     = w_n^e / sum w^e,   w_n = tan((beta_n + 90 degrees) / 2) = t + sqrt(1 + t²),   t = (z_b - z_n) / ds
    p_n     = sum over parents of delta_parent · 1 straight on, 0.707 at 45 degrees, 0 elsewhere and back; 1 in all
              directions from the first cell and from its neighbours
    flux_n  = flux_b p_n r_n / sum p r

What is below a least flux goes to the neighbours above it, or stays where there are none. Cells are handled in the
order in which they are found, the neighbours of one from the lowest energy to the highest; one that is found again
while it waits takes the larger energy. The speed of a block with that energy is sqrt(2 g delta).

L is the length of the way in plan. The sum of steps between cells is up to 8.2 % longer than the way, since steps have
8 directions, so that run-out depends on the direction of the slope to the raster. Here L_n is that of the ancestor
`CHORD` steps back and the straight line from it. `straight=False` sums steps, as Flow-Py does.
"""

import math
from dataclasses import dataclass

import numpy as np

from snowmpm import memory
from snowmpm.compiler import runtime, ti
from snowmpm.compiler.launch import taichi_kernel
from snowmpm.errors import SimulationError

CHORD = 10
"""Steps of a way between two places that a straight line joins."""
ROOM = 8
"""Entries of a list over cells of the raster: a cell may be found again after it was handled."""
LEAST_ROOM, MOST_ROOM = 4096, 2_000_000
MOST_MEMORY = 2 << 30
"""Of all lists side by side [bytes]."""
FULL = 6
MAIN = 0.02
"""Least flux in a cell of the way on which most snow goes."""
FLUX = 3e-4
"""Least flux."""
MOST = 8848.0
"""Largest energy height [m]: none that a slope has."""
ENERGY, LENGTH, SUM, CELLS, ANGLE = range(5)
"""Numbers of a cell: largest energy height [m], longest way [m], sum of flux, release cells that reach it, least travel
angle as tan."""
FOUND = 5
AT, PARENT, BACK, FREE = range(4)
"""Whole numbers of an entry of a list: cell, entry of its main parent, a bit for each direction that leads back,
whether all directions count alike."""
ENTRY_FLUX, ENTRY_ENERGY, ENTRY_LENGTH, AHEAD = range(4)
"""Numbers of an entry: flux, energy height, length of the way; from AHEAD on: persistence in the 8 directions."""
DIRECTIONS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
TIE = 1e-9
"""Difference of energies, over their size, below which two are one."""
SIDE = 0.707
"""Persistence at 45 degrees, as published."""
OFF = -1


@dataclass(frozen=True)
class Routing:
    """angle: of the energy line [degrees]; exponent: of spreading, 1 in all directions downwards to 75 in the steepest;
    flux: least flux; most: largest energy height [m]; straight: whether ways are measured along chords."""

    angle: float = 25.0
    exponent: float = 8.0
    flux: float = FLUX
    most: float = MOST
    straight: bool = True


USUAL = Routing()


@dataclass(frozen=True)
class Routed:
    """Rasters (nx, ny), NaN where nothing came: largest energy height [m], longest way [m], sum of flux, number of
    release cells that reach it, travel angle of the way of the most energy [degrees], the least of all release cells;
    NaN where it has no length. at_edge: whether snow comes to cells beside the end of the ground, which pass none on.
    """

    energy: np.ndarray
    length: np.ndarray
    flux: np.ndarray
    cells: np.ndarray
    angle: np.ndarray
    at_edge: bool


@ti.func
def _chord(whole: ti.template(), t, k):
    """Entry that is CHORD - 1 steps back from entry k of list t, or the first."""
    far = k
    for _ in range(CHORD - 1):
        if whole[t, far, PARENT] >= 0:
            far = whole[t, far, PARENT]
    return far


@ti.func
def _add(whole: ti.template(), real: ti.template(), place: ti.template(), step, at, given, n):
    """Give to the cell `at`, a neighbour in direction d of entry k in list t: to its entry, if it waits, or a new one;
    -> the number of entries. step: t, k, d; given: flux, energy height, length of the way."""
    t, k, d = step[0], step[1], step[2]
    flux, energy, length = given[0], given[1], given[2]
    e = place[t, at]
    if e <= k:
        e = n
        place[t, at] = e
        whole[t, e, AT], whole[t, e, PARENT], whole[t, e, BACK], whole[t, e, FREE] = at, k, 0, 0
        real[t, e, ENTRY_FLUX], real[t, e, ENTRY_ENERGY], real[t, e, ENTRY_LENGTH] = 0.0, -1.0, 0.0
        for direction in range(8):
            real[t, e, AHEAD + direction] = 0.0
        n += 1
    real[t, e, ENTRY_FLUX] += flux
    # On a lattice many ways are equally long: then the parent with more energy, whatever round-off says
    gain, tie = energy - real[t, e, ENTRY_ENERGY], TIE * (1.0 + ti.abs(energy))
    if gain > tie or (gain >= -tie and real[t, k, ENTRY_ENERGY] > real[t, whole[t, e, PARENT], ENTRY_ENERGY]):
        whole[t, e, PARENT], real[t, e, ENTRY_LENGTH] = k, length
        real[t, e, ENTRY_ENERGY] = ti.max(energy, real[t, e, ENTRY_ENERGY])
    whole[t, e, BACK] |= 1 << ((d + 4) % 8)
    if k == 0:
        whole[t, e, FREE] = 1
    real[t, e, AHEAD + d] += real[t, k, ENTRY_ENERGY]
    real[t, e, AHEAD + (d + 1) % 8] += SIDE * real[t, k, ENTRY_ENERGY]
    real[t, e, AHEAD + (d + 7) % 8] += SIDE * real[t, k, ENTRY_ENERGY]
    return n


@taichi_kernel
def _route(z: ti.types.ndarray(), starts: ti.types.ndarray(), settings: ti.types.ndarray(), steps: ti.types.ndarray(),
           place: ti.types.ndarray(), whole: ti.types.ndarray(), real: ti.types.ndarray(),
           found: ti.types.ndarray()):
    """Route from cells, each on its own, spread over lists. z (nx, ny), NaN off the ground; starts (s,): their cells;
    settings: cell, tan(angle), exponent, least flux, most, straight, and 1 at FULL where a list was too short; steps
    (8, 3): of the directions, and lengths; place (lists, cells): entry that waits for a cell, OFF without; whole
    (lists, n, 4), real (lists, n, 11): the lists; found (lists, cells, FOUND)."""
    for t in range(place.shape[0]):
        nx, ny = z.shape[0], z.shape[1]
        cell, slope, exponent, least, most = settings[0], settings[1], settings[2], settings[3], settings[4]
        for which in range((starts.shape[0] - t + place.shape[0] - 1) // place.shape[0]):
            start = starts[t + which * place.shape[0]]
            whole[t, 0, AT], whole[t, 0, PARENT], whole[t, 0, BACK], whole[t, 0, FREE] = start, OFF, 0, 1
            real[t, 0, ENTRY_FLUX], real[t, 0, ENTRY_ENERGY], real[t, 0, ENTRY_LENGTH] = 1.0, 0.0, 0.0
            z0, n, k = z[start // ny, start % ny], 1, 0
            place[t, start] = 0
            while k < n and n + 8 < whole.shape[1]:
                at = whole[t, k, AT]
                i, j, energy, length = at // ny, at % ny, real[t, k, ENTRY_ENERGY], real[t, k, ENTRY_LENGTH]
                far = _chord(whole, t, k)
                fi, fj = whole[t, far, AT] // ny, whole[t, far, AT] % ny
                energies, lengths, shares = ti.Vector([0.0] * 8), ti.Vector([0.0] * 8), ti.Vector([0.0] * 8)
                total, inside = 0.0, True
                for d in ti.static(range(8)):
                    a, b = i + ti.cast(steps[d, 0], ti.i32), j + ti.cast(steps[d, 1], ti.i32)
                    higher = 0.0
                    if a < 0 or a >= nx or b < 0 or b >= ny:
                        inside = False
                    else:
                        higher = z[a, b]
                        inside = inside and higher == higher
                    ds = cell * steps[d, 2]
                    way = length + ds
                    if settings[5] > 0.0:
                        x, y = ti.cast(a - fi, ti.f64), ti.cast(b - fj, ti.f64)
                        # A way that comes back to where it was has a length all the same
                        way = ti.max(real[t, far, ENTRY_LENGTH] + cell * ti.sqrt(x * x + y * y), length + 0.5 * ds)
                    fall = z[i, j] - higher
                    here = ti.min(energy + fall - (way - length) * slope, most)
                    if inside and here > 0.0 and not (whole[t, k, BACK] >> d) & 1:
                        ahead = 1.0
                        if whole[t, k, FREE] == 0:
                            ahead = real[t, k, AHEAD + d]
                        energies[d], lengths[d] = here, way
                        shares[d] = ahead * (fall / ds + ti.sqrt(1.0 + (fall / ds) ** 2)) ** exponent
                        total += shares[d]
                if inside and total > 0.0:
                    flux, small, kept = real[t, k, ENTRY_FLUX], 0.0, 0
                    for d in ti.static(range(8)):
                        shares[d] *= flux / total
                        if shares[d] >= least:
                            kept += 1
                        else:
                            small += shares[d]
                    for _ in range(8):  # from the lowest energy to the highest
                        lowest = OFF
                        for d in ti.static(range(8)):
                            if shares[d] >= least and (lowest == OFF or energies[d] < energies[ti.max(lowest, 0)]):
                                lowest = d
                        if lowest != OFF:
                            a = i + ti.cast(steps[lowest, 0], ti.i32)
                            b = j + ti.cast(steps[lowest, 1], ti.i32)
                            given = ti.Vector([shares[lowest] + small / kept, energies[lowest], lengths[lowest]])
                            n = _add(whole, real, place, ti.Vector([t, k, lowest]), a * ny + b, given, n)
                            shares[lowest] = 0.0
                k += 1
            for e in range(n):
                at, length = whole[t, e, AT], real[t, e, ENTRY_LENGTH]
                found[t, at, ENERGY] = ti.max(found[t, at, ENERGY], real[t, e, ENTRY_ENERGY])
                found[t, at, LENGTH] = ti.max(found[t, at, LENGTH], length)
                found[t, at, SUM] += real[t, e, ENTRY_FLUX]
                if place[t, at] != OFF:
                    found[t, at, CELLS] += 1.0
                    place[t, at] = OFF
                if length > 0.0:
                    found[t, at, ANGLE] = ti.min(found[t, at, ANGLE], (z0 - z[at // ny, at % ny]) / length)
            if k < n:
                settings[FULL] = 1.0


def route(z, cell, starts, options=USUAL, lists=1):
    """`Routed` over heights z (nx, ny) [m], NaN off the ground, of cells of a side `cell` [m], from cells `starts`
    (k, 2). lists: that are worked on side by side. Raises SimulationError where a way goes round in circles."""
    found, _ = _searched(z, cell, starts, options, lists)
    return _routed(found, z)


def _searched(z, cell, starts, options, lists):
    """(numbers of cells (lists, cells, FOUND), lists (whole, real) of the last start of each)."""
    z = np.ascontiguousarray(z, float)
    room = min(max(LEAST_ROOM, ROOM * z.size), MOST_ROOM)
    each = room * (4 * 4 + 8 * (AHEAD + 8)) + z.size * (4 + 8 * FOUND)
    lists = max(1, min(lists, len(starts), int(MOST_MEMORY // each)))
    memory.require(lists * each, "solver.dx: routing over the cells of the terrain")
    numbers = np.ravel_multi_index(np.asarray(starts).T, z.shape).astype(np.int32)
    settings = np.array([cell, math.tan(math.radians(options.angle)), options.exponent, options.flux, options.most,
                         float(options.straight), 0.0])
    steps = np.array([[*one, math.hypot(*one)] for one in DIRECTIONS], float)
    place = np.full((lists, z.size), OFF, np.int32)
    whole, real = np.zeros((lists, room, 4), np.int32), np.zeros((lists, room, AHEAD + 8))
    found = np.zeros((lists, z.size, FOUND))
    found[..., ANGLE] = np.inf
    with runtime.precision("f64"):
        _route(z, numbers, settings, steps, place, whole, real, found)
    if settings[FULL]:
        raise SimulationError(f"routing found more than {room} cells from one release cell: a larger --angle, or larger"
                              " cells (solver.dx), keep it within bounds")
    return found, (whole, real)


def main_way(z, cell, start, options):
    """Cells (k, 2) of the way from one cell (2,) to the furthest place that much snow gets to, `CHORD` / 2 steps apart:
    back from it by the parents that gave most energy."""
    _, (whole, real) = _searched(z, cell, np.asarray(start)[None], options, 1)
    entries = int(np.flatnonzero(real[0, :, ENTRY_FLUX])[-1]) + 1
    strong = real[0, :entries, ENTRY_FLUX] >= MAIN
    e = int(np.argmax(np.where(strong, real[0, :entries, ENTRY_LENGTH], -1.0)))
    way = []
    while e >= 0:
        way.append(whole[0, e, AT])
        e = int(whole[0, e, PARENT])
    cells = np.array(np.unravel_index(way[::-1], z.shape)).T
    return cells[np.unique([*range(0, len(cells), CHORD // 2), len(cells) - 1])]


def _routed(found, z):
    energy, length = found[..., ENERGY].max(axis=0), found[..., LENGTH].max(axis=0)
    flux, cells = found[..., SUM].sum(axis=0), found[..., CELLS].sum(axis=0)
    tangent = found[..., ANGLE].min(axis=0)
    angle = np.where(np.isfinite(tangent), np.degrees(np.arctan(tangent)), np.nan)
    reached = cells > 0.0
    rasters = [np.where(reached, one, np.nan).reshape(z.shape) for one in (energy, length, flux, cells, angle)]
    known = np.pad(np.isfinite(z), 1)
    inside = np.all([known[1 + i : 1 + i + z.shape[0], 1 + j : 1 + j + z.shape[1]] for i, j in DIRECTIONS], axis=0)
    return Routed(*rasters, bool((reached.reshape(z.shape) & ~inside).any()))
