"""Element tests: the experiments of a soil and snow laboratory at a single material point.

The axis of the apparatus is z; shear is along x on planes normal to z. A test starts from an isotropic Cauchy pressure
(see `MixedControl.consolidated`), where its strains are zero. Driven strains are logarithmic; the amount of a
compression is positive, and a negative amount turns a test round (extension instead of compression).
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite

from .arrays import Precision
from .law import Law
from .loading_file import LoadingFile
from .loading_stage import LoadingError, LoadingStage
from .measurement import Driven, Measurement
from .mixed_control import MixedControl

AXES = ("xx", "yy", "zz")


@dataclass(frozen=True)
class Experiment:
    """A kind of test. stages(amount, pressure, steps, duration) -> its `LoadingStage`s; strain, steps: its defaults."""

    summary: str
    driven: Driven
    strain: float
    steps: int
    stages: Callable[[float, float, int, float], list[LoadingStage]]


def _isotropic(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    return [LoadingStage(dict.fromkeys(AXES, -amount / 3.0), {}, steps, duration)]


def _oedometer(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    return [LoadingStage({"zz": -amount}, {}, steps, duration)]


def _triaxial(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    return [LoadingStage({"zz": -amount}, {"xx": -pressure, "yy": -pressure}, steps, duration)]


def _triaxial_constant_volume(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    return [LoadingStage({"xx": 0.5 * amount, "yy": 0.5 * amount, "zz": -amount}, {}, steps, duration)]


def _simple_shear(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    return [LoadingStage({"xz": amount}, {"zz": -pressure}, steps, duration)]


def _accelerated_shear(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    # Equal times, in which the shear grows as their square: twice the time that the last rate alone would take
    return [
        LoadingStage({"xz": amount * (i / steps) ** 2}, {"zz": -pressure}, 1, 2.0 * duration / steps)
        for i in range(1, steps + 1)
    ]


def _simple_shear_constant_volume(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    return [LoadingStage({"xz": amount}, {}, steps, duration)]


def _tension(amount: float, pressure: float, steps: int, duration: float) -> list[LoadingStage]:
    # Back through the initial volume and as far into compression, so that a gap closes and carries again
    out = max(1, round(steps / 3))
    back = LoadingStage(dict.fromkeys(AXES, -amount / 3.0), {}, max(1, steps - out), 2.0 * duration)
    return [LoadingStage(dict.fromkeys(AXES, amount / 3.0), {}, out, duration), back]


COMPRESSION = Driven("volumetric_strain", -1.0, "volumetric compression [-]")
EXPANSION = Driven("volumetric_strain", 1.0, "volumetric expansion [-]")
SHORTENING = Driven("strain_zz", -1.0, "axial shortening [-]")
SHEAR = Driven("strain_xz", 1.0, "shear γ [-]")

EXPERIMENTS: dict[str, Experiment] = {
    "isotropic": Experiment("compression, equal in all directions", COMPRESSION, 0.1, 200, _isotropic),
    "oedometer": Experiment("axial compression, no lateral strain", SHORTENING, 0.1, 200, _oedometer),
    "triaxial": Experiment("drained: axial compression, lateral stress held", SHORTENING, 0.2, 200, _triaxial),
    "triaxial_constant_volume": Experiment(
        "undrained: axial compression at constant volume", SHORTENING, 0.2, 200, _triaxial_constant_volume
    ),
    "simple_shear": Experiment("shear, normal stress held", SHEAR, 10.0, 1000, _simple_shear),
    "simple_shear_constant_volume": Experiment(
        "shear at constant volume", SHEAR, 10.0, 1000, _simple_shear_constant_volume
    ),
    "accelerated_shear": Experiment(
        "shear from rest, its rate growing to the one given; normal stress held", SHEAR, 0.5, 500, _accelerated_shear
    ),
    "tension": Experiment("isotropic expansion, then back into compression (healing)", EXPANSION, 0.05, 300, _tension),
}


def measure(law: Law, name: str, *, strain: float | None = None, pressure: float = 0.0, steps: int | None = None,
            rate: float = 1.0, precision: Precision = "f64") -> Measurement:
    """Run the experiment `name` of EXPERIMENTS on a law -> `Measurement`.

    strain: amount of the driven strain [-]; pressure: isotropic Cauchy pressure at the start [Pa]; steps: of the test;
    rate: of the driven strain [1/s], read by rate-dependent laws only. Defaults: the experiment's own.
    Raises LoadingError for a wrong argument, and, naming the step, for a stress out of reach or where the law fails.
    """
    if name not in EXPERIMENTS:
        raise LoadingError(f"no test {name}: one of {', '.join(EXPERIMENTS)}")
    experiment = EXPERIMENTS[name]
    amount = experiment.strain if strain is None else strain
    steps = experiment.steps if steps is None else steps
    if amount == 0.0 or not isfinite(amount):
        raise LoadingError(f"strain = {amount}: must be finite and not zero")
    if not rate > 0.0 or not isfinite(rate):
        raise LoadingError(f"rate = {rate}: must be > 0")
    stages = experiment.stages(amount, _checked(pressure), steps, abs(amount) / rate)
    control = MixedControl(law, precision)
    start = control.consolidated(pressure)
    return Measurement(name, law, experiment.driven, [start, *control.follow_stages(stages, start)])


def measure_path(law: Law, loading: LoadingFile, *, pressure: float = 0.0, steps: int = 1,
                 precision: Precision = "f64") -> Measurement:
    """Follow a `LoadingFile`, with `steps` equal steps from each of its rows to the next -> `Measurement`.

    Strains, stresses and F change linearly between rows. Raises as `measure` does.
    """
    control = MixedControl(law, precision)
    start = control.consolidated(_checked(pressure))
    if loading.deformation is None:
        rows = control.follow_stages(loading.stages(steps), start)
    else:
        rows = control.follow_deformation(*loading.subdivided(steps), start)
    return Measurement(loading.name, law, Driven("step", 1.0, "step"), [start, *rows])


def _checked(pressure: float) -> float:
    if not pressure >= 0.0 or not isfinite(pressure):
        raise LoadingError(f"pressure = {pressure}: must be >= 0")
    return float(pressure)
