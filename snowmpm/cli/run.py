"""`snowmpm run`: a scene to its run file."""

import os
import shlex
import sys
import warnings
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli import choose, watch
from snowmpm.cli.errors import warn
from snowmpm.cli.live import Live, check_page, following
from snowmpm.cli.maps import maps as draw_maps
from snowmpm.cli.options import (
    Accurate,
    Backend,
    BackendOption,
    Fast,
    Json,
    PrecisionOption,
    Quiet,
    SceneName,
    Settings,
    Threads,
    scene_overrides,
)
from snowmpm.cli.render import draw
from snowmpm.cli.table import print_json
from snowmpm.cli.wording import count, duration
from snowmpm.errors import InputError, WriteError

GOES_ON = "--resume goes on from there"
"""End of messages about a run that can be continued."""


def run(
    scene: SceneName,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Output folder; runs/<scene name> by default.")
    ] = None,
    settings: Settings = None,
    backend: BackendOption = Backend.auto,
    precision: PrecisionOption = None,
    threads: Threads = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace a run that is already in DIR.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Continue from the last checkpoint in DIR, with the run's own settings.")
    ] = False,
    render: Annotated[bool, typer.Option("--render", help="Draw a film of the run to DIR/film.mp4.")] = False,
    maps: Annotated[
        bool, typer.Option("--maps", help="Draw the maps of the avalanche into DIR/maps, as the command maps does.")
    ] = False,
    live: Annotated[
        Path | None,
        typer.Option("--live", metavar="FILE", help="Keep an .html page with the newest picture as the run goes on."),
    ] = None,
    fast: Fast = False,
    accurate: Accurate = False,
    lines: Annotated[bool, typer.Option("--lines", hidden=True, help="As --progress lines.")] = False,
    accept_plugin: Annotated[
        bool, typer.Option("--accept-plugin", help="With --resume: go on with another version of a plugin.")
    ] = False,
    accept_cost: Annotated[
        bool, typer.Option("--accept-cost", help="Run even if it takes over a month or more than the free disk.")
    ] = False,
    question: choose.Question = None,
    within: choose.Within = None,
    budget: choose.BudgetOption = None,
    at: choose.At = None,
    obstacle: choose.ObstacleName = None,
    path: choose.PathOption = None,
    rung: choose.RungName = None,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """Run a scene to its run file.

    Writes DIR/run.vtkhdf (opens in ParaView, even during the run), DIR/scene.toml (the resolved scene),
    DIR/summary.json and DIR/checkpoint.npz, from which --resume continues after Ctrl-C or a crash. What --set, --fast
    and --precision changed when the run began need not be given again.

    On a terminal, a live display shows time, step and what limits it, speed, front, energies and the time left.
    Elsewhere, a line is printed to stderr every ten seconds; with --progress lines from the first step on. --live
    FILE.html keeps a page with the newest frame, its time and the time left; a browser that has it open shows each new
    picture by itself. Another process draws it, in 2 % of the time of one core.
    """
    if lines:
        print("warning: --lines is now --progress lines", file=sys.stderr)
        watch.ask_for(watch.Form.lines)
    if any(one is not None for one in (question, rung, within, budget)):
        others = {"--resume": resume, "--render": render, "--maps": maps, "--live": live, "--fast": fast,
                  "--accurate": accurate, "--precision": precision}
        _answer(scene, settings, output, {"--question": question, "--within": within, "--budget": budget, "--at": at,
                                          "--obstacle": obstacle, "--path": path, "--rung": rung},
                [name for name, given in others.items() if given],
                {"backend": backend, "threads": threads, "overwrite": overwrite, "accept_cost": accept_cost,
                 "quiet": quiet}, as_json)
        return
    if given_alone := [name for name, value in {"--at": at, "--obstacle": obstacle, "--path": path}.items()
                       if value is not None]:
        raise InputError(f"{given_alone[0]}: goes with --question NAME")
    import snowmpm.compiler  # noqa: F401 (before the laws are read, which then takes a third of a second less)
    from snowmpm.io.remarks import remarks
    from snowmpm.scenes import load_scene

    overrides = scene_overrides(settings, precision)
    if resume and output:
        _require_plugins(output, accept_plugin)
    loaded = given = load_scene(scene, overrides)
    folder = output or Path("runs") / loaded.name
    _check_folder(folder, overwrite, resume)
    overwriting.guard_in(folder, ["film.mp4"] if render else [])
    if maps:
        _check_maps(loaded)
    if live:
        check_page(live)
    if resume and (begun := _begun_with(folder, scene)):
        overrides = begun | overrides
        loaded = load_scene(scene, overrides)
    if overwrite:
        _tell_what_stays(folder, {"film.mp4": render, "maps": maps})
    start_taichi(backend, threads)
    if fast or accurate:
        loaded = load_scene(scene, overrides | along_the_front(given, fast, accurate, quiet))
    again = _command(scene, folder, backend, threads, {
        "--render": render, "--maps": maps, "--accept-cost": accept_cost}, live)
    before = _ends_of(folder) if resume else None
    result = simulate(loaded, folder, resume, quiet=quiet, overwrite=overwrite, accept_cost=accept_cost, again=again,
                      page=live, accept_plugin=accept_plugin)
    told = not quiet and not as_json
    if told:
        simulated = f"{count(len(result))} frames, {result.times[-1]:.3f} s simulated"
        if result.times[-1] == before:
            simulated = f"nothing left to do: {simulated}"
        print(f"{simulated}{_ended(result)}{_wall(result)}: {result.path}")
    if told and (chosen := result.summary.get("friction_class")):
        print(f"friction {chosen}, chosen by the volume of the release")
    if told and result.saw_test:
        _tell_saw_test(result)
    for remark in remarks(result):
        print(f"warning: {remark}", file=sys.stderr)
    film = draw(result, folder / "film.mp4", quiet=not told) if render else None
    if maps:
        draw_maps(folder, quiet=not told)
    if as_json:
        print_json({"run": str(result.path), **({"film": str(film)} if film else {}), **result.summary})


