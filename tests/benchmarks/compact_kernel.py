"""Scatter and gather with the compact kernel on two grids, and both fused, beside the quadratic spline: ns a particle.

    python tests/benchmarks/compact_kernel.py [--case block3 layer3] [--particles N] [--turns N] [-o FILE]

3-D, single precision, one thread, moving least squares. All kernels here are made of the product's parts, on its
particles, packs and tiles: the compact kernel (`compact_accuracy.py`) is a stencil of two nodes an axis, made twice.
The law is left out: instead a stress is changed by the symmetric part of C, so that scatter and gather load and store
what they do in a run. Every kernel takes its turn, again and again, in one process.

    scatter, gather: as in the product, whose own scatter is `product_scatter`
    fused: a gather that scatters what it found at once, into other tiles (Wang et al. 2020,
           doi:10.1145/3386569.3392442); velocity, C and stress of a particle are neither stored nor loaded

Columns: case; flip: nodes of eight numbers, as AFLIP has them; particles; a block; ns of each, processor time, least
over the turns; ratios, median over the turns: of the compact kernel to the quadratic one, and of fused to scatter and
gather; nodes: those of both grids in the boxes of all tiles, over those of the quadratic grid, by which the cost of the
grid goes; error: largest difference of what a gather finds of a linear field from that field, over the field.
"""

import argparse
import csv
import functools
import math
import time
from pathlib import Path
from statistics import median
from types import SimpleNamespace

import mpm_step
import numpy as np
import taichi as ti

from snowmpm.compiler import runtime
from snowmpm.compiler.arrays import int_array
from snowmpm.compiler.launch import plain_compilation, taichi_kernel
from snowmpm.materials.packs import LANES, read_lane, read_matrix_lane, write_lane, write_matrix_lane
from snowmpm.mpm.contact.spreading import Given, spreading
from snowmpm.mpm.grid import TILE
from snowmpm.mpm.node import SECOND, node_mask, node_size, node_vector
from snowmpm.mpm.transfer.interpolation import interpolation
from snowmpm.mpm.transfer.stencil import STENCILS, Stencil
from snowmpm.particles.store import accessors

TABLE = Path(__file__).parent / "figures" / "compact_kernel.csv"
DIM, REAL = 3, ti.f32
OFFSETS = {"quadratic": (0.0,), "compact": (0.25, -0.25)}
"""Where the grids of a kernel begin [cells]."""
SINE = tuple((-1) ** (k + 1) * (2 * math.pi) ** (2 * k) / math.factorial(2 * k + 1) for k in range(7))
"""-sin(2 pi y) / (2 pi y) in powers of y^2: to 4e-6 for |y| < 1/2."""
DENSITY, STIFFNESS, FLIP_RATIO = 250.0, 1e6, 0.97


@ti.func
def sine(f):
    """sin(2 pi f) / (2 pi) for 0 <= f < 1, without a call, so that it is vectorised."""
    y = f - 0.5
    square, total = y * y, ti.cast(0.0, REAL)
    for factor in ti.static(SINE[::-1]):
        total = total * square + factor
    return total * y


@ti.func
def compact_weights(f):
    """Halved along the first axis, and so in every product."""
    upper = f - ti.Vector([sine(f[a]) for a in ti.static(range(DIM))])
    half = ti.Vector([0.5, 1.0, 1.0])
    return ti.Matrix.rows([half * (1.0 - upper), half * upper])


# D^-1 is that of the particle, so what goes with it is handed over as if it were 1
STENCILS["compact"] = Stencil(2, 1.0, 0.749, compact_weights, None)


@ti.func
def inverse_moment(f):
    """D^-1 of both grids together; f: place in the cell of the first one. D_ab = s_a s_b but for its diagonal."""
    s, D = ti.Vector([sine(f[a]) for a in ti.static(range(DIM))]), ti.Matrix.zero(REAL, DIM, DIM)
    for a in ti.static(range(DIM)):
        for b in ti.static(range(DIM)):
            D[a, b] = s[a] * s[b]
        g = ti.select(f[a] < 0.5, f[a] + 0.5, f[a] - 0.5)
        D[a, a] = 0.5 * (f[a] - f[a] ** 2 + g - g**2) + s[a] * (f[a] - g)
    return D.inverse()


