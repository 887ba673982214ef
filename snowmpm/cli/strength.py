"""`snowmpm strength`: the factor of safety of a slope by reduction of its strength."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import (
    Backend,
    BackendOption,
    Json,
    PrecisionOption,
    Quiet,
    SceneName,
    Settings,
    Threads,
    scene_overrides,
)
from snowmpm.cli.table import print_facts, print_json
from snowmpm.errors import InputError


class Divided(str, Enum):
    """What of friction is divided."""

    tangent = "tangent"
    angle = "angle"


def strength(
    scene: SceneName,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; runs/strength_SCENE by default.")
    ] = None,
    settings: Settings = None,
    material: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="Weaken this material only; repeatable. All by default.")
    ] = None,
    divide: Annotated[
        Divided, typer.Option(help="Divide the tangent of the friction angle, or the angle; cohesion in both.")
    ] = Divided.tangent,
    step: Annotated[float, typer.Option(metavar="X", help="Resolution of the factor.")] = 0.05,
    lowest: Annotated[float, typer.Option("--from", metavar="F", help="Smallest factor to be tried.")] = 0.2,
    highest: Annotated[float, typer.Option("--to", metavar="F", help="Largest factor to be tried.")] = 5.0,
    duration: Annotated[
        float | None, typer.Option(metavar="S", help="Time of each trial, in s; 2 sqrt(H/g) by default.")
    ] = None,
    backend: BackendOption = Backend.auto,
    precision: PrecisionOption = None,
    threads: Threads = None,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """Factor of safety of a slope by reduction of its strength.

    Lets the scene come to rest under its own weight (damped), then runs it from there with its strength divided by one
    factor after the other, until the smallest is known with which it slides. Events of the scene are left out.

    Writes DIR/strength.json (the answer), DIR/search.csv (every trial), DIR/slip_surface.csv, DIR/strength.png and, of
    each trial, a run that the other commands read (DIR/factor_*).
    """
    from snowmpm.cli.run import start_taichi
    from snowmpm.scenes import load_scene
    from snowmpm.strength.displacement import ways_of
    from snowmpm.strength.record import answer, write
    from snowmpm.strength.reduction import reduce_strength

    if not 0.0 < step <= 0.5:
        raise InputError.at("--step", step, "must be above 0 and at most 0.5")
    if not 0.0 < lowest < highest:
        raise InputError.at("--from, --to", f"{lowest:g}, {highest:g}", "must be above 0, the first below the second")
    if duration is not None and not 0.0 < duration < float("inf"):
        raise InputError.at("--duration", duration, "must be above 0")
    loaded = load_scene(scene, scene_overrides(settings, precision))
    folder = output or Path("runs") / f"strength_{loaded.name}"
    overwriting.guard_in(folder, ("strength.json", "search.csv", "slip_surface.csv", "strength.png"))
    start_taichi(backend, threads)
    told = not quiet and not as_json
    reduction = reduce_strength(loaded, folder, material, divide.value, step, (lowest, highest), duration,
                                _tell if told else lambda trial: None)
    ways = ways_of(reduction.run_of(reduction.found.trial))
    paths = write(reduction, ways)
    paths["picture"] = _draw(reduction, ways, folder / "strength.png")
    numbers = answer(reduction, ways)
    if as_json:
        print_json(numbers)
    elif told:
        print_facts(f"strength of {loaded.name}", _facts(numbers))
        print_facts("written", {name: str(path) for name, path in paths.items()})


def _tell(trial):
    print(f"factor {trial.factor:g}: {'slides' if trial.slides else 'stands'}"
          f" ({trial.speed:.2g} m/s in the end, way {trial.way:.2g} m)")


def _facts(numbers):
    known = numbers.get("bishop")
    return {
        "factor of safety": f"{numbers['factor_of_safety']:g} (slides; stands at {numbers['stands_at']:g})",
        "divided": f"{'tan phi' if numbers['divided'] == 'tangent' else 'phi'} and cohesion of"
                   f" {', '.join(numbers['materials'])}",
        "slides": f"{100.0 * numbers['share_that_slides']:.0f} % of the material",
        **({} if known is None else {"slices on circles": f"{known:.2f} (Bishop)"}),
        **({} if numbers["rest_factor"] == 1.0 else
           {"rest": f"with {1.0 / numbers['rest_factor']:g} times its strength: it does not stand by itself"}),
    }


def _draw(reduction, ways, path):
    import numpy as np

    from snowmpm.render import SlipPicture, StrengthCurve, render_strength
    from snowmpm.strength.displacement import slip_surface, ways_of
    from snowmpm.strength.record import CELLS, slices

    curves = []
    for trial in reduction.found.trials:
        moved = ways_of(reduction.run_of(trial))
        curves.append(StrengthCurve(trial.factor, trial.slides, moved.times, moved.largest))
    cell = CELLS * reduction.scene.solver.dx
    start, surface, line, factor = ways.start, slip_surface(ways, cell), None, float("nan")
    if reduction.scene.dimension == 3:  # the section through what moved most
        middle = float(np.median(start[ways.slid, 1]))
        near = np.abs(start[:, 1] - middle) < cell
        inside = np.abs(surface[:, 1] - middle) < cell
        picture = SlipPicture(start[near][:, [0, 2]], ways.ways[-1, near], surface[inside][:, [0, 2]])
    else:
        known = slices(reduction)
        if known is not None:
            circle, slope = known
            x = np.linspace(max(circle.x - circle.radius, slope.x[0]), min(circle.x + circle.radius, slope.x[-1]), 400)
            z = circle.z - np.sqrt(np.clip(circle.radius**2 - (x - circle.x) ** 2, 0.0, None))
            below = z < np.interp(x, slope.x, slope.z)
            line, factor = np.column_stack([x, z])[below], circle.factor
        picture = SlipPicture(start, ways.ways[-1], surface, line, factor)
    return render_strength(reduction.scene.name, curves, picture, path)
