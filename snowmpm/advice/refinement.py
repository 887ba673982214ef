"""Cost of a finer grid, and whether it is affordable."""

from snowmpm import memory

LONGEST_ADVISED = 2 * 86400.0
"""Run time beyond which no finer grid is advised [s]: two days."""
GROWTH = 5.0
"""Ratio to the run time of the scene as it is, below which a finer grid is advised whatever its run time."""


def refined(facts, dx):
    """Approximate (seconds, bytes of memory) of a run of a scene (`SceneFacts`) on a grid of this spacing [m]:
    particles and blocks scale with the cells, steps with the spacing."""
    budget, finer = facts.budget, facts.dx / dx
    cells = finer**facts.dim
    stepping = budget.facts.steps * finer * budget.step(particles=cells, blocks=cells)
    store = facts.solver.particles
    size = memory.of_run(facts.dim, int(cells * budget.n), store.bytes_per_particle, sum(store.sizes.values()),
                         cells * facts.solver.memory)
    return budget.start + budget.frames_at(cells) + cells * budget.settling + stepping, size


def within_reach(facts, dx):
    """Whether a run on a grid of this spacing [m] is affordable on this machine."""
    seconds, size = refined(facts, dx)
    return size < memory.available() and seconds < max(LONGEST_ADVISED, GROWTH * facts.budget.total)
