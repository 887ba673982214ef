"""Entries: structures that bend in the snow."""

import numpy as np

from snowmpm.components.structures.from_scene import standing
from snowmpm.components.structures.mpm import OnNodes
from snowmpm.components.structures.rod import Rod
from snowmpm.components.structures.rods import Rods, Standing
from snowmpm.components.structures.section import Section
from snowmpm.errors import SimulationError
from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.scenes.schema import Scene
from snowmpm.study.atlas.entry import WORST, Entry
from snowmpm.study.problems.schemes import Scheme, lattice

DX = 0.05
SNOW = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
HEIGHT, PLATE = 8 * DX, 1.5 * DX
FOOT = 4.3 * DX + 0.5 * PLATE
"""x of a plate's middle [m]."""


def deflected(segments, even):
    """Error of the deflection of a rod of so many pieces at rest, against a beam; even: under a load along all of it,
    else at its end."""
    n, section = round(segments), Section.tube(0.06, 0.01, 2e9, 1000.0)
    rod = Rod(np.zeros(3), np.array([0.0, 0.0, 1.0]), n, section, damping=1.0)
    forces = np.zeros_like(rod.x)
    share = rod.masses / rod.masses.sum() if even else np.arange(n + 1) == n
    forces[:, 0] = 5.0 * share
    rod.advance(4.0 * 2.0 * np.pi / 1.8751040687**2 * np.sqrt(section.line_mass / section.bending), forces)
    return rod.x[-1, 0] / (5.0 / section.bending / (8.0 if even else 3.0)) - 1.0


def struck(ratio, coupling, contact):
    """Energy of a block and of the plate that it is thrown at, at the end over that at the start, less 1; ratio: mass
    of the snow in the cells on both sides of the plate over that of the plate."""
    return energies_after(ratio, coupling, contact, {"foot": [FOOT, 0.0], "top": [FOOT, HEIGHT], "segments": 4})[-1]


def energies_after(ratio, coupling, contact, structure):
    """The same after each step, at least 0, for a structure with these keys of a scene's."""
    block, volumes = lattice([0.0, 0.0], [4 * DX, 4 * DX], DX)
    speed = 0.01 * SNOW.wave_speed()
    density = 2.0 * DX * SNOW.density / (ratio * PLATE)
    scene = Scene.model_validate({
        "name": "struck", "dimension": 2, "end_time": 1.0, "solver": {"dx": DX}, "materials": {"snow": SNOW},
        "domain": {"min": [-1.0, 0.0], "max": [2.0, 2.0]},
        "bodies": [{"name": "block", "material": "snow",
                    "shape": {"kind": "box", "min": [0.0, 0.0], "max": [1.0, 1.0]}}],
        "structures": [{"name": "plate", "width": PLATE, "youngs_modulus": 1e6, "density": density, "damping": 0.0,
                        "coupling": coupling, "contact": contact, **structure}]})
    made, obstacles = standing(scene)
    adapter = OnNodes(Rods([Standing("plate", made[0], 0, coupling == "strong")], 2))
    solver = Scheme("apic").solver(
        Population(block, volumes, 0, np.tile([speed, 0.0], (len(block), 1))), [SNOW], dx=DX, origin=np.full(2, -1.0),
        lower=np.full(2, -1.0), upper=np.full(2, 2.0), gravity=np.zeros(2), obstacles=obstacles,
        adapters=[adapter])
    start, found = 0.5 * solver.particles.mass * speed**2, []
    try:
        while solver.time < 2.0 * DX / speed:
            solver.step(solver.stable_dt()[0])
            v = solver.particles.column("velocity")
            kinetic = 0.5 * float(solver.particles.masses() @ (v**2).sum(axis=1))
            found.append(max(0.0, (kinetic + made[0].energy) / start - 1.0))
    except SimulationError:
        found.append(WORST)
    return found


ENTRIES = (
    Entry(
        name="few_segments", title="A mast of few pieces", scene="A rod at rest under a load across it",
        seen="A chain of n straight pieces gives way further than the beam that it stands for, by 1 / 2n^2 under a load"
             " at its end", cure="more segments", parameter="segments", unit="",
        values=(2, 3, 4, 5, 6, 8, 12, 16), settings={"load at its end": {"even": False}, "even load": {"even": True}},
        symptom="error of the deflection", limit=0.02, measure=deflected, shown="load at its end", fails="below"),
    Entry(
        name="light_structure", title="A structure that the snow sticks to",
        scene="An elastic block that is thrown at a plate of four pieces",
        seen="With weak coupling the plate is thrown back by more than the snow came with, and the snow that sticks to"
             " it goes along: energy comes from nowhere. Snow that may leave does no harm",
        cure='contact = "separate", or coupling = "strong"',
        parameter="mass of the snow in the cells around it over its own", unit="",
        values=(0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 1.0, 2.0, 5.0, 10.0),
        settings={f"{coupling}, {contact}": {"coupling": coupling, "contact": contact}
                  for contact in ("stick", "separate") for coupling in ("weak", "strong")}, symptom="energy gained",
        limit=0.05, measure=struck, shown="weak, stick", cured="strong, stick", resolution=0.1),
)