ANSWER = "answer.json"
"""Beside the runs that answer a question."""


def _answer(scene, settings, output, asked, others, how, as_json):
    """Answer a question about a scene by the cheapest model that will do. asked: options of the question by name;
    others: names of options that were given and do not go with it; how: of `simulate`, backend and threads."""
    if others:
        raise InputError(f"{others[0]}: does not go with --question: run the rung's own folder afterwards")
    if asked["--rung"] and (asked["--within"] or asked["--budget"]):
        raise InputError("--rung takes one rung as it is: --within and --budget do not go with it")
    within, budget = choose.asked_for(asked["--within"], asked["--budget"])
    start_taichi(how.pop("backend"), how.pop("threads"))
    loaded, ask, ladder = choose.opened(scene, settings, *(asked[name] for name in (
        "--question", "--at", "--obstacle", "--path", "--rung")), start=False)
    folder = output or Path("runs") / f"{loaded.name}_{ask.question.name}"
    if (folder / ANSWER).exists() and not how["overwrite"]:
        raise InputError(f"{folder} already holds an answer: --overwrite it, or choose another folder with -o")
    _check_folder(folder, True, False)
    overwriting.guard_in(folder, [ANSWER])

    def one(changed, where):
        _check_folder(where, how["overwrite"], False)
        return simulate(changed, where, False, **{**how, "quiet": how["quiet"] or as_json})

    choose.answer(loaded, ask, ladder, folder, one, within, budget, asked["--rung"], how["quiet"], as_json)


def _check_maps(scene):
    """Raise InputError where a scene has no maps, or what writes them is not installed: before the run."""
    if scene.dimension != 3:
        raise InputError("--maps: maps are made of runs in three dimensions, and this scene has two")
    from snowmpm import gis
    from snowmpm.io.geotiff import require_rasterio

    require_rasterio()
    gis.require_pyogrio()


def _require_plugins(folder, accept):
    """Raise InputError where the run in a folder began with plugins that are not loaded: without them its scene could
    not be read."""
    from snowmpm import plugins
    from snowmpm.io import Run

    try:
        made_with = Run(folder).provenance.get("plugins")
    except InputError:  # no run: what is wrong is said where the checkpoint is read
        return
    plugins.require(made_with, folder, accept)


def _tell_what_stays(folder, anew):
    """Warn of pictures and maps of the run that is replaced which a new run does not make. anew: those that it does."""
    made = ("film.mp4", "maps", "report.html", "report.pdf", "history.png", "saw_test.png", "stills.jpg", "export")
    there = [name for name in made if (folder / name).exists() and not anew.get(name)]
    if there:
        print(f"warning: {folder}: {', '.join(there)}: of the run that is replaced; make them anew", file=sys.stderr)


def _ends_of(folder):
    """Time at which the complete run in a folder ends [s], None without."""
    from snowmpm.io import Run

    try:
        run = Run(folder)
    except InputError:
        return None
    return run.times[-1] if run.complete else None


def _begun_with(folder, scene):
    """Settings with which the run in a folder began, {} where none are known or they are not of this scene."""
    from snowmpm.io import Run
    from snowmpm.scenes import load_scene

    try:
        settings = dict(Run(folder).provenance.get("settings") or {})
        load_scene(scene, settings)
    except InputError:  # no run, or of another scene: what is wrong is said where the checkpoint is read
        return {}
    return settings


def _command(scene, folder, backend, threads, flags, live):
    """The command that continues a run."""
    words = ["snowmpm", "run", scene, "-o", str(folder), "--resume"]
    words += [] if backend is Backend.auto else ["--backend", backend.value]
    words += [] if threads is None else ["--threads", str(threads)]
    words += [] if live is None else ["--live", str(live)]
    return shlex.join([*words, *(flag for flag, given in flags.items() if given)])


