"""All that `snowmpm check` says of a scene."""

from dataclasses import asdict, dataclass

from snowmpm.advice.budget import Budget
from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.advice.savings import savings
from snowmpm.build import build
from snowmpm.description import describe
from snowmpm.step_check import check_step


@dataclass(frozen=True)
class Advice:
    """facts: of `description.describe`, and the run time [s]; lists of `Payment`, `Caution` and `Saving`."""

    facts: dict
    payments: list
    cautions: list
    savings: list

    def record(self):
        """As JSON can hold it."""
        return {**self.facts, **{name: [asdict(item) for item in getattr(self, name)]
                                        for name in ("payments", "cautions", "savings")}}


def advise(scene):
    """`Advice` on a scene. Raises InputError as `build` does."""
    model = build(scene)
    solver = model.solver()
    check_step(scene, solver)
    facts = SceneFacts(scene, model, solver)
    budget = Budget(facts)
    said = {**describe(model, solver), "run_time": budget.total}
    return Advice(said, budget.payments(), cautions(facts), savings(budget))
