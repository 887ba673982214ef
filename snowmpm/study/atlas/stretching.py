"""Entries: bodies drawn out or turned far."""

import numpy as np

from snowmpm.materials import Elastic
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, free_solver, lattice

DX, CELLS, GRIP, RATE = 0.05, 12, 2, 0.3
"""RATE: dF/dt [1/s]."""
BAR = Elastic(density=1e3, youngs_modulus=1e4, poisson_ratio=0.0)
HEAVY = BAR.model_copy(update={"density": 1e9})
SHORT_OF_FORCE, SWOLLEN = 0.1, 0.01
"""Limits of the entries below."""


def force_missing(stretch, per_axis=2, **scheme):
    """Share of the exact force that a bar drawn out to F = stretch does not carry; its grips fly apart.

    12 x 2 cells, E = 1e4 Pa, nu = 0; exact: P = E ln F / F, up to F = e, where a bar necks by nature.
    """
    length = CELLS * DX
    scheme = Scheme(**{"transfer": "apic", **scheme})
    x, volumes = lattice([-length / 2, 0.0], [length / 2, 2 * DX], DX, per_axis)
    solver = free_solver(x + np.array([0.013, 0.007]), volumes, [BAR, HEAVY], scheme, DX, reach=2 * length,
                         material=np.abs(x[:, 0]) > length / 2 - GRIP * DX,
                         velocities=np.stack([RATE * x[:, 0], 0 * x[:, 0]], axis=1))
    states = ParticleStates(solver)
    if scheme.affine:
        states.set(affine=np.tile([RATE, 0.0, 0.0, 0.0], (len(x), 1)))
    while 1.0 + RATE * solver.time < stretch - 1e-12:
        solver.step(min(solver.stable_dt()[0], (stretch - 1.0) / RATE - solver.time))
    stress = states.column("stress")[np.abs(x[:, 0]) < length / 4, 0]
    return 1.0 - stress.mean() / (BAR.youngs_modulus * np.log(stretch))


def swelling(angle, update):
    """|ln J| of a body after a whole turn in steps of `angle` [rad].

    imposed: f = I + dt grad v of a velocity given at the start, det f = 1 + angle^2 in each step; balanced: a disc of 4
    cells in radius whose forces turn its velocity within the step, as the program does.
    """
    if update == "imposed":
        return np.pi / angle * np.log1p(angle**2)
    law = Elastic(density=1e3, youngs_modulus=1e6, poisson_ratio=0.3)
    x, volumes = lattice([-4 * DX, -4 * DX], [4 * DX, 4 * DX], DX)
    inside = (x**2).sum(axis=1) < (4 * DX) ** 2
    x, volumes = x[inside], volumes[inside]
    dt = 0.4 * DX / law.wave_speed()
    omega = angle / dt
    solver = free_solver(x, volumes, law, Scheme("apic"), DX, reach=8 * DX,
                         velocities=omega * np.stack([-x[:, 1], x[:, 0]], axis=1))
    ParticleStates(solver).set(affine=np.tile([0.0, -omega, omega, 0.0], (len(x), 1)))
    volume = []
    for _ in range(round(2.0 * np.pi / angle)):
        solver.step(min(dt, solver.critical_dt()[0]))
        volume.append(np.log((solver.particles.column("volume_ratio") * solver.particles.column("volume")).sum()))
    # It swings about the volume that its centrifugal load asks for
    return abs(np.mean(volume[len(volume) // 2:]) - np.log(volumes.sum()) - _centrifugal(law, omega))


def _centrifugal(law, omega):
    """ln J that the load of the rotation itself gives a disc of 4 cells, in the mean (plane strain)."""
    nu, k = law.poisson_ratio, law.density * omega**2 * (4 * DX) ** 2 / (8 * (1 - law.poisson_ratio))
    radial, hoop = k * (3 - 2 * nu) * 0.5, k * ((3 - 2 * nu) - 0.5 * (1 + 2 * nu))
    return (1 + nu) * (1 - 2 * nu) * (radial + hoop) / law.youngs_modulus


ENTRIES = (
    Entry(
        name="numerical_fracture", title="Bodies torn by their own particles",
        scene="An elastic bar of 12 x 2 cells whose grips fly apart",
        seen="Particles lie more than a cell apart, cells between them empty, and the bar tears though its stuff holds",
        cure='more particles_per_cell, kernel = "cubic", gradient = "affine"', parameter="stretch F", unit="",
        values=(1.2, 1.4, 1.6, 1.8, 1.9, 2.0, 2.1, 2.2, 2.4, 2.6),
        settings={"quadratic 1": {"per_axis": 1}, "quadratic 2": {}, "quadratic 3": {"per_axis": 3},
                  "quadratic shape 2": {"gradient": "shape"}, "quadratic aflip 2": {"transfer": "aflip"},
                  "cubic 2": {"kernel": "cubic"}},
        symptom="share of the exact force missing", limit=SHORT_OF_FORCE, measure=force_missing, shown="quadratic 2",
        cured="quadratic 3"),
    Entry(
        name="spurious_swelling", title="Bodies that swell as they turn",
        scene="A disc of 4 cells in radius that spins for a turn; an imposed rotation beside it",
        seen="f = I + dt grad v of an imposed rotation has det f = 1 + angle^2: a snow block that rolls loses its"
             " strength by arithmetic. Cured by default: forces turn the velocity within the step",
        cure="nothing to set: only motion that is imposed on particles would show it", parameter="angle a step",
        unit="rad", values=(1e-3, 2e-3, 4e-3, 8e-3, 0.016, 0.032, 0.064),
        settings={update: {"update": update} for update in ("imposed", "balanced")},
        symptom="|ln J| after a turn", limit=SWOLLEN, measure=swelling, shown="imposed", cured="balanced"),
)
