"""All that `snowmpm check` says of a scene."""

from dataclasses import asdict, dataclass

from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.advice.savings import Budget
from snowmpm.build import build, check_step, described


@dataclass(frozen=True)
class Advice:
    """facts: of `build.described`; payments, cautions, savings: lists of `Payment`, `Caution`, `Saving`."""

    facts: dict
    payments: list
    cautions: list
    savings: list

    def record(self):
        """As JSON can hold it."""
        return {"facts": self.facts, **{name: [asdict(item) for item in getattr(self, name)]
                                        for name in ("payments", "cautions", "savings")}}


def advise(scene):
    """`Advice` on a scene. Raises InputError as `build` does."""
    model = build(scene)
    solver = model.solver()
    check_step(scene, solver)
    facts = SceneFacts(scene, model, solver)
    budget = Budget(facts)
    described_facts = {**described(model, solver), "run_time": budget.total}
    return Advice(described_facts, budget.payments(), cautions(facts), budget.savings())
