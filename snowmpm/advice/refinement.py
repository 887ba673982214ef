"""What a finer grid would cost: whether advice to take one can be followed."""

from snowmpm import memory

LONGEST_ADVISED = 2 * 86400.0
"""Run time beyond which no finer grid is advised [s]: two days."""
GROWTH = 5.0
"""Times as long as the scene as it is, below which it is advised however long that is."""


def refined(facts, dx):
    """-> (seconds, bytes of memory) of a run of a scene (`SceneFacts`) on a grid of this spacing [m], about: particles
    and blocks go with the cells, steps with the spacing."""
    budget, finer = facts.budget, facts.dx / dx
    cells = finer**facts.dim
    stepping = budget.facts.steps * finer * budget.step(particles=cells, blocks=cells)
    store = facts.solver.particles
    size = memory.of_run(facts.dim, int(cells * budget.n), store.bytes_per_particle, sum(store.sizes.values()),
                         cells * facts.solver.memory)
    return budget.start + budget.frames_at(cells) + cells * budget.settling + stepping, size


def within_reach(facts, dx):
    """Whether a run on a grid of this spacing [m] is one that a user can make on this machine."""
    seconds, size = refined(facts, dx)
    return size < memory.available() and seconds < max(LONGEST_ADVISED, GROWTH * facts.budget.total)
