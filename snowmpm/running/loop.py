"""The run loop: steps, frames, checkpoints, progress."""

import contextlib
import itertools
import time as clock
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from snowmpm import components, overwriting
from snowmpm.annotations import PathLike
from snowmpm.errors import InputError, SimulationError, WriteError
from snowmpm.io import FolderLock, Run, checkpoint, layout
from snowmpm.io.archive import part_of, write_text
from snowmpm.io.checkpoint import Checkpoints
from snowmpm.io.journal import journal_path
from snowmpm.io.writer import run_file
from snowmpm.running.interruption import Interruption
from snowmpm.running.recorder import Recorder
from snowmpm.running.rest import StopAtRest
from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene
from snowmpm.setup.taken_state import KEPT
from snowmpm.stages import stage

SCENE = "scene.toml"
"""Resolved scene in a run folder."""

CHECKPOINTS = (checkpoint.FILE, checkpoint.previous(checkpoint.FILE).name)
FILES = (layout.RUN_FILE, layout.COMPANION_FILE, layout.SUMMARY_FILE, SCENE, KEPT, *CHECKPOINTS)
"""Files of a run folder."""
PASSING = (journal_path(layout.RUN_FILE).name, *(part_of(name).name for name in FILES))
"""Files that are there while others are written, and after a kill."""

PROGRESS_INTERVAL = 0.2
"""Seconds of wall time between progress reports."""


@dataclass
class Progress:
    """Progress of a run: simulated time, its end and the step [s], speed [m/s], front [m], wall [s]."""

    time: float = 0.0
    end_time: float = 0.0
    dt: float = 0.0
    dt_cause: str = ""
    n_particles: int = 0
    max_speed: float = 0.0
    front: float | None = None
    steps: int = 0
    frames: int = 0
    wall: float = 0.0
    particle_steps: int = 0
    audit: dict[str, float] = field(default_factory=dict)
    """the last row of the history (`snowmpm.running.audit`)"""


@dataclass
class Phases:
    """Wall time [s] of each part of a run, and processor time [s], which other programs affect less."""

    setup: float = 0.0
    steps: float = 0.0
    output: float = 0.0
    processor: float = 0.0
    started: tuple[float, float] = field(
        default_factory=lambda: (clock.perf_counter(), clock.process_time()), repr=False)

    def lap(self, name):
        """Add the time since the last lap to a part."""
        now = clock.perf_counter(), clock.process_time()
        wall, processor = (after - before for after, before in zip(now, self.started, strict=True))
        self.add({name: wall, "processor": processor})
        self.started = now

    @property
    def walls(self):
        """Wall times so far, by name."""
        return {"setup": self.setup, "steps": self.steps, "output": self.output}

    def state(self):
        """Times so far, by name."""
        return {**self.walls, "processor": self.processor}

    def add(self, state):
        """Add earlier times, such as those of the run before a checkpoint."""
        for name, value in state.items():
            setattr(self, name, vars(self)[name] + value)


def run(scene: Scene, out_dir: PathLike, progress: Callable[[Progress], object] | None = None, resume: bool = False,
        overwrite: bool | None = None, approve: Callable[[Simulation], object] | None = None,
        accept_plugin: bool = False) -> Run:
    """Simulate a scene and write its run folder; -> `snowmpm.io.Run`.

    out_dir gets run.vtkhdf, scene.toml (resolved), summary.json and checkpoints. progress: called with a `Progress`
    regularly. resume: continue from the last checkpoint in out_dir as if the run had never stopped; frames written
    after it are written again; where there is no run, or one that was killed before its first checkpoint, the run
    starts, with a warning. The scene and the files that it names must be the same, but it may end later. overwrite:
    None replaces an earlier run, but no file that came from elsewhere or was changed since; True replaces both, False
    neither. approve: called with the `Simulation` before it settles or continues; may raise InputError, and then
    nothing is written. accept_plugin: resume with another version of a plugin (`snowmpm.plugins`) than it began with.
    Raises InputError before anything is written, SimulationError when a step fails (frames so far stay readable),
    WriteError when the disk is full, and KeyboardInterrupt at Ctrl-C or SIGTERM, a checkpoint written.
    """
    folder = Path(out_dir)
    with FolderLock(folder) as lock, overwriting.keeping(overwrite or None):
        if resume and _hardly_begun(folder):
            warnings.warn(f"{folder}: nothing to resume there yet: the run starts from its beginning", stacklevel=2)
            resume, overwrite = False, True
        return _run(scene, folder, lock, progress, resume, overwrite is not False, approve, accept_plugin)


