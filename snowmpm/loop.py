"""The run loop: steps, frames, progress."""

import time as clock
from dataclasses import dataclass, field
from pathlib import Path

from snowmpm.io import Run
from snowmpm.recorder import Recorder
from snowmpm.simulation import Simulation

PROGRESS_INTERVAL = 0.2
"""Seconds of wall time between progress reports."""


@dataclass
class Progress:
    """What a run tells while it goes on: simulated time and end [s], step, size, speed [m/s], front [m], wall time [s]."""

    time: float = 0.0
    end_time: float = 0.0
    dt: float = 0.0
    dt_cause: str = ""
    n_particles: int = 0
    max_speed: float = 0.0
    front: float = 0.0
    steps: int = 0
    frames: int = 0
    wall: float = 0.0
    particle_steps: int = 0


@dataclass
class Phases:
    """Wall time [s] of each part of a run."""

    setup: float = 0.0
    steps: float = 0.0
    output: float = 0.0
    started: float = field(default_factory=clock.perf_counter, repr=False)

    def lap(self, name):
        """Book the time since the last lap."""
        now = clock.perf_counter()
        setattr(self, name, getattr(self, name) + now - self.started)
        self.started = now


def run(scene, out_dir, progress=None):
    """Simulate a scene and write its run folder; -> `snowmpm.io.Run`.

    out_dir gets run.vtkhdf, scene.toml (resolved) and summary.json. progress: called with a `Progress` now and then.
    Raises InputError before anything is written, SimulationError when a step fails (frames so far stay readable).
    """
    phases = Phases()
    simulation = Simulation(scene)
    folder = Path(out_dir)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    recorder = Recorder(simulation, folder)
    phases.lap("setup")
    try:
        recorder.frame()
        phases.lap("output")
        _loop(simulation, recorder, phases, progress)
    except BaseException:
        recorder.close(phases, complete=False)
        raise
    recorder.close(phases, complete=True)
    return Run(folder)


def _loop(simulation, recorder, phases, progress):
    scene, report = simulation.scene, Progress(end_time=simulation.scene.end_time)
    n_frames = max(1, round(scene.end_time / scene.output.interval))
    frame_times = [*(i * scene.output.interval for i in range(1, n_frames)), scene.end_time]
    start = said = clock.perf_counter()
    for next_frame in frame_times:
        while simulation.time < next_frame:
            simulation.step(until=next_frame)
            recorder.watch()
            report.particle_steps += simulation.n_particles
            now = clock.perf_counter()
            if progress and now - said > PROGRESS_INTERVAL:
                said = now
                _tell(progress, report, simulation, recorder, now - start)
        phases.lap("steps")
        recorder.frame()
        phases.lap("output")
    recorder.particle_steps = report.particle_steps
    if progress:
        _tell(progress, report, simulation, recorder, clock.perf_counter() - start)


def _tell(progress, report, simulation, recorder, wall):
    report.time, report.dt, report.dt_cause = simulation.time, simulation.dt, simulation.dt_cause
    report.n_particles, report.max_speed = simulation.n_particles, simulation.max_speed
    report.steps, report.frames, report.wall = simulation.solver.steps, recorder.frames, wall
    report.front = recorder.last.get("front", 0.0)
    progress(report)
