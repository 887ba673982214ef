"""Speed against size: time of a particle-step of a block of snow, from a thousand particles to a million.

A cube (3-D) or square (plane strain) of cohesive snow that shakes in the air, by the program's own choice, on as many
threads as the command was given. Small scenes pay for the launch of the kernels, large ones for the memory.
"""

import os
from pathlib import Path

import numpy as np

from snowmpm.compiler import runtime
from snowmpm.draft import write_table
from snowmpm.errors import InputError
from snowmpm.particles.population import Population
from snowmpm.render.work_precision_plot import Curve, Panel, render_work_precision
from snowmpm.stages import counted
from snowmpm.study.measurement import TimedScheme
from snowmpm.study.problems.piston import FIRM
from snowmpm.study.problems.schemes import lattice
from snowmpm.study.stopwatch import WARM_UP

COLUMNS = ("dimension", "precision", "threads", "particles", "steps", "ns_per_particle_step", "load")
SIZES, QUICK = (1_000, 4_000, 16_000, 64_000, 250_000, 1_000_000), (1_000, 8_000, 64_000)
CASES = {"2-D f32": (2, "f32"), "3-D f32": (3, "f32"), "3-D f64": (3, "f64")}
DX = 0.1
PARTICLE_STEPS = 2_000_000
"""Of a measurement, at least ten steps."""


def study(folder, *, quick=False, only=(), say=print):
    """Measure and draw; -> paths. only: names of CASES."""
    for name in only:
        if name not in CASES:
            raise InputError.at("--only", name, f"must be one of {', '.join(CASES)}")
    folder, rows, curves = Path(folder), [], []
    for name in only or CASES:
        own = [measure(*CASES[name], size) for size in counted(QUICK if quick else SIZES, f"scaling: {name}", "sizes")]
        for row in own:
            say(f"{name}: {row['particles']} particles, {row['ns_per_particle_step']:.0f} ns a particle-step")
        rows += own
        curves.append(Curve(name, name, tuple(row["particles"] for row in own),
                            tuple(row["ns_per_particle_step"] for row in own)))
    table = write_table(folder / "scaling.csv", COLUMNS, [[row[name] for name in COLUMNS] for row in rows])
    panel = Panel(f"{runtime.threads()} thread(s)", tuple(curves))
    drawn = render_work_precision([panel], folder / "scaling.png", x_label="particles", columns=1, size=(7.0, 4.6),
                                  y_label="processor nanoseconds a particle-step", title="Speed against size")
    return [table, drawn]


def measure(dim, precision, size):
    """Row of a block of about `size` particles."""
    cells = max(2, round((size / 2**dim) ** (1.0 / dim)))
    x, volumes = lattice([0.0] * dim, [cells * DX] * dim, DX)
    velocities = 0.3 * np.sin(5.0 * x[:, ::-1])
    timed = TimedScheme("apic", precision=precision)
    room = np.full(dim, cells * DX)
    solver = timed.solver(Population(x, volumes, 0, velocities), [FIRM], dx=DX, origin=-room, lower=-room,
                          upper=2.0 * room, gravity=np.zeros(dim))
    steps = max(10, PARTICLE_STEPS // len(x)) + WARM_UP
    for _ in range(steps):
        solver.step(solver.stable_dt()[0])
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return {"dimension": dim, "precision": precision, "threads": runtime.threads(), "particles": len(x), "steps": steps,
            "ns_per_particle_step": float(f"{1e9 * timed.watch.seconds / timed.watch.particle_steps:.4g}"),
            "load": round(load, 1)}