@functools.cache
def kernels(layout, basis, flip):
    """scatter, gather, fused: taichi kernels of a basis. Tiles of a second grid lie behind those of the first."""
    access, at = accessors(layout), layout.offsets
    of_node, size, mask = node_vector(REAL, flip), node_size(flip), node_mask(flip)
    offsets, width = OFFSETS[basis], STENCILS[basis].width
    n_grids, cube = len(offsets), TILE[DIM] ** DIM
    grid = interpolation(DIM, REAL, basis, True, False, flip)
    parts = spreading(DIM, REAL, basis, "affine", flip, True, False, False)
    columns = (("x", DIM), ("v", DIM), ("C", 9), ("tau", 6), ("volume", 1), ("w", n_grids * width * DIM), ("f", DIM),
               ("old", DIM * flip), ("moments", 9), ("inverse", 9 * (n_grids - 1)))
    entry = (0, 3, 5), (3, 1, 4), (5, 4, 2)
    n_vectors = parts.n_vectors
    compact = n_grids == 2

    @ti.func
    def load(pack: ti.template(), name: ti.template(), lane, p, reals: ti.template(), places, column: ti.template()):
        write_lane(pack[name], lane, access.load(reals, places, p, at[column], layout.sizes[column]))

    @ti.func
    def locate(pack: ti.template(), address: ti.template(), b, n_tiles):
        """Stencils of all lanes."""
        for lane in range(LANES):
            x = read_lane(pack["x"], lane)
            for g in ti.static(range(n_grids)):
                start, f, w, _ = grid.locate(x - offsets[g], b + g * n_tiles)
                address[g][lane] = start
                if ti.static(g == 0):
                    write_lane(pack["f"], lane, f)
                for k in ti.static(range(width)):
                    for a in ti.static(range(DIM)):
                        pack["w"][(g * width + k) * DIM + a][lane] = w[k, a]
            if ti.static(compact):
                write_matrix_lane(pack["inverse"], lane, inverse_moment(read_lane(pack["f"], lane)))

    @ti.func
    def weights_of(pack: ti.template(), g: ti.template(), lane):
        return ti.Matrix([[pack["w"][(g * width + k) * DIM + a][lane] for a in ti.static(range(DIM))]
                          for k in ti.static(range(width))])

    @ti.func
    def prepare(pack: ti.template(), vectors: ti.template(), dt, dx):
        """What all lanes give to each grid."""
        for lane in range(LANES):
            tau = ti.Matrix([[pack["tau"][entry[i][j]][lane] for j in ti.static(range(DIM))]
                             for i in ti.static(range(DIM))])
            impulse = (-dt / dx * pack["volume"][0][lane]) * tau
            if ti.static(compact):
                impulse = impulse @ read_matrix_lane(pack["inverse"], lane)
            f, velocity = read_lane(pack["f"], lane), read_lane(pack["v"], lane)
            mass, none, zero = DENSITY * pack["volume"][0][lane], ti.Vector.zero(REAL, DIM), ti.cast(0.0, REAL)
            for g in ti.static(range(n_grids)):
                place = ti.select(f < 0.5, f + 0.5, f - 0.5) if ti.static(g == 1) else f
                w, C = weights_of(pack, g, lane), dx * read_matrix_lane(pack["C"], lane)
                parts.prepare(vectors[g * n_vectors : (g + 1) * n_vectors], lane, place, w, w,
                              ti.static(Given(mass, velocity, C, impulse, none, zero)))

    @ti.func
    def spread(pack: ti.template(), address: ti.template(), vectors: ti.template(), count, tiles: ti.template()):
        for lane in range(count):
            for g in ti.static(range(n_grids)):
                parts.spread(tiles, address[g][lane] & mask, weights_of(pack, g, lane),
                             vectors[g * n_vectors : (g + 1) * n_vectors], lane)

    @ti.func
    def interpolate(pack: ti.template(), address: ti.template(), sums: ti.template(), first, count,
                    reals: ti.template(), places, tiles: ti.template(), cells_per_metre):
        """As the product's gather, node vectors whole. With the nodes' places from the first grid's base the moments of
        two grids add up, but for the half cell between them."""
        for lane in range(count):
            v, moments, _ = grid.interpolate(tiles, address[0][lane] & mask, weights_of(pack, 0, lane), ti.Matrix.zero(
                REAL, width, DIM))
            if ti.static(compact):
                other, more, _ = grid.interpolate(tiles, address[1][lane] & mask, weights_of(pack, 1, lane),
                                                  ti.Matrix.zero(REAL, width, DIM))
                v += other
                for a in ti.static(range(DIM)):
                    shift = ti.select(pack["f"][a][lane] < 0.5, -0.5, 0.5)
                    for c in ti.static(range(size)):
                        moments[a, c] += more[a, c] + shift * other[c]
            for c in ti.static(range(size)):
                sums[0][size * lane + c] = v[c]
                for a in ti.static(range(DIM)):
                    sums[1 + a][size * lane + c] = moments[a, c]
            x = read_lane(pack["x"], lane)
            for a in ti.static(range(DIM)):
                x[a] += cells_per_metre * v[a]
            write_lane(pack["x"], lane, x)
            access.store(reals, places, first + lane, at["position"], x)

    @ti.func
    def respond(pack: ti.template(), sums: ti.template(), dt, inverse_dx):
        """Velocity, C and stress of all lanes."""
        for lane in range(LANES):
            for i in ti.static(range(DIM)):
                pack["v"][i][lane] = sums[0][size * lane + i]
                for a in ti.static(range(DIM)):
                    pack["moments"][a * DIM + i][lane] = sums[1 + a][size * lane + i]
                if ti.static(flip):
                    pack["old"][i][lane] += sums[0][size * lane + ti.static(SECOND + i)]
        for lane in range(LANES):
            v, moments = read_lane(pack["v"], lane), read_matrix_lane(pack["moments"], lane)
            C, _ = grid.gradients(read_lane(pack["f"], lane), v, moments, moments, inverse_dx)
            if ti.static(compact):
                C = C @ read_matrix_lane(pack["inverse"], lane)
            if ti.static(flip):
                v += FLIP_RATIO * (read_lane(pack["old"], lane) - v)
            write_lane(pack["v"], lane, v)
            write_matrix_lane(pack["C"], lane, C)
            for i in ti.static(range(DIM)):
                for j in ti.static(range(i + 1)):
                    pack["tau"][entry[i][j]][lane] += STIFFNESS * dt * (C[i, j] + C[j, i])

    @ti.func
    def clear(tiles: ti.template(), boxes: ti.template(), tile):
        """Set the box of a tile to zero, rows of it at a time."""
        for i, j in ti.ndrange((boxes[tile, 0], boxes[tile, 3]), (boxes[tile, 1], boxes[tile, 4])):
            row = (tile * cube + i * TILE[DIM] ** 2 + j * TILE[DIM]) & mask
            for k in ti.static(range(TILE[DIM])):
                tiles[row + k] = ti.select(tile >= 0, of_node(0.0), tiles[row + k])

    @taichi_kernel
    def scatter(reals: ti.types.ndarray(), slot_offset: int, start: ti.types.ndarray(), boxes: ti.types.ndarray(),
                tiles: ti.types.ndarray(dtype=of_node, ndim=1), dt: REAL, dx: REAL, n_tiles: int):
        ti.loop_config(serialize=True)
        for _ in range(1):
            places, blank = access.places(reals, slot_offset), ti.Vector.zero(REAL, LANES)
            pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
            blanks, none = ti.Vector.zero(REAL, size * LANES), ti.Vector.zero(ti.i32, LANES)
            vectors, address = [blanks for _ in ti.static(range(n_grids * n_vectors))], [none, none]
            for b in range(n_tiles):
                for g in ti.static(range(n_grids)):
                    clear(tiles, boxes, b + g * n_tiles)
                for k in range((start[b + 1] - start[b] + LANES - 1) // LANES):
                    first = start[b] + k * LANES
                    count = ti.min(LANES, start[b + 1] - first)
                    for lane in range(count):
                        p = first + lane
                        load(pack, "x", lane, p, reals, places, "position")
                        load(pack, "v", lane, p, reals, places, "velocity")
                        load(pack, "C", lane, p, reals, places, "affine")
                        load(pack, "tau", lane, p, reals, places, "stress")
                        load(pack, "volume", lane, p, reals, places, "volume")
                    locate(pack, address, b, n_tiles)
                    prepare(pack, vectors, dt, dx)
                    spread(pack, address, vectors, count, tiles)

    def gather_kernel(fused):
        @taichi_kernel
        def gather(reals: ti.types.ndarray(), slot_offset: int, start: ti.types.ndarray(), boxes: ti.types.ndarray(),
                   tiles: ti.types.ndarray(dtype=of_node, ndim=1), target: ti.types.ndarray(dtype=of_node, ndim=1),
                   dt: REAL, dx: REAL, n_tiles: int):
            ti.loop_config(serialize=True)
            for _ in range(1):
                places, blank = access.places(reals, slot_offset), ti.Vector.zero(REAL, LANES)
                pack = {name: [blank for _ in ti.static(range(n))] for name, n in ti.static(columns)}
                blanks, none = ti.Vector.zero(REAL, size * LANES), ti.Vector.zero(ti.i32, LANES)
                sums, address = [blanks for _ in ti.static(range(1 + DIM))], [none, none]
                vectors = [blanks for _ in ti.static(range(n_grids * n_vectors * fused))]
                for b in range(n_tiles):
                    for g in ti.static(range(n_grids * fused)):
                        clear(target, boxes, b + g * n_tiles)
                    for k in range((start[b + 1] - start[b] + LANES - 1) // LANES):
                        first = start[b] + k * LANES
                        count = ti.min(LANES, start[b + 1] - first)
                        for lane in range(count):
                            p = first + lane
                            load(pack, "x", lane, p, reals, places, "position")
                            load(pack, "tau", lane, p, reals, places, "stress")
                            load(pack, "volume", lane, p, reals, places, "volume")
                            if ti.static(flip):
                                load(pack, "old", lane, p, reals, places, "velocity")
                        locate(pack, address, b, n_tiles)
                        interpolate(pack, address, sums, first, count, reals, places, tiles, dt / dx)
                        respond(pack, sums, dt, 1.0 / dx)
                        for lane in range(count):
                            p = first + lane
                            access.store(reals, places, p, at["stress"], read_lane(pack["tau"], lane))
                            if ti.static(flip or not fused):
                                access.store(reals, places, p, at["velocity"], read_lane(pack["v"], lane))
                            if ti.static(not fused):
                                access.store(reals, places, p, at["affine"], read_lane(pack["C"], lane))
                        if ti.static(fused):
                            locate(pack, address, b, n_tiles)
                            prepare(pack, vectors, dt, dx)
                            spread(pack, address, vectors, count, target)

        return gather

    return SimpleNamespace(scatter=scatter, gather=gather_kernel(False), fused=gather_kernel(True))


def boxes_of(local, start, basis):
    """First and one-past-last node of each tile that its particles reach, (grids * tiles, 6), and how many nodes."""
    block, found = np.repeat(np.arange(len(start) - 1), np.diff(start)), []
    for offset in OFFSETS[basis]:
        base = np.floor(local - offset - STENCILS[basis].reach).astype(int) + 1
        lower, upper = np.full((2, len(start) - 1, DIM), 99)
        np.minimum.at(lower, block, base)
        upper[:] = 0
        np.maximum.at(upper, block, base + STENCILS[basis].width)
        found.append(np.concatenate([lower, upper], 1))
    boxes = np.concatenate(found)
    return boxes, int((boxes[:, 3:] - boxes[:, :3]).prod(1).sum())


class Trial:
    """Kernels of one basis on the particles of a solver."""

    def __init__(self, solver, basis, flip):
        store, self.flip = solver.particles, flip
        self.store, self.dx, self.n_tiles = store, solver.dx, solver.grid.n_tiles
        self.start = store.start
        boxes, self.n_nodes = boxes_of(store.column("position"), store.blocks.start, basis)
        self.boxes = int_array(boxes)
        nodes = len(OFFSETS[basis]) * self.n_tiles * TILE[DIM] ** DIM
        self.tiles, self.target = (ti.ndarray(node_vector(REAL, flip), nodes) for _ in range(2))
        self.kernels, self.basis = kernels(store.layout, basis, flip), basis

    def scatter(self):
        self._run(self.kernels.scatter, self.tiles)

    def gather(self):
        with plain_compilation():
            self._run(self.kernels.gather, self.tiles, self.target)

    def fused(self):
        self._run(self.kernels.fused, self.tiles, self.target)

    def _run(self, kernel, *tiles):
        kernel(self.store.reals, self.store.slot_offset, self.start, self.boxes, *tiles, 0.0, self.dx, self.n_tiles)

    def error(self):
        """Of a linear field at the nodes, gathered: largest difference of velocity and C from it, over the field."""
        rng = np.random.default_rng(1)
        slope, constant = rng.normal(size=(DIM, DIM)), rng.normal(size=DIM)
        nodes = np.stack(np.meshgrid(*[np.arange(TILE[DIM]) - 1.0] * DIM, indexing="ij"), -1).reshape(-1, DIM)
        corner = 4.0 * self.store.coordinates.to_numpy()[: self.n_tiles]
        values = np.zeros((*self.tiles.shape, node_size(self.flip)), np.float32)
        places = np.concatenate([(corner[:, None] + nodes + offset).reshape(-1, DIM) for offset in OFFSETS[self.basis]])
        values[:, :DIM] = constant + places @ slope.T
        self.tiles.from_numpy(values)
        before = self.store.table()
        with runtime.precision("f32"):
            self.gather()
        after = self.store.table()
        self.store.overwrite(before)
        where = self.store.layout.columns
        x = after[:, where("position")] + np.repeat(corner, np.diff(self.store.blocks.start), axis=0)
        C = after[:, where("affine")].reshape(-1, DIM, DIM) * self.dx
        found = np.abs(C - slope).max() / np.abs(slope).max()
        if not self.flip:
            exact = constant + x @ slope.T
            found = max(found, np.abs(after[:, where("velocity")] - exact).max() / np.abs(exact).max())
        return float(found)


def measure(case, n_particles, flip, turns):
    """Row of the table."""
    solver = mpm_step.make_solver(case, n_particles, "f32", kernel="quadratic", gradient="affine",
                                  transfer="aflip" if flip else "apic")
    for _ in range(8):
        solver.step(solver.stable_dt()[0])
    solver.sort()
    n, dt = solver.particles.count, solver.stable_dt()[0]
    trials = {basis: Trial(solver, basis, flip) for basis in OFFSETS}
    row = {"case": case, "flip": int(flip), "particles": n, "per_block": n / solver.grid.n_tiles}
    calls = {"product_scatter": lambda: solver.particles_to_grid(dt)}
    calls |= {f"{basis}_{part}": getattr(trial, part) for basis, trial in trials.items()
              for part in ("scatter", "gather", "fused")}
    errors = {basis: trial.error() for basis, trial in trials.items()}
    spent = {name: [] for name in calls}
    for turn in range(turns + 1):
        for name, call in calls.items():
            begin = time.process_time()
            with runtime.precision("f32"):
                call()
            if turn:
                spent[name].append(1e9 * (time.process_time() - begin) / n)
    row |= {name: min(times) for name, times in spent.items()}
    for part in ("scatter", "gather", "fused"):
        pairs = zip(spent[f"compact_{part}"], spent[f"quadratic_{part}"], strict=True)
        row[f"{part}_ratio"] = median(one / other for one, other in pairs)
    for basis in OFFSETS:
        three = zip(*(spent[f"{basis}_{part}"] for part in ("fused", "scatter", "gather")), strict=True)
        row[f"fused_{basis}"] = median(one / (a + b) for one, a, b in three)
        row[f"error_{basis}"] = errors[basis]
    row["nodes"] = trials["compact"].n_nodes / trials["quadratic"].n_nodes
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", nargs="+", default=["block3", "layer3"])
    parser.add_argument("--particles", type=int, default=250_000)
    parser.add_argument("--turns", type=int, default=15)
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    options = parser.parse_args()
    runtime.start("cpu", threads=1)
    rows = []
    for case in options.case:
        for flip in (False, True):
            rows.append(measure(case, options.particles, flip, options.turns))
            print({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in rows[-1].items()},
                  flush=True)
    with open(options.output, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        for one in rows:
            writer.writerow({key: f"{value:.4g}" if isinstance(value, float) else value for key, value in one.items()})


if __name__ == "__main__":
    main()