def _run(scene, folder, lock, progress, resume, overwrite, approve, accept_plugin):
    phases = Phases()
    saved = _saved(folder, scene, accept_plugin) if resume else None
    if saved is None:
        overwriting.guard_in(folder, (*FILES, *PASSING))
    else:
        overwriting.adopt(folder, (layout.COMPANION_FILE, layout.SUMMARY_FILE, *PASSING))
    simulation = Simulation(scene, resumed=folder if resume else None, approve=None if resume else approve)
    if saved is not None:
        checkpoint.take_over(simulation, saved)
        if approve:
            approve(simulation)
        with checkpoint.state_of(saved):
            phases.add(saved["phases"])
    lock.make()
    if not resume and not overwrite and run_file(folder).exists():
        raise InputError(f"{folder} already holds a run: --resume or --overwrite it, or choose another folder")
    checkpoints = Checkpoints(folder, scene.output.checkpoint_interval)
    try:
        _record(simulation, folder, checkpoints, saved, phases, progress)
    except OSError as error:
        raise _not_written(error, folder, checkpoints) from error
    checkpoints.finish()
    return Run(folder)


def _hardly_begun(folder):
    """Whether there is no run, or one that was killed before its first checkpoint, with at most one frame: nothing is
    lost."""
    path = run_file(folder)
    if any(file.exists() for file in (checkpoint.previous(folder / checkpoint.FILE), folder / checkpoint.FILE)):
        return False
    if path.exists():
        run = Run(folder)
        return len(run) <= 1 and not run.complete
    return True


def _saved(folder, scene, accept_plugin):
    components.refuse_resume(scene)
    saved = checkpoint.read(folder / checkpoint.FILE)
    checkpoint.check(saved, scene, accept_plugin)
    _require_own_scene(folder / SCENE, saved["scene"])
    return saved


def _require_own_scene(path, text):
    """Raise InputError where the resolved scene in a run folder was edited: a resumed run writes it anew."""
    if path.is_file() and path.read_bytes() != text.encode() and not overwriting.is_own(path):
        raise InputError(f"{path}: was changed since the run began, and a resumed run would write it anew;\ngive"
                         " changes with --set, and move the file elsewhere")


def _not_written(error, folder, checkpoints):
    """Message for a failed write: where, why, what is safe, what to do."""
    try:
        times = Run(folder).times
        kept = f"frames up to t = {times[-1]:.6g} s are safe" if len(times) else "no frame was written"
    except InputError:
        kept = "no frame was written"
    file = error.filename or run_file(folder)
    message = f"{file}: cannot be written ({error.strerror or error});\n{kept}; {checkpoints}"
    return WriteError(message if checkpoints.time is None else f"{message}; make room, and --resume goes on from there")


