"""The run loop: steps, frames, checkpoints, progress."""

import time as clock
from dataclasses import asdict, dataclass, field
from pathlib import Path

from snowmpm import checkpoint
from snowmpm.checkpoint import Checkpoints
from snowmpm.errors import SimulationError
from snowmpm.interruption import Interruption
from snowmpm.io import Run
from snowmpm.recorder import Recorder
from snowmpm.simulation import Simulation

PROGRESS_INTERVAL = 0.2
"""Seconds of wall time between progress reports."""


@dataclass
class Progress:
    """What a run tells while it goes on: simulated time, its end and the step [s], speed [m/s], front [m], wall [s]."""

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
    audit: dict = field(default_factory=dict)
    """the last row of the history (`snowmpm.diagnostics`)"""


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

    def state(self):
        """Wall times so far, by name."""
        return {name: value for name, value in asdict(self).items() if name != "started"}

    def add(self, state):
        """Count the wall times of the part of the run before a checkpoint, too."""
        for name, value in state.items():
            setattr(self, name, getattr(self, name) + value)


def run(scene, out_dir, progress=None, resume=False):
    """Simulate a scene and write its run folder; -> `snowmpm.io.Run`.

    out_dir gets run.vtkhdf, scene.toml (resolved), summary.json and checkpoints. progress: called with a `Progress` now
    and then. resume: go on from the last checkpoint in out_dir as if the run had never stopped; frames written after it
    are written again. The scene must be the same, but may end later.
    Raises InputError before anything is written, SimulationError when a step fails (frames so far stay readable), and
    KeyboardInterrupt at Ctrl-C or SIGTERM, a checkpoint written.
    """
    phases, folder = Phases(), Path(out_dir)
    saved = _saved(folder, scene) if resume else None
    simulation = Simulation(scene, settled=resume)
    if resume:
        checkpoint.take_over(simulation, saved)
        phases.add(saved["phases"])
    folder.mkdir(parents=True, exist_ok=True)
    recorder = Recorder(simulation, folder, saved["recorder"] if resume else None)
    (folder / "scene.toml").write_text(scene.to_toml(), encoding="utf-8")
    checkpoints = Checkpoints(folder, scene.output.checkpoint_interval)
    phases.lap("setup")
    try:
        with Interruption() as interruption:
            if resume:
                checkpoints.took_up(saved)
            else:
                checkpoints.clear()
                recorder.frame()
                _save(simulation, recorder, checkpoints, phases)
            _loop(simulation, recorder, checkpoints, phases, progress, interruption)
    except SimulationError as error:
        recorder.close(phases, complete=False)
        raise SimulationError(f"{error}; {checkpoints}") from error
    except BaseException:
        recorder.close(phases, complete=False)
        raise
    recorder.close(phases, complete=True)
    checkpoints.finish()
    return Run(folder)


def _saved(folder, scene):
    saved = checkpoint.read(folder / checkpoint.FILE)
    checkpoint.check(saved, scene)
    return saved


def _save(simulation, recorder, checkpoints, phases):
    phases.lap("output")
    checkpoints.save(simulation, recorder=recorder.state(), phases=phases.state())
    phases.lap("output")


def _loop(simulation, recorder, checkpoints, phases, progress, interruption):
    scene, report = simulation.scene, Progress(end_time=simulation.scene.end_time)
    n_frames = max(1, round(scene.end_time / scene.output.interval))
    times = [*(i * scene.output.interval for i in range(1, n_frames)), scene.end_time]
    # With slack: the end that a finished run had, 0.3, is not before 12 intervals of 0.025.
    frame_times = [time for time in times if time > simulation.time + 1e-9 * max(1.0, time)]
    start = said = clock.perf_counter()
    for next_frame in frame_times:
        # A checkpoint is a state between steps whose frame, if it has one, is written.
        while simulation.time < next_frame:
            simulation.step(until=next_frame)
            recorder.watch()
            now = clock.perf_counter()
            if progress and now - said > PROGRESS_INTERVAL:
                said = now
                _tell(progress, report, simulation, recorder, now - start)
            if simulation.time >= next_frame:
                phases.lap("steps")
                recorder.frame()
                phases.lap("output")
            if interruption.asked or checkpoints.due(simulation.time):
                phases.lap("steps")
                _save(simulation, recorder, checkpoints, phases)
                if interruption.asked:
                    raise KeyboardInterrupt(f"interrupted at t = {simulation.time:.6g} s; {checkpoints}; --resume goes"
                                            " on from there")
    _save(simulation, recorder, checkpoints, phases)
    if progress:
        _tell(progress, report, simulation, recorder, clock.perf_counter() - start)


def _tell(progress, report, simulation, recorder, wall):
    report.time, report.dt, report.dt_cause = simulation.time, simulation.dt, simulation.dt_cause
    report.n_particles, report.max_speed = simulation.n_particles, simulation.max_speed
    report.steps, report.frames, report.wall = simulation.solver.steps, recorder.frames, wall
    report.front, report.particle_steps = recorder.last.get("front", 0.0), recorder.particle_steps
    report.audit = recorder.last
    progress(report)
