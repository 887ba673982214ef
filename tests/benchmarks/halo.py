"""What one MPM run over several machines would send: library scenes cut into parts, and their borders counted.

    python tests/benchmarks/halo.py [NAME ...] [-o FILE]
    python tests/benchmarks/halo.py --cards          # several cards in one machine, from the table that is there

A scene is computed to the times given in CASES. Then its blocks of cells are cut in plan, by recursive bisection of the
longer side, into 2, 4, 8 and 16 parts of equal work. A node block belongs to every part whose particles reach it (the
bits that the gather leaves). Each part would send its own sums of the node blocks that it shares to each other part
that has them, and so would all know the same nodes. Nothing is sent here: it is a count.

Columns: scene; time [s]; particles; blocks; parts; heaviest: work of the heaviest part over the mean; shared: node
blocks that more than one part reaches, over all that are reached; sent: bytes a step that the part which sends most
sends, 64 nodes a block; neighbours: parts that it sends to, at most; a_step: seconds of a step on one thread here;
of_part: that of the heaviest part on a machine of 16 threads at 70 %; ethernet, infiniband: what a part waits for in a
step by 1.2 GB/s and 50 us a message, by 12 GB/s and 2 us, over of_part: its messages one after the other, and three
rounds for the length of the step; moved: particles that change their part at the next sort, over all.

`--cards`: the slab at rest with more particles, cut into as many parts as there are cards. What is sent grows with the
surface of a part, N^(2/3). Columns: particles; cards; sent: bytes a step by the card that sends most; kernels: seconds
that the heaviest part takes; sort: that one CPU takes for all, a step; nvlink, pcie, infiniband: what a step waits,
over kernels; faster: than on one card, by NVLink; most: the same if the sort were shared out.
"""

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from snowmpm import Simulation
from snowmpm.compiler import runtime
from snowmpm.mpm.node import block_nodes, node_size
from snowmpm.scenes import load_scene

TABLE = Path(__file__).parent / "figures" / "halo.csv"
CASES = {
    "avalanche_on_raster": ({"solver.dx": 2.5}, (0.0, 12.0)),
    "slab_release_resolved": ({"solver.dx": 0.5}, (0.0,)),
    "column_collapse_3d": ({}, (0.0, 0.3)),
}
PARTS = 2, 4, 8, 16
BLOCK_WORK = 20
"""Work of a block beside that of its particles, in particles."""
THREADS, EFFICIENCY = 16, 0.7
NETWORKS = {"ethernet": (1.2e9, 50e-6), "infiniband": (12e9, 2e-6)}
"""Bytes a second, seconds a message."""
ROUNDS = 3

CARD_NS, SORT_NS = 1.95, 0.7
"""Of a particle and step on one H200 [ns], with 10^7 of them (docs/speed.md): its kernels, and the sort, most of which
is tables that the CPU makes."""
LINKS = {"nvlink": (450e9, 3e-6), "pcie": (50e9, 5e-6), "infiniband": (50e9, 3e-6)}
"""Between cards: bytes a second one way, seconds a message; InfiniBand of 400 Gb/s, between machines."""
SIZES = (1e7, (2, 4)), (1e8, (2, 4, 8))
"""Particles, and numbers of cards: between 2.5 million a card, where CARD_NS was measured, and what a card holds."""
CARDS = TABLE.with_name("halo_cards.csv")


