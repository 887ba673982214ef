"""Entries: bodies that meet and part, on one velocity field and in fields of their own, and the stress where they
lie on each other."""

import numpy as np

from snowmpm.components.body_contact.mpm import BodyContact
from snowmpm.particles.population import Population
from snowmpm.study.atlas.contacts import DX, ICE
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.atlas.layers import DX as CELL
from snowmpm.study.atlas.layers import SOFT, WRONG_STRESS, G, stack
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, lattice

FELT, HELD = 0.01, 0.01
"""Limits of the entries below."""


def frictionless():
    """Contact of two bodies."""
    return BodyContact(np.zeros((2, 2)), ["", ""])


def two_blocks(gap, speed, separate, scheme):
    """Solver and states of two blocks of 4 x 4 cells, `gap` [cells] apart, each going at `speed` [m/s] to the other,
    and which particles are of the second; separate: each in a velocity field of its own."""
    left, volumes = lattice([0.0, 0.0], [4 * DX, 4 * DX], DX)
    left = left + 0.3 * DX
    x = np.concatenate([left, left + np.array([(4.0 + gap) * DX, 0.0])])
    second = np.repeat([False, True], len(left))
    velocities = np.where(second, -speed, speed)[:, None] * np.array([1.0, 0.0])
    population = Population(x, np.tile(volumes, 2), 0, velocities, field=second.astype(int) if separate else 0)
    solver = scheme.solver(population, [ICE], dx=DX, origin=np.full(2, -1.0), lower=np.full(2, -1.0),
                           upper=np.full(2, 2.0), gravity=np.zeros(2), adapters=[frictionless()] if separate else [])
    return solver, ParticleStates(solver), second


def approach_lost(gap, separate, **scheme):
    """Share of the speed of approach that two blocks have lost when they should be `gap` [cells] apart, having come
    from half a cell farther."""
    speed = 0.005 * ICE.wave_speed()
    solver, states, second = two_blocks(gap + 0.5, speed, separate, Scheme(**{"transfer": "apic", **scheme}))
    while solver.time < 0.25 * DX / speed:
        solver.step(solver.stable_dt()[0])
    v = states.column("velocity")[:, 0]
    return 1.0 - (v[~second].mean() - v[second].mean()) / (2.0 * speed)


def parting_lost(gap, separate, **scheme):
    """Share of the speed at which two blocks part that they have lost a cell farther apart, from `gap` [cells] on."""
    speed = 0.005 * ICE.wave_speed()
    solver, states, second = two_blocks(gap, -speed, separate, Scheme(**{"transfer": "apic", **scheme}))
    while solver.time < 0.5 * DX / speed:
        solver.step(solver.stable_dt()[0])
    v = states.column("velocity")[:, 0]
    return 1.0 - (v[second].mean() - v[~second].mean()) / (2.0 * speed)


def contact_stress(offset, separate=True, **scheme):
    """Largest error of the stress within a cell of the contact of two equal layers of 4 cells, which lies `offset`
    [cells] from a node."""
    chosen = Scheme(**{"transfer": "apic", **scheme})
    states, _ = stack([(4.0, SOFT), (4.0, SOFT)], chosen, offset, parted=frictionless() if separate else None)
    z = states.reference[:, 1] / CELL - offset
    exact, near = -SOFT.density * G * CELL * (8.0 - z), np.abs(z - 4.0) < 1.0
    return np.abs(states.column("stress")[near, 1] / exact[near] - 1.0).max()


MEETING = (
    Entry(
        name="early_contact", title="Bodies that meet before they touch",
        scene="Two elastic blocks that come towards each other, from half a cell farther",
        seen="They push each other across the empty cells that both give to: on one velocity field from the width of a"
             " spline, in fields of their own from about a cell",
        cure='contact = "separate" of one of the bodies halves it; a smaller solver.dx', parameter="distance left",
        unit="cells", values=(0.05, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0), fails="below",
        settings={"shared": {"separate": False}, "shared cubic": {"separate": False, "kernel": "cubic"},
                  "separate": {"separate": True}, "separate cubic": {"separate": True, "kernel": "cubic"}},
        symptom="speed of approach lost", limit=FELT, measure=approach_lost, shown="shared",
        cured="separate"),
    Entry(
        name="sticking", title="Bodies that do not part",
        scene="Two elastic blocks that go away from each other, a cell farther than they were",
        seen="On one velocity field what lies closer than the width of a spline holds together as if it were one body",
        cure='contact = "separate" of one of the bodies', parameter="distance at the start", unit="cells",
        values=(0.05, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0), fails="below",
        settings={"shared": {"separate": False}, "shared cubic": {"separate": False, "kernel": "cubic"},
                  "separate": {"separate": True}, "separate cubic": {"separate": True, "kernel": "cubic"}},
        symptom="speed of parting lost", limit=HELD, measure=parting_lost, shown="shared", cured="separate"),
)
STACKED = (
    Entry(
        name="stacked_bodies", title="Stresses beside a contact of two bodies",
        scene="Two equal layers of 4 cells, one on the other, each in a velocity field of its own, under their weight",
        seen="Where they meet at a node, the row of particles at the contact carries nothing and the next one twice as"
             " much; their sum is right, and so is what lies farther than two cells",
        cure="a contact that lies half a cell from the nodes; one body, or bodies that share their velocities, where"
             " they never part", parameter="distance of the contact from a node", unit="cells", fails="below",
        values=(0.0, 0.1, 0.2, 0.3, 0.4, 0.5), settings={
            "quadratic": {}, "shape": {"gradient": "shape"}, "cubic": {"kernel": "cubic"},
            "one body": {"separate": False}},
        symptom="error of the stress within a cell of the contact", limit=WRONG_STRESS, measure=contact_stress,
        shown="quadratic", cured="one body"),
)
ATLAS = {"contact": MEETING, "materials and layers": STACKED}
