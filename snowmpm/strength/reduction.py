"""Strength reduction of a scene: rest under its own weight, then the same rest with less and less strength.

    rest      damped steps under gravity with the full strength (`initial.stress = "settle"`)
    trial     the same particles and stresses, strengths divided by a factor, for a time of `PERIODS` sqrt(H / g)
    verdict   slides, if 1 % of the material is still faster than `SLIDES` sqrt(g H) over the last tenth of that time

H is the height of the material. A slope with 2 % too little strength gains more than that. One that stands swings to
rest before, by an elastic law; a hypoplastic one has no elastic range, and creeps on at up to 0.012 sqrt(g H).
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError, SimulationError
from snowmpm.io import Run
from snowmpm.materials import Law
from snowmpm.running.loop import run
from snowmpm.scenes.loader import with_overrides
from snowmpm.scenes.schema import Scene
from snowmpm.strength.displacement import ways_of
from snowmpm.strength.search import Found, Trial, search
from snowmpm.strength.weakening import strengths, weakened

PERIODS = 2.0
SLIDES = 0.02
FRAMES = 20
"""Frames of a trial."""
REST_FACTORS = (1.0, 0.5, 0.25)
"""What the strength is divided by for the rest: a slope that slides by itself has one with more strength only."""
REST = "rest"
"""Folder of the run at rest."""


@dataclass(frozen=True)
class Reduction:
    """What was looked for, and found. folder: of the runs; gravity [m/s2]; height H [m]; duration of a trial [s]; limit
    of the speed [m/s]; way: "tangent" or "angle"; materials: names of those that were weakened; rest_factor: what their
    strength was divided by for the rest, 1 where that was one."""

    scene: Scene
    folder: Path
    gravity: float
    height: float
    duration: float
    limit: float
    way: str
    step: float
    materials: tuple[str, ...]
    rest_factor: float
    found: Found

    def run_of(self, trial: Trial) -> Run:
        """The run of a trial."""
        return Run(self.folder / trial.folder)


def reduce_strength(scene: Scene, folder: Path, materials: Iterable[str] | None = None, way: str = "tangent",
                    step: float = 0.05, limits: tuple[float, float] = (0.2, 5.0), duration: float | None = None,
                    told: Callable[[Trial], object] = lambda trial: None) -> Reduction:
    """`Reduction` of a scene, its runs in `folder`. materials: names, all that have strength by default; told: called
    with each trial. Raises InputError where nothing has strength, or the factor is beyond the limits."""
    names = _chosen(scene, materials)
    height, gravity = size_of(scene)
    period = math.sqrt(height / gravity)
    duration = PERIODS * period if duration is None else duration
    limit = SLIDES * math.sqrt(gravity * height)

    def reduced(factor: float) -> dict[str, Law]:
        return {name: weakened(scene.materials[name], factor, way) for name in names}

    def changed(factor: float, changes: dict[str, object]) -> Scene:
        laws = {f"materials.{name}": law.model_dump(exclude_none=True) for name, law in reduced(factor).items()}
        return with_overrides(scene, {"events": [], "output.fields": ["id", "velocity"], **laws, **changes})

    resting = {"initial.stress": "settle", "end_time": 1e-3 * period, "output.interval": period}
    rest_factor = _rest(scene, lambda factor: changed(factor, resting), folder / REST)

    def attempt(factor: float) -> Trial:
        where = f"factor_{factor:.4g}"
        ways = ways_of(run(changed(factor, {
            "end_time": duration, "output.interval": duration / FRAMES,
            "initial": {"from": str((folder / REST).resolve())}}), folder / where))
        trial = Trial(factor, ways.speed, float(ways.largest[-1]), ways.speed > limit, where,
                      {f"{name}.{key}": value for name, law in reduced(factor).items()
                       for key, value in strengths(law).items()})
        told(trial)
        return trial

    return Reduction(scene, folder, gravity, height, duration, limit, way, step, names, rest_factor,
                     search(attempt, step, *limits))


def _chosen(scene, materials):
    """Names of the materials to be weakened."""
    able = [name for name, law in scene.materials.items() if any(strengths(law).values())]
    for name in materials or ():
        if name not in able:
            raise InputError.at("--material", name, f"must be a material of {scene.source} that has strength:"
                                                    f" {', '.join(able) or 'there is none'}")
    if not able:
        raise InputError(f"{scene.source}: materials: none has a strength that could be reduced")
    return tuple(materials or able)


def size_of(scene: Scene) -> tuple[float, float]:
    """Height of the material [m] and size of gravity [m/s2], from the particles of the scene at its start."""
    from snowmpm.setup.build import build

    model = build(scene)
    gravity = float(np.linalg.norm(model.first_gravity))
    if not gravity > 0.0:
        raise InputError.at("gravity", scene.gravity, "must not be 0 for a slope to slide", scene.source)
    return float(np.ptp(model.population.positions[:, -1])) + scene.solver.dx, gravity


def _rest(scene, resting, folder):
    """Make the run that ends at rest; -> what the strength was divided by: 1, or less for what slides with its own.
    Raises InputError for a scene that does not come to rest with four times its strength."""
    reason = ""
    for factor in REST_FACTORS:
        try:
            run(resting(factor), folder)
            return factor
        except SimulationError as error:
            reason = reason or str(error).splitlines()[0]
    most = 1.0 / REST_FACTORS[-1]
    raise InputError(f"{scene.source}: does not come to rest, even with {most:g} times its strength:\n{reason}")
