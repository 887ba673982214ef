"""Entries: numbers too large or too small for their floats, and laws near their apex."""

import functools

import numpy as np

from snowmpm.materials import CohesiveCamClay, DruckerPrager, Elastic, MaterialPoint
from snowmpm.particles.population import Population
from snowmpm.study.atlas.entry import Entry
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import Scheme, free_solver, lattice

DX = 0.1
ICE = {"density": 250.0, "youngs_modulus": 3e6, "poisson_ratio": 0.3}
LAW = Elastic(**ICE)
SNOW = {**ICE, "critical_slope": 1.5, "cohesion": 0.3, "hardening": 1.0, "p0": 3e4}
MOVED, WRONG = 0.01, 0.01
"""Limits of the entries below."""
STEP = 1e-3
"""Way of a step [cells], as slow snow makes it."""


def way_lost(place, kept):
    """Relative error of the distance that a grain covers in 100 steps of STEP cells, `place` cells from the origin.

    kept: how positions are stored. "blocks": the program runs, in float32 relative to blocks of cells. "float32": in
    scene coordinates. "mesh": no grain moves; the largest error [cells] of the heights of a terrain over a cell, stored
    in float32.
    """
    far = place * DX
    if kept == "mesh":
        heights = far + np.linspace(0.0, DX, 101)
        return np.abs(heights.astype(np.float32).astype(float) - heights).max() / DX
    if kept == "float32":
        start = np.float32(far) + np.float32(0.3 * DX)
        x = start
        for _ in range(100):
            x = np.float32(x + np.float32(STEP * DX))
        return abs(float(x - start) / (100 * STEP * DX) - 1.0)
    dt = 0.1 * DX / LAW.wave_speed()
    start, speed = np.array([[far + 0.3 * DX, 0.3 * DX]]), STEP * DX / dt
    solver = Scheme("apic", precision="f32").solver(
        Population(start, np.full(1, 0.25 * DX**2), 0, np.array([[speed, 0.0]])), [LAW], dx=DX, origin=np.zeros(2),
        lower=np.array([0.0, -DX]), upper=np.array([far + 20 * DX, 20 * DX]), gravity=np.zeros(2))
    for _ in range(100):
        solver.step(dt)
    return abs((solver.particles.positions()[0, 0] - start[0, 0]) / (100 * STEP * DX) - 1.0)


def strain_noise(strain, precision):
    """Noise of the stress of a flying square that is stretched by `strain`, relative to that stress.

    It is the standard deviation over the particles of the difference from a run at a strain of 1e-5 in float64, after
    each stress is divided by its strain. precision: "f32" or "f64".
    """
    return (_stretched(strain, precision) - _stretched(1e-5, "f64")).std()


@functools.cache
def _stretched(strain, precision):
    """xx stress over (modulus x strain), (n,), of a square of 8 cells a side after 100 steps.

    In each step the square crosses a tenth of a cell, with velocities that are set to those of uniform stretching.
    """
    x, volumes = lattice([0.0, 0.0], [8 * DX, 8 * DX], DX)
    dt = 0.1 * DX / LAW.wave_speed()
    solver = free_solver(x + 0.37 * DX, volumes, LAW, Scheme("apic", precision=precision), DX, reach=20 * DX)
    states = ParticleStates(solver)
    rate = strain / (100 * dt)
    velocity = (0.1 * DX / dt + rate * (x - x.mean(axis=0))) * np.array([1.0, 0.0])
    for _ in range(100):
        states.set(velocity=velocity, affine=np.tile([rate, 0.0, 0.0, 0.0], (len(x), 1)))
        solver.step(dt)
    return states.column("stress")[:, 0] / (LAW.density * LAW.wave_speed() ** 2 * strain)


def apex_error(increment, law, return_map=None):
    """Largest error of the pressure on the way to the apex and beyond, relative to the strength there.

    increment: volumetric strain of a step; the reference takes 1000 steps. law: "cap" (`CohesiveCamClay`, with its
    return_map, "implicit" by default) or "cone" (`DruckerPrager`).
    """
    if law == "cap":
        material = CohesiveCamClay(**SNOW, return_map=return_map or "implicit")
        end, size = 0.02, material.cohesion * material.p0
    else:
        material = DruckerPrager(**ICE, friction_angle=30.0, cohesion=2e3)
        end, size = 0.02, 2e3
    coarse = _pulled(material, end, max(1, round(end / increment)))
    fine = _pulled(material, end, 1000)
    at = np.linspace(0.0, end, len(coarse))
    return np.abs(coarse - np.interp(at, np.linspace(0.0, end, len(fine)), fine)).max() / size


def _pulled(material, end, steps):
    """Pressure [Pa], compression positive, (steps + 1,), along an extension with shear to a strain of `end`."""
    strain = np.linspace(0.0, end, steps + 1)
    F = [np.array([[np.exp(e), 0.5 * e, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]) for e in strain]
    path = MaterialPoint(material, precision="f64").drive(np.array(F))
    return np.asarray(path.p)


ENTRIES = (
    Entry(
        name="far_from_origin", title="Coordinates far from the origin in float32",
        scene="A grain that makes a thousandth of a cell a step, so many cells from the origin; the terrain there",
        seen="A position in float32 no longer takes up its own step. Cured by default: positions are kept relative to"
             " blocks of cells. A binary STL still stores its vertices in float32",
        cure="OBJ, PLY or a raster for terrain in map coordinates", parameter="distance from the origin", unit="cells",
        values=(1e1, 1e2, 1e3, 1e4, 1e5, 1e6),
        settings={"positions in blocks": {"kept": "blocks"}, "plain float32": {"kept": "float32"},
                  "binary STL": {"kept": "mesh"}},
        symptom="error of the way, or of the height over a cell", limit=MOVED, measure=way_lost, shown="plain float32",
        cured="positions in blocks"),
    Entry(
        name="small_strains", title="Strains that are small beside the motion in float32",
        scene="A square of 8 cells that is stretched uniformly while it flies, a tenth of a cell a step for 100 steps",
        seen="Velocities are rounded to 6e-8 of themselves, and their differences are strains: noise in the stress. At"
             " rest there is none at any strain, since be - I is stored and not F",
        cure='solver.precision = "f64"', parameter="strain", unit="", fails="below",
        values=(1e-12, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3),
        settings={precision: {"precision": precision} for precision in ("f32", "f64")},
        symptom="noise over the stress", limit=WRONG, measure=strain_noise, shown="f32", cured="f64"),
    Entry(
        name="apex", title="Laws near their apex",
        scene="A material point that is pulled apart with shear, past its tensile tip, in steps",
        seen="Steps as large as the strain at which it breaks: stresses that are wrong by the strength itself",
        cure='return_map = "substepped"; a smaller solver.cfl', parameter="volumetric strain of a step", unit="",
        values=(2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2),
        settings={"cap, implicit": {"law": "cap"}, "cap, frozen": {"law": "cap", "return_map": "frozen"},
                  "cap, substepped": {"law": "cap", "return_map": "substepped"}, "cone": {"law": "cone"}},
        symptom="error of the pressure over the strength", limit=0.05, measure=apex_error, shown="cap, frozen",
        cured="cap, substepped"),
)