def cut(coordinates, work, parts):
    """Tree of cuts in plan: a part's number, or (axis, first coordinate behind the cut, before, behind)."""
    numbers = iter(range(parts))

    def split(rows, parts):
        if parts == 1:
            return next(numbers)
        plan = coordinates[rows, :-1]
        axis = int(np.argmax(np.ptp(plan, axis=0))) if len(rows) else 0
        order = np.argsort(plan[:, axis], kind="stable")
        half = np.searchsorted(np.cumsum(work[rows][order]), 0.5 * work[rows].sum())
        level = plan[order[min(half, len(rows) - 1)], axis]
        behind = plan[:, axis] >= level
        return axis, level, split(rows[~behind], parts // 2), split(rows[behind], parts // 2)

    return split(np.arange(len(coordinates)), parts)


def part_of(tree, coordinates):
    """Part of each block (n,)."""
    if not isinstance(tree, tuple):
        return np.full(len(coordinates), tree)
    axis, level, before, behind = tree
    return np.where(coordinates[:, axis] >= level, part_of(behind, coordinates), part_of(before, coordinates))


def shared(grid, owner, parts):
    """Which parts reach each node block, (node blocks, parts), of `TileGrid` and the part of each of its tiles."""
    start, tiles_at = grid._tile_table
    bits = grid.active_nodes.to_numpy()[: grid.n_tiles, 6]
    comes = (bits[tiles_at[:, 0]] & tiles_at[:, 1]) == tiles_at[:, 1]
    block = np.repeat(np.arange(grid.n_node_blocks), np.diff(start))
    reached = np.zeros((grid.n_node_blocks, parts), bool)
    reached[block[comes], owner[tiles_at[comes, 0]]] = True
    return reached


def owners(solver, tree):
    """Part of each particle, by its number."""
    blocks = solver.particles.blocks
    part = np.repeat(part_of(tree, blocks.coordinates), np.diff(blocks.start))
    found = np.full(int(solver.particles.labels()[:, 1].max()) + 1, -1)
    found[solver.particles.labels()[:, 1]] = part
    return found


def rows_of(name, settings, times):
    simulation = Simulation(load_scene(name, settings))
    solver = simulation.solver
    for until in times:
        while simulation.time < until:
            simulation.step()
        for _ in range(3):
            simulation.step()
        solver.sort()
        simulation.step()  # whose gather leaves what is reached
        blocks, grid = solver.particles.blocks, solver.grid
        work = np.diff(blocks.start) + BLOCK_WORK
        trees = {parts: cut(blocks.coordinates, work, parts) for parts in PARTS}
        reached = {parts: shared(grid, part_of(trees[parts], blocks.coordinates), parts) for parts in PARTS}
        before = {parts: owners(solver, tree) for parts, tree in trees.items()}
        head = {"scene": name, "time": round(simulation.time, 3), "particles": solver.particles.count,
                "blocks": len(blocks)}
        load = {parts: np.bincount(part_of(tree, blocks.coordinates), work, parts) for parts, tree in trees.items()}
        sorts, steps, began = solver.particles.sorts, 0, time.process_time()
        while solver.particles.sorts == sorts and steps < 100:
            simulation.step()
            steps += 1
        seconds = (time.process_time() - began) / steps
        node_bytes = block_nodes(solver.dim) * node_size(solver.flip) * np.dtype(solver.particles.numpy_dtype).itemsize
        for parts, tree in trees.items():
            yield head | row(reached[parts], load[parts], node_bytes, seconds) | {
                "moved": float((before[parts] != owners(solver, tree)).mean()), "parts": parts}


def row(reached, load, node_bytes, seconds):
    """What a step sends, and how long that takes."""
    both = reached.astype(np.int64).T @ reached
    np.fill_diagonal(both, 0)
    sent, neighbours = both.sum(1) * node_bytes, (both > 0).sum(1)
    heaviest = load.max() / load.mean()
    share = seconds * heaviest / len(load) / (THREADS * EFFICIENCY)
    found = {"heaviest": heaviest, "shared": float((reached.sum(1) > 1).sum() / reached.any(1).sum()),
             "sent": int(sent.max()), "neighbours": int(neighbours.max()), "a_step": seconds, "of_part": share}
    for name, (rate, latency) in NETWORKS.items():
        wait = float((sent / rate + neighbours * latency).max()) + ROUNDS * latency
        found[name] = wait / share
    return found


def rows_of_cards():
    """Rows of the slab on several cards."""
    with open(TABLE, newline="", encoding="utf-8") as file:
        slab = {int(row["parts"]): row for row in csv.DictReader(file) if row["scene"] == "slab_release_resolved"}
    for particles, numbers in SIZES:
        for cards in numbers:
            row = slab[cards]
            sent = float(row["sent"]) * (particles / float(row["particles"])) ** (2.0 / 3.0)
            kernels = 1e-9 * CARD_NS * particles * float(row["heaviest"]) / cards
            sort = 1e-9 * SORT_NS * particles
            waits = {name: sent / rate + (int(row["neighbours"]) + ROUNDS) * latency
                     for name, (rate, latency) in LINKS.items()}
            alone = 1e-9 * CARD_NS * particles + sort
            yield {"particles": particles, "cards": cards, "sent": sent, "kernels": kernels, "sort": sort,
                   **{name: wait / kernels for name, wait in waits.items()},
                   "faster": alone / (kernels + sort + waits["nvlink"]),
                   "most": alone / (kernels + sort / cards + waits["nvlink"])}


def write(rows, path):
    """Print rows as they come, and write them as a table."""
    shown = []
    for row in rows:
        shown.append({key: f"{value:.3g}" if isinstance(value, float) else value for key, value in row.items()})
        print(shown[-1], flush=True)
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, shown[0], lineterminator="\n")
        writer.writeheader()
        writer.writerows(shown)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help=f"scenes, of {', '.join(CASES)}; all when missing")
    parser.add_argument("-o", "--output", type=Path, help="table; in tests/benchmarks/figures when missing")
    parser.add_argument("--cards", action="store_true", help="several cards, from the table that is there")
    options = parser.parse_args()
    if unknown := set(options.names) - set(CASES):
        parser.error(f"{', '.join(sorted(unknown))}: not one of {', '.join(CASES)}")
    if options.cards and options.names:
        parser.error("--cards takes no scenes")
    output = options.output or (CARDS if options.cards else TABLE)
    output.parent.mkdir(parents=True, exist_ok=True)
    if options.cards:
        write(rows_of_cards(), output)
        return
    runtime.start("cpu", threads=1)
    write((row for name in options.names or CASES for row in rows_of(name, *CASES[name])), output)


if __name__ == "__main__":
    main()
