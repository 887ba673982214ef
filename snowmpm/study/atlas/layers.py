"""Entries: materials and layers that a grid is too coarse for."""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.particles.population import Population
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, lattice

DX, G = 0.05, 1e-3
"""G: so small that strains are linear [m/s2]."""
SOFT = Elastic(density=250.0, youngs_modulus=1e6, poisson_ratio=0.0)
TOO_STIFF, WRONG_STRESS, WRONG_HEIGHT = 0.05, 0.5, 0.2
"""Limits of the entries below."""


def too_stiff(ratio, per_axis=2, **scheme):
    """How much too fast a vortex swings that changes no volume: v = (sin kx cos kz, -cos kx sin kz) in a periodic
    square of 16 cells, omega^2 = 2 k^2 G / rho whatever the bulk modulus; ratio: K / G."""
    law = Elastic(density=1000.0, youngs_modulus=1e6, poisson_ratio=(3.0 * ratio - 2.0) / (6.0 * ratio + 2.0))
    size, k, speed = 16 * DX, 2.0 * np.pi / (16 * DX), 1e-5
    x, volumes = lattice([0.0, 0.0], [size, size], DX, per_axis)
    scheme = Scheme(**{"transfer": "apic", **scheme})
    solver = scheme.solver(Population(x, volumes, 0), [law], dx=DX, origin=np.zeros(2), lower=np.zeros(2),
                           upper=np.full(2, size), gravity=np.zeros(2), sides=[["periodic", "periodic"]] * 2)
    states, (a, b) = ParticleStates(solver), k * x.T
    mode = np.stack([np.sin(a) * np.cos(b), -np.cos(a) * np.sin(b)], axis=1)
    states.set(velocity=speed * mode)
    if scheme.affine:
        c, s = np.cos(a) * np.cos(b), np.sin(a) * np.sin(b)
        states.set(affine=speed * k * np.stack([c, -s, s, -c], axis=1))
    exact, before = 0.5 * np.pi / (k * np.sqrt(2.0 * law.shear_modulus / law.density)), 1.0
    dt = min(solver.stable_dt()[0], exact / 50.0)
    while solver.time < 1.5 * exact:
        solver.step(dt)
        swing = (states.column("velocity") * mode).sum() / (speed * (mode**2).sum())
        if swing <= 0.0:
            quarter = solver.time - 0.5 * dt + dt * swing / (before - swing)  # v is half a step behind
            return exact / quarter - 1.0
        before = swing
    return -1.0


def stack(layers, scheme, base=0.0, per_axis=2, parted=None):
    """Relaxed column of layers [(thickness [cells], law)] from the ground up under a weak weight, two cells wide
    between smooth walls.

    base: of the ground from a node [cells]; parted: adapter of what parts velocity fields, so that each layer has one
    of its own, eight cells wide and periodic, for what lies at a smooth wall has no clear direction of contact. ->
    states, and the layer of each particle.
    """
    wide = 8 if parted else 2
    parts, bottom = [], base * DX
    for thickness, _ in layers:
        rows = max(1, int(np.ceil(per_axis * thickness - 1e-9)))
        height = thickness * DX
        across = (np.arange(wide * per_axis) + 0.5) * DX / per_axis
        up = bottom + (np.arange(rows) + 0.5) * height / rows
        parts.append((np.stack(np.meshgrid(across, up, indexing="ij"), axis=-1).reshape(-1, 2),
                      height / rows * DX / per_axis))
        bottom += height
    layer = np.repeat(np.arange(len(parts)), [len(x) for x, _ in parts])
    volumes = np.concatenate([np.full(len(x), volume) for x, volume in parts])
    population = Population(np.concatenate([x for x, _ in parts]), volumes, layer, field=layer if parted else 0)
    solver = scheme.solver(population, [law for _, law in layers], dx=DX, origin=np.zeros(2),
                           adapters=(parted,) if parted else (),
                           lower=np.array([0.0, base * DX]), upper=np.array([wide * DX, bottom + 2 * DX]),
                           gravity=np.array([0.0, -G]),
                           sides=[["periodic" if parted else "slip"] * 2, ["stick", "open"]])
    states = ParticleStates(solver)
    # Slowest swing: the column as if all its weight stood on top of its springs in a row
    weight = sum(t * law.density for t, law in layers) * DX
    softness = sum(t / law.youngs_modulus for t, law in layers) * DX
    slowest = 1.0 / np.sqrt(weight * softness)
    while solver.time < (24.0 if parted else 8.0) / slowest:
        dt = solver.stable_dt()[0]
        solver.damping_factor = max(0.0, 1.0 - 2.0 * dt * slowest)
        solver.step(dt)
    return states, layer


