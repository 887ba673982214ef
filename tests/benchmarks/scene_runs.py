"""Processor time of the library's scenes, by stage: what `snowmpm check` is held against.

    python tests/benchmarks/scene_runs.py [NAME ...] [--most SECONDS] [--set KEY=VALUE ...] [-o FILE]

Each scene runs in a process of its own, on one thread, from its start until it ends or its steps have taken `--most`
seconds: the column `part` says to which time it came. Frames are written as in `snowmpm run`, each finished before the
next step, so that its time is its own. All times are processor time of the whole process, which other programs lengthen
less than time by the clock. Rows of scenes that are not named stay in the table.

Columns: scene; settings, those that differ from the library's; machine; threads; precision; part, end_time [s];
particles at the start; settling: steps before the clock starts; steps; particle_steps; frames beside the first;
blocks of nodes, contact_blocks: means over the steps; seconds of: start (imports, build, kernels), settling, scatter,
grid, contact, gather, sort, rest of the steps (choice of dt, audit of loads, events), output; total; vector, python:
speed of the machine in the same process [ns] (`snowmpm.advice.calibration`).
"""

import argparse
import csv
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import mean

TABLE = Path(__file__).parents[2] / "snowmpm" / "measured" / "scene_runs.csv"
STAGES = ("start", "settling", "scatter", "grid", "contact", "gather", "sort", "rest", "output")
COLUMNS = ("scene", "settings", "machine", "threads", "precision", "part", "end_time", "particles", "settling_steps",
           "steps", "particle_steps", "frames", "blocks", "contact_blocks", *STAGES, "total", "vector", "python")
PARTS = {"particles_to_grid": "scatter", "update_grid": "grid", "grid_to_particles": "gather", "sort": "sort"}
SAMPLES = 40
EVERY = 0.2
"""Seconds of steps between samples of the speed of the machine, whose cores others may share."""
WARM_UP = 3
"""First steps of a solver, in which kernels are compiled or loaded: they count as start."""


class Stages:
    """Processor seconds of the parts of a solver's steps, after the first `WARM_UP` ones; settling apart."""

    def __init__(self, method):
        from snowmpm.methods import METHODS

        self.on_grid = METHODS[method].capabilities.grid
        self.seconds, self.count, self.blocks, self.contacts, self.particle_steps = {}, {}, 0, 0, 0
        self.settling, self._seen = False, 0

    def time_steps_of(self, solver):
        for name, stage in PARTS.items():
            if hasattr(solver, name):
                setattr(solver, name, self._timed(stage, getattr(solver, name)))
        if self.on_grid:
            solver.grid.apply_contact = self._timed("contact", solver.grid.apply_contact)
        step = self._timed("step", solver.step)

        def counted(dt):
            step(dt)
            self._seen += 1
            if self._seen == WARM_UP:
                self.seconds.clear()
            elif self._seen > WARM_UP:
                self._count(solver)
        solver.step = counted
        return solver

    def _count(self, solver):
        kind = "settling" if self.settling else "steps"
        self.count[kind] = self.count.get(kind, 0) + 1
        if not self.settling:
            self.particle_steps += solver.particles.count
            if self.on_grid:
                self.blocks += solver.grid.n_node_blocks
                self.contacts += solver.grid.contact.n

    def _timed(self, name, call):
        def measured(*arguments):
            start = time.process_time()
            try:
                return call(*arguments)
            finally:
                stage = "settling" if self.settling and name == "step" else name
                if not self.settling or name == "step":
                    self.seconds[stage] = self.seconds.get(stage, 0.0) + time.process_time() - start
        return measured


