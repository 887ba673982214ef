"""Entries: bodies that hit what is rigid."""

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.solids import Obstacle
from snowmpm.solids.motion import RigidMotion
from snowmpm.solids.primitives import BOX
from snowmpm.solids.shape import SolidShape
from snowmpm.study.atlas.entry import WORST, Entry
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, lattice

DX = 0.05
ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
THROUGH = 0.01
"""Limit of the entry below."""


def through_wall(thickness, offset=0.3, **scheme):
    """Share of the momentum of a block thrown at a wall of `thickness` [cells] that a block at rest on its other side
    has got; offset: of the wall from a node [cells]."""
    block, volumes = lattice([0.0, 0.0], [4 * DX, 4 * DX], DX)
    speed, face = 0.02 * ICE.wave_speed(), (8.0 + offset) * DX
    x = np.concatenate([block + np.array([face - 4.25 * DX, 0.0]), block + np.array([face + thickness * DX, 0.0])])
    second = np.repeat([False, True], len(block))
    middle = np.array([face + 0.5 * thickness * DX, 2 * DX])
    wall = Obstacle("wall", SolidShape(BOX, middle, np.eye(2), np.array([0.5 * thickness, 20.0]) * DX),
                    RigidMotion(middle, None), "separate", 0.0)
    solver = Scheme(**{"transfer": "apic", **scheme}).solver(
        Population(x, np.tile(volumes, 2), 0, np.where(second[:, None], 0.0, [speed, 0.0])), [ICE], dx=DX,
        origin=np.full(2, -1.0), lower=np.full(2, -1.0), upper=np.full(2, 2.0), gravity=np.zeros(2), obstacles=[wall])
    states = ParticleStates(solver)
    while solver.time < 0.25 * DX / speed + 8 * DX / ICE.wave_speed():
        solver.step(solver.stable_dt()[0])
    return np.abs(states.column("velocity")[second, 0].mean()) / speed


def impact_failure(mach, cfl, adaptive=True):
    """Energy at the end over the start of a block of 4 x 4 cells thrown at a wall at `mach` (of its waves), less 1, but
    for what the wall took; adaptive: by the program's own steps, else by steps that the speed is not heeded in."""
    x, volumes = lattice([0.0, 0.0], [4 * DX, 4 * DX], DX)
    speed = mach * ICE.wave_speed()
    solver = Scheme("apic", cfl=cfl).solver(
        Population(x + np.array([DX, 0.0]), volumes, 0, np.tile([-speed, 0.0], (len(x), 1))), [ICE], dx=DX,
        origin=np.zeros(2), lower=np.array([0.0, -1.0]), upper=np.full(2, 2.0), gravity=np.zeros(2),
        sides=[["separate", "open"], ["open", "open"]])
    fixed = cfl * DX / ICE.wave_speed()
    try:
        for _ in range(400):
            if solver.time > DX / speed + 8 * DX / ICE.wave_speed():
                break
            solver.step(solver.stable_dt()[0] if adaptive else fixed)
    except SimulationError:
        return WORST
    v = solver.particles.column("velocity")
    start = 0.5 * solver.particles.mass * speed**2
    gained = 0.5 * float(solver.particles.masses() @ (v**2).sum(axis=1)) / start - 1.0
    return max(0.0, gained)


ENTRIES = (
    Entry(
        name="thin_obstacle", title="Walls that snow is felt through",
        scene="An elastic block thrown at a wall, another one at rest on its other side",
        seen="Nothing goes through, however thin the wall; but both blocks give to the same nodes, and the one behind"
             " is pushed",
        cure="an obstacle that is at least so many cells thick, or a smaller solver.dx",
        parameter="thickness of the wall", unit="cells",
        values=(0.1, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0), fails="below",
        settings={"between nodes": {}, "on a node": {"offset": 0.0}, "cubic": {"kernel": "cubic"}},
        symptom="share of the momentum felt behind the wall", limit=THROUGH, measure=through_wall,
        shown="between nodes"),
    Entry(
        name="fast_impact", title="Impacts as fast as waves",
        scene="An elastic block of 4 x 4 cells thrown at a wall (80 m/s of snow with waves of 130 m/s: 0.6)",
        seen="Steps that heed elastic waves only: particles turn inside out, or fly off with more energy than they had",
        cure="leave solver.dt out: the adaptive step follows speed and deformation",
        parameter="speed over that of waves", unit="", values=(0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0),
        settings={"adaptive 0.4": {"cfl": 0.4}, "adaptive 0.8": {"cfl": 0.8},
                  "elastic step 0.4": {"cfl": 0.4, "adaptive": False},
                  "elastic step 0.8": {"cfl": 0.8, "adaptive": False}},
        symptom="kinetic energy gained", limit=0.05, measure=impact_failure, shown="elastic step 0.8",
        cured="adaptive 0.4"),
)