def interface_stress(contrast, base=0.0, **scheme):
    """Error of the stress in a stiff layer of 4 cells, within a cell of the soft one of 4 cells that carries it;
    contrast: of their moduli."""
    stiff = SOFT.model_copy(update={"youngs_modulus": contrast * SOFT.youngs_modulus})
    states, layer = stack([(4.0, SOFT), (4.0, stiff)], Scheme(**{"transfer": "apic", **scheme}), base)
    z = states.reference[:, 1] / DX - base
    near = (layer == 1) & (z < 5.0)
    exact = -SOFT.density * G * DX * (8.0 - z)
    stress = states.column("stress")[:, 1]
    return np.sqrt((((stress - exact) / exact)[near] ** 2).mean())


def sinking(thickness, contrast, **scheme):
    """Error of how far a slab of 4 cells sinks that stands, on 2 cells of its own stuff, on a soft layer of `thickness`
    [cells] between; contrast: of their moduli."""
    stiff = SOFT.model_copy(update={"youngs_modulus": contrast * SOFT.youngs_modulus})
    states, layer = stack([(2.0, stiff), (thickness, SOFT), (4.0, stiff)], Scheme(**{"transfer": "apic", **scheme}),
                          0.37)
    # Of the slab's middle: weight above each part over its modulus
    top = SOFT.density * G * 4.0 * DX
    own = SOFT.density * G * thickness * DX
    through = (top + 0.5 * own) * thickness * DX / SOFT.youngs_modulus
    base = (top + own + SOFT.density * G * DX) * 2.0 * DX / stiff.youngs_modulus
    slab = SOFT.density * G * 4.0 * DX * 4.0 * DX * (1 / 3) / stiff.youngs_modulus  # mean of L y - y2 / 2
    sunk = (states.reference[:, 1] - states.positions()[:, 1])[layer == 2].mean()
    return sunk / (through + base + slab) - 1.0


ENTRIES = (
    Entry(
        name="volumetric_locking", title="Volumetric locking",
        scene="A vortex that changes no volume, in a periodic elastic square of 16 cells",
        seen="The nearer the material is to incompressible, the stiffer it is in motions that should not compress it",
        cure="poisson_ratio below the border", parameter="K / G", unit="",
        values=(1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0),
        settings={"quadratic 4": {}, "quadratic 9": {"per_axis": 3}, "quadratic shape 4": {"gradient": "shape"},
                  "cubic 4": {"kernel": "cubic"}, "cubic shape 4": {"kernel": "cubic", "gradient": "shape"}},
        symptom="frequency over the exact one, less 1", limit=TOO_STIFF, measure=too_stiff, shown="quadratic 4"),
    Entry(
        name="stiffness_contrast", title="Ice beside fluffy snow",
        scene="A stiff layer of 4 cells on a soft one of 4, at rest under their weight",
        seen="Particles of the stiff layer that share a cell with the soft one get its strain, and a stress that is"
             " wrong by as much as the moduli differ; the stiff one also sets the step of the whole scene",
        cure="a smaller contrast: what is much stiffer need not be that stiff; stresses farther than a cell from the"
             " interface are right",
        parameter="ratio of the moduli", unit="", values=(1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0),
        settings={"quadratic": {}, "between nodes": {"base": 0.5}, "shape": {"gradient": "shape"},
                  "cubic": {"kernel": "cubic"}},
        symptom="error of the stress beside the interface", limit=WRONG_STRESS, measure=interface_stress,
        shown="quadratic"),
    Entry(
        name="thin_layer", title="A layer thinner than a cell",
        scene="A slab of 4 cells on a soft layer, on 2 cells of the slab's stuff, at rest under their weight",
        seen="The layer sinks by less than it should: its softness is spread over whole cells",
        cure="a smaller solver.dx; or the layer drawn thicker with its stiffness per area (saw_test.weak_layer.cells)",
        parameter="thickness of the layer", unit="cells", values=(0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0),
        fails="below",
        settings={"1 : 5": {"contrast": 5.0}, "1 : 20": {"contrast": 20.0},
                  "1 : 20 shape": {"contrast": 20.0, "gradient": "shape"},
                  "1 : 20 cubic": {"contrast": 20.0, "kernel": "cubic"}},
        symptom="error of how far the slab sinks", limit=WRONG_HEIGHT, measure=sinking, shown="1 : 20", cured="1 : 5"),
)