def measure(name, settings, most):
    """Row of the table, and samples of the state over the run."""
    start = time.process_time()
    from snowmpm.advice.calibration import speed_now
    from snowmpm.cli.options import scene_overrides
    from snowmpm.compiler import runtime
    from snowmpm.running.device import device_name
    from snowmpm.running.recorder import Recorder
    from snowmpm.running.rest import StopAtRest
    from snowmpm.running.simulation import Simulation
    from snowmpm.scenes import load_scene
    from snowmpm.setup.model import Model

    scene = load_scene(name, scene_overrides(settings))
    runtime.start("cpu", threads=1)
    stages, make, settle = Stages(scene.solver.method), Model.solver, Simulation.settle
    Model.solver = lambda model: stages.time_steps_of(make(model))

    def settled(simulation):
        stages.settling = True
        settle(simulation)
        stages.settling = False
    Simulation.settle = settled
    simulation = Simulation(scene)
    solver, spent = simulation.solver, stages.seconds
    with tempfile.TemporaryDirectory() as folder:
        recorder = Recorder(simulation, Path(folder))
        recorder.frame()
        recorder.background.wait()
        n_frames = max(1, round(scene.end_time / scene.output.interval))
        frames = [*(i * scene.output.interval for i in range(1, n_frames)), scene.end_time]
        samples, output, stepping, speeds, rest = [], 0.0, 0.0, [], StopAtRest(simulation)
        for next_frame in frames:
            while simulation.time < next_frame and stepping < most:
                began = time.process_time()
                simulation.step(until=next_frame)
                recorder.watch()
                if stages.count.get("steps"):
                    stepping += time.process_time() - began
                if stepping > EVERY * len(speeds):
                    speeds.append(speed_now())
            if simulation.time < next_frame:
                break
            began = time.process_time()
            recorder.frame()
            recorder.background.wait()
            output += time.process_time() - began
            grid = solver.grid if stages.on_grid else None
            samples.append((simulation.time, solver.steps, simulation.dt, simulation.dt_cause, simulation.max_speed,
                            solver.particles.count, solver.particles.n_blocks, grid.n_node_blocks if grid else 0,
                            grid.contact.n if grid else 0, stepping, output))
            rest.look()
            if rest.reached:
                break
        recorder.background.close()
    spent["grid"] = spent.get("grid", 0.0) - spent.get("contact", 0.0)
    row = {stage: spent.get(stage, 0.0) for stage in STAGES}
    row["rest"] = stepping - sum(row[stage] for stage in PARTS.values()) - row["contact"]
    total, steps = time.process_time() - start, stages.count.get("steps", 0)
    row.update(scene=name, settings=" ".join(settings), machine=device_name("cpu", 1), threads=1,
               precision=scene.solver.precision, part=simulation.time, end_time=scene.end_time,
               particles=len(simulation.model.population.volumes), settling_steps=stages.count.get("settling", 0),
               steps=steps, particle_steps=stages.particle_steps, frames=len(samples),
               blocks=stages.blocks / max(1, steps), contact_blocks=stages.contacts / max(1, steps), output=output,
               start=total - row["settling"] - stepping - output, total=total,
               vector=mean(one.vector for one in speeds),
               python=mean(one.python for one in speeds))
    return row, {"samples": samples[::max(1, len(samples) // SAMPLES)]}


def kept(path, names):
    """Rows of the table that is there, but for those measured anew."""
    if not path.exists():
        return []
    with open(path, newline="", encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if (row["scene"], row["settings"]) not in names]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*")
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    parser.add_argument("--most", type=float, default=20.0)
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--samples", type=Path)
    options = parser.parse_args()
    if options.one:
        print(json.dumps(measure(options.names[0], options.settings, options.most)))
        return
    if not options.names:
        from snowmpm.scenes.library import library
        options.names = sorted(library())
    for name in options.names:
        command = [sys.executable, __file__, "--one", name, "--most", str(options.most)]
        command += [part for setting in options.settings for part in ("--set", setting)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            print(name, done.stderr[-2000:], file=sys.stderr, flush=True)
            continue
        row, more = json.loads(done.stdout.splitlines()[-1])
        if options.samples:
            with open(options.samples, "a", encoding="utf-8") as file:
                file.write(json.dumps({"row": row, **more}) + "\n")
        row = {key: f"{value:.4g}" if isinstance(value, float) else value for key, value in row.items()}
        rows = [*kept(options.output, {(name, " ".join(options.settings))}), row]
        rows.sort(key=lambda row: (row["scene"], row["settings"]))
        with open(options.output, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, COLUMNS)
            writer.writeheader()
            writer.writerows(rows)
        print(name, row["part"], row["steps"], row["total"], flush=True)


if __name__ == "__main__":
    main()
