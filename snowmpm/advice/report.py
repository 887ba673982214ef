"""The complete report of `snowmpm check` on a scene."""

from dataclasses import asdict, dataclass

from snowmpm.advice.affordability import unaffordable
from snowmpm.advice.along_front import faster, more_accurate
from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.advice.savings import savings
from snowmpm.methods import METHODS
from snowmpm.running.description import describe
from snowmpm.setup.build import build
from snowmpm.stages import stage
from snowmpm.stepping.step_check import check_step


@dataclass(frozen=True)
class Alternative:
    """option: of `snowmpm run`; seconds: of the run with it; lines: its changes and their effect."""

    option: str
    seconds: float
    lines: tuple


def alternatives(scene, budget):
    """`Alternative`s of a scene; none for a method for which they were not measured."""
    if not METHODS[scene.solver.method].capabilities.presets:
        return []
    changes = {"--fast": faster(scene, budget), "--accurate": more_accurate(scene, budget)}
    moving = budget.total - budget.start
    return [Alternative(option, budget.start + change.ratio * moving, change.lines)
            for option, change in changes.items()]


@dataclass(frozen=True)
class Advice:
    """facts: of `description.describe`, and the run time [s]; lists of `Payment`, `Caution` and `Saving`."""

    facts: dict
    payments: list
    cautions: list
    savings: list
    along: list
    """`Alternative`s: what --fast and --accurate would change, and how long the run would then take"""
    unaffordable: str | None = None
    """why `snowmpm run` would refuse it (`affordability`), else None"""

    def record(self):
        """The advice as values that JSON can hold."""
        return {**self.facts, "unaffordable": self.unaffordable, **{name: [asdict(item) for item in getattr(self, name)]
                                        for name in ("payments", "cautions", "savings", "along")}}


def advise(scene):
    """`Advice` on a scene. Raises InputError as `build` does."""
    model = build(scene)
    solver = model.solver()
    check_step(scene, solver)
    facts = SceneFacts(scene, model, solver)
    with stage("weighing what it costs and where it may fail"):
        budget = facts.budget
        said = {**describe(model, solver), "run_time": budget.total}
        return Advice(said, budget.payments(), cautions(facts), savings(budget), alternatives(scene, budget),
                      unaffordable(budget, "runs"))