def along_the_front(scene, fast, accurate, quiet):
    """Print the changes of --fast or --accurate; -> them as overrides."""
    if fast and accurate:
        raise InputError("--fast and --accurate lead opposite ways: choose one")
    from snowmpm.advice.along_front import faster, more_accurate
    from snowmpm.methods import METHODS

    able = METHODS[scene.solver.method].capabilities.presets
    change = (faster(scene) if fast else more_accurate(scene)) if able or accurate else None
    overrides, lines = (change.overrides, change.lines) if change else ({}, ())
    if fast and not overrides and (model := _other_model(scene)):
        overrides, lines = model["changes"], (*model["lines"], *(() if model["changes"] else lines[1:]))
    elif not lines:
        lines = ["--fast: changes nothing: no faster model or grid was measured for such a scene"]
    for line in () if quiet else lines:
        print(line, file=sys.stderr)
    return overrides


def _other_model(scene):
    """What `choose.faster_model` says of a scene."""
    from snowmpm.advice.facts import SceneFacts
    from snowmpm.setup.build import build

    model = build(scene)
    facts = SceneFacts(scene, model, model.solver())
    return choose.faster_model(choose.usual_ladder(scene, facts), facts.budget.total)


def start_taichi(backend, threads):
    """Start the backend. Raises InputError where it cannot be had."""
    from snowmpm.compiler import runtime

    with warnings.catch_warnings():
        # Another backend is refused below; a Taichi that runs already keeps its number of threads
        warnings.filterwarnings("ignore", "Taichi runs already")
        try:
            running = runtime.start(backend.value, threads)
        except RuntimeError as error:
            raise InputError(f"--backend {backend.value}: cannot be started here ({error})") from None
    if backend.value not in ("auto", running):
        raise InputError(f"--backend {backend.value}: there is none here; auto takes {running}")


def _check_folder(folder, overwrite, resume):
    if resume and overwrite:
        raise InputError("--resume continues the run in DIR, --overwrite replaces it: choose one")
    there = next(parent for parent in (folder, *folder.resolve().parents) if parent.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        raise InputError(f"-o {folder}: {there} must be a folder that can be written to")
    if (folder / "run.vtkhdf").exists() and not overwrite and not resume:
        raise InputError(f"{folder} already holds a run: --resume or --overwrite it, or choose another folder with -o")


def simulate(scene, folder, resume, quiet=False, overwrite=True, accept_cost=False, again=None,
             page=None, accept_plugin=False):
    """Run a scene with its progress shown as `snowmpm.cli.progress.display` does; -> `snowmpm.io.Run`.

    again: the command that continues it; page: of a live picture (`snowmpm.render.live`).
    Raises InputError for a run of unaffordable cost (`snowmpm.advice.affordability`), unless accept_cost.
    """
    import snowmpm
    from snowmpm.advice.affordability import many_bodies, refuse_unaffordable
    from snowmpm.cli.progress import display
    from snowmpm.compiler import runtime

    if many := many_bodies(scene):
        print(f"warning: {many}", file=sys.stderr)

    follower = Live(page, folder, scene.name) if page else None

    def approve(simulation):
        if not resume:
            _warn_before(simulation)
        if not accept_cost:
            refuse_unaffordable(simulation, folder, runtime.threads())
        if follower:
            follower.begin()

    try:
        with display(scene.name, quiet) as show, following(follower, show) as progress, \
                warnings.catch_warnings():
            warnings.showwarning = warn
            return snowmpm.run(scene, folder, progress=progress, resume=resume, overwrite=overwrite, approve=approve,
                               accept_plugin=accept_plugin)
    except KeyboardInterrupt as interruption:
        if interruption.args:
            raise KeyboardInterrupt(_with_command(interruption, again, "\n")) from None
        written = (folder / "run.vtkhdf").exists()
        kept = f"; the frames written so far are in {folder}" if written else "; nothing was written"
        raise KeyboardInterrupt(f"interrupted{kept}") from None
    except WriteError as error:
        raise WriteError(_with_command(error, again)) from error


def _warn_before(simulation):
    """Print what `check` warns of."""
    from snowmpm.advice.cautions import cautions
    from snowmpm.advice.facts import SceneFacts

    for caution in cautions(SceneFacts(simulation.scene, simulation.model, simulation.solver)):
        print(f"warning: {caution}", file=sys.stderr)


def _with_command(error, again, gap=" "):
    """The message of an error, with the command that continues the run where it says that one can."""
    return f"{error}:{gap}{again}" if again and str(error).endswith(GOES_ON) else str(error)


def _tell_saw_test(result):
    """Print the outcome of a saw test, and how the saw cut."""
    from snowmpm.io.saw_words import outcome, set_up

    test = result.saw_test
    print(f"saw test: {outcome(result.summary.get('saw_test', {}), test)}")
    print(f"saw: {set_up(test.about)['saw']}")


def _ended(result):
    """The reason of the end, for runs that ended before their end_time."""
    from snowmpm.running.rest import rested

    return f", {result.summary['ended']}" if rested(result) else ""


def _wall(result):
    wall = result.summary.get("wall_time")
    return f" in {duration(wall)}" if wall else ""
