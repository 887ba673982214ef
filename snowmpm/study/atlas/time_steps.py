"""Entries: steps that are too long, by what limits them."""

import math

import numpy as np

from snowmpm.errors import SimulationError
from snowmpm.materials import Elastic
from snowmpm.schemes import BASES, SCHEMES
from snowmpm.stepping.time_step import grain_stiffness
from snowmpm.study.atlas.entry import WORST, Entry
from snowmpm.study.atlas.stirring import DX, GROWTH, growth, lone_grain, motion, spread, stirred

ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
STEPS = 300
OFFSETS = (0.0, 0.25, 0.4999)
"""Places of a grain in its cell [cells]; the worst of them counts. Of averaged hats also half a box off a node."""
NAMED = {" ".join(scheme): dict(zip(("kernel", "gradient", "transfer"), scheme, strict=True)) for scheme in SCHEMES}
FLOWS = {"collapse": [[-1.0, 0.0], [0.0, -1.0]], "squeeze": [[-1.0, 0.0], [0.0, 0.0]],
         "shear": [[0.0, 1.0], [0.0, 0.0]], "expansion": [[1.0, 0.0], [0.0, 1.0]]}
GAIN = 1.2
"""Energy at the end over that at the start: a symplectic step swings by about C around what it holds."""


def _grown(grains, C, **scheme):
    """Growth of a stirred body at C sqrt(s)."""
    solver, energy = stirred(grains, ICE, **scheme)
    return growth(solver, energy, C / math.sqrt(grain_stiffness(ICE, 2)) * DX / ICE.wave_speed(), STEPS)


def lone(C, **scheme):
    """Growth of a grain alone, in the worst place of a cell."""
    box = BASES[scheme["kernel"]].box
    return max(_grown(lone_grain(2, offset), C, **scheme) for offset in (*OFFSETS, *([0.4999 * box] if box else [])))


def full(C, **scheme):
    """Growth of a body of 5 x 5 cells, 2 x 2 particles in each."""
    return _grown(spread(2, 5, 2, 0.25), C, **scheme)


def deformed(size, flow, transfer, stiffness=1.5):
    """Energy gained by a free block of 4 x 4 cells that deforms by |dt grad v| = size a step, at the start.

    stiffness: E / (rho dx^2) [1/s2] for a rate of 1/s, so low that the elastic limit plays no part.
    """
    L = np.array(FLOWS[flow])
    law = Elastic(density=300.0, youngs_modulus=300.0 * stiffness * DX**2, poisson_ratio=0.3)
    dt = size / np.linalg.norm(L)
    solver, _ = stirred(spread(2, 4, 2, 0.0), law, transfer=transfer)
    table, x = solver.particles.table(), solver.particles.positions()
    for name, values in (("velocity", (x - x.mean(axis=0)) @ L.T), ("affine", L.ravel()), ("elastic", 0.0),
                         ("stress", 0.0)):
        table[:, solver.particles.layout.columns(name)] = values
    solver.particles.overwrite(table)
    start, end = _energy(solver), 0.5 * np.pi * 4 * DX / law.wave_speed()
    try:
        while solver.time < end:
            solver.step(dt)
    except SimulationError:
        return WORST
    return _energy(solver) / start


def _energy(solver):
    store = solver.particles
    return motion(solver) + solver.materials.elastic_energy(store.labels()[:, 0], store.column("stress"),
                                                            store.column("state"), store.column("volume")[:, 0])


def crossed(cells, kernel):
    """Growth of a block that crosses so many cells in each of 40 steps, far below the elastic limit."""
    law = Elastic(density=300.0, youngs_modulus=1.0, poisson_ratio=0.3)
    dt = 0.1 * DX / law.wave_speed()
    drift = cells * DX / dt
    solver, energy = stirred(spread(2, 4, 2, 0.0), law, drift=drift, kernel=kernel, reach=80.0 * max(cells, 1.0))
    return growth(solver, energy, dt, 40, drift)


ENTRIES = (
    Entry(
        name="long_step_lone_grain", title="A step beyond that of a grain alone",
        scene="One grain alone on its nodes, at three places of a cell, stirred by 1e-6",
        seen="Its motion doubles every few steps; in a run, grains torn off a body shoot away from it and dt falls",
        cure="solver.cfl at most this border over sqrt(s), which the program keeps to by itself and refuses beyond",
        parameter="C sqrt(s) = c dt / dx sqrt(s)", unit="",
        values=(0.15, 0.3, *np.round(np.arange(0.5, 1.25, 0.05), 3)),
        settings=NAMED, symptom="growth of the stirring in 300 steps", limit=GROWTH, measure=lone,
        shown="quadratic affine pic", cured="quadratic affine apic"),
    Entry(
        name="long_step_body", title="A step beyond that of a full body",
        scene="A free body of 5 x 5 cells, 2 x 2 particles in each, stirred by 1e-6",
        seen="Waves of two cells grow until particles are thrown out of the body",
        cure="as for a grain alone, which fails first: a body bears 1.2 to 1.8 times that",
        parameter="C sqrt(s) = c dt / dx sqrt(s)", unit="", values=(0.2, 0.4, *np.round(np.arange(0.6, 1.85, 0.1), 3)),
        settings=NAMED, symptom="growth of the stirring in 300 steps", limit=GROWTH, measure=full,
        shown="quadratic shape apic", cured="cubic affine apic"),
    Entry(
        name="long_step_flip_ratio", title="Longest step against the share of FLIP",
        scene="The same body, with dt and flip_ratio varied",
        seen="What hands on v alone blows up first, at any share of FLIP; below that, FLIP keeps what stirred it",
        cure='transfer = "apic" or "aflip"',
        parameter="C sqrt(s) = c dt / dx sqrt(s)", unit="", values=tuple(np.round(np.arange(0.6, 1.65, 0.1), 3)),
        settings={f"{transfer} {ratio:g}": {"transfer": transfer, "flip_ratio": ratio}
                  for transfer in ("flip", "aflip") for ratio in (0.0, 0.5, 0.9, 0.97, 0.99, 1.0)},
        symptom="growth of the stirring in 300 steps", limit=GROWTH, measure=full, shown="flip 0.99",
        cured="aflip 0.99"),
    Entry(
        name="deformation_step", title="A step that deforms too much",
        scene="A free elastic block of 4 x 4 cells in uniform collapse, shear or expansion, the elastic limit far away",
        seen="Particles turn inside out, or the block gains energy out of nothing",
        cure="leave solver.dt out: the adaptive step keeps |dt grad v| below 0.3",
        parameter="|dt grad v|", unit="", values=tuple(np.round(np.arange(0.2, 0.85, 0.05), 3)),
        settings={f"{transfer} {flow}": {"transfer": transfer, "flow": flow} for transfer in ("pic", "apic", "aflip")
                  for flow in ("collapse", "shear", "expansion")},
        symptom="energy at the end over the start", limit=GAIN, measure=deformed, shown="apic collapse",
        cured="pic collapse"),
    Entry(
        name="crossing_step", title="A step that crosses more than a cell",
        scene="A soft block that flies through the empty grid, so many cells in each step",
        seen="Particles leave the reach of the block of the grid that they belong to; the run ends with that message",
        cure="leave solver.dt out: the adaptive step lets particles cross solver.cfl of a cell",
        parameter="cells crossed in a step", unit="cells",
        values=(0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0),
        settings={kernel: {"kernel": kernel} for kernel in ("quadratic", "cubic")},
        symptom="growth of the stirring in 40 steps", limit=GROWTH, measure=crossed, shown="quadratic"),
)