def _record(simulation, folder, checkpoints, saved, phases, progress):
    """Run a simulation from its start, or from the state `saved`, and write its results."""
    if saved is None:
        # First, since an old checkpoint would not belong to the new run file
        checkpoints.clear()
    overwriting.note_changing(*(folder / name for name in (layout.RUN_FILE, *CHECKPOINTS, *PASSING)))
    if saved is None:
        (folder / KEPT).unlink(missing_ok=True)
        if simulation.model.taken:
            simulation.model.taken.write(folder)
    with checkpoint.state_of(saved) if saved else contextlib.nullcontext():
        recorder = Recorder(simulation, folder, saved["recorder"] if saved else None)
        rest = StopAtRest(simulation)
        if saved is not None and "rest" in saved:  # checkpoints of older versions have none
            rest.restore(saved["rest"])
    try:
        _write_scene(folder / SCENE, simulation.scene.to_toml(), resumed=saved is not None)
        phases.lap("setup")
        with Interruption() as interruption:
            if saved is not None:
                checkpoints.took_up(saved)
            else:
                recorder.frame()
                _save(simulation, recorder, rest, checkpoints, phases)
            _loop(simulation, recorder, rest, checkpoints, phases, progress, interruption)
    except BaseException as error:
        recorder.close(phases, complete=False)
        if isinstance(error, SimulationError):
            raise SimulationError(f"{error}; {checkpoints}") from error
        raise
    with stage("writing the end of the run"):
        recorder.close(phases, complete=True, ended=rest.reason)


def _write_scene(path, text, resumed):
    """Write the resolved scene, unless it is there."""
    if not path.is_file() or path.read_bytes() != text.encode():
        with overwriting.keeping(resumed or None):  # `_require_own_scene`
            write_text(path, text)


def _save(simulation, recorder, rest, checkpoints, phases):
    phases.lap("output")
    checkpoints.save(simulation, recorder.background, recorder=recorder.state(), rest=rest.state(),
                     phases=phases.state())
    phases.lap("output")


def _loop(simulation, recorder, rest, checkpoints, phases, progress, interruption):
    scene, report = simulation.scene, Progress(end_time=simulation.scene.end_time)
    n_frames = max(1, round(scene.end_time / scene.output.interval))
    times = itertools.chain((i * scene.output.interval for i in range(1, n_frames)), [scene.end_time])
    # With a tolerance: 12 intervals of 0.025 are not exactly 0.3 in floating point.
    begun = simulation.time
    frame_times = (time for time in times if time > begun + 1e-9 * max(1.0, time))
    start = said = clock.perf_counter()
    unconverged, taken = simulation.solver.unconverged, False
    for next_frame in frame_times:
        if rest.reached:
            break
        # A checkpoint is a state between steps whose frame, if it has one, is written.
        while simulation.time < next_frame:
            with stage("the first step (compiles its kernels)") if not taken else contextlib.nullcontext():
                simulation.step(until=next_frame)
            taken = True
            recorder.watch()
            if simulation.solver.unconverged > unconverged == 0:
                unconverged = simulation.solver.unconverged
                warnings.warn(f"a return map did not converge at t = {simulation.time:.6g} s: its stress is the best"
                              " that was found, or where its strain cannot be represented the step was left out"
                              f";\nthe history counts them (unconverged); {checkpoints}", stacklevel=3)
            now = clock.perf_counter()
            if progress is not None and now - said > PROGRESS_INTERVAL:
                said = now
                _tell(progress, report, simulation, recorder, now - start)
            if simulation.time >= next_frame:
                phases.lap("steps")
                recorder.frame()
                rest.look()
                phases.lap("output")
            if interruption.asked or checkpoints.due(simulation.time):
                phases.lap("steps")
                _save(simulation, recorder, rest, checkpoints, phases)
                if interruption.asked:
                    recorder.background.wait()
                    raise KeyboardInterrupt(f"interrupted at t = {simulation.time:.6g} s; {checkpoints}; --resume goes"
                                            " on from there")
    _save(simulation, recorder, rest, checkpoints, phases)
    recorder.background.wait()
    phases.lap("output")
    if progress is not None:
        _tell(progress, report, simulation, recorder, clock.perf_counter() - start)


def _tell(progress, report, simulation, recorder, wall):
    report.time, report.dt, report.dt_cause = simulation.time, simulation.dt, simulation.dt_cause
    report.n_particles, report.max_speed = simulation.n_particles, simulation.max_speed
    report.steps, report.frames, report.wall = simulation.solver.steps, recorder.frames, wall
    report.front, report.particle_steps = recorder.last.get("front"), recorder.particle_steps
    report.audit = recorder.last
    with contextlib.suppress(OSError):  # a closed terminal or pipe must not stop the run
        progress(report)
