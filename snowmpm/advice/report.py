"""The complete report of `snowmpm check` on a scene."""

from dataclasses import asdict, dataclass, replace

from snowmpm.advice.affordability import unaffordable
from snowmpm.advice.along_front import faster, more_accurate
from snowmpm.advice.budget import Payment
from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.advice.savings import savings
from snowmpm.handover.outlook import legs
from snowmpm.measured import costs
from snowmpm.methods import METHODS
from snowmpm.running.description import describe
from snowmpm.setup.build import build
from snowmpm.stages import stage
from snowmpm.stepping.step_check import check_step

ZONE = "zone."
"""Table of the scene that holds a zone's solver."""


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
    scene_facts: SceneFacts | None = None
    """of the scene's first method; not among the values of `record`"""

    def record(self):
        """The advice as values that JSON can hold."""
        return {**self.facts, "unaffordable": self.unaffordable, **{name: [asdict(item) for item in vars(self)[name]]
                                        for name in ("payments", "cautions", "savings", "along")}}


def advise(scene):
    """`Advice` on a scene. Raises InputError as `build` does."""
    model = build(scene)
    solver = model.solver()
    check_step(scene, solver)
    with stage("weighing what it costs and where it may fail"):
        facts, *later = [SceneFacts(leg.scene, leg.model, leg.solver, leg.begin, leg.end)
                         for leg in legs(model, solver)]
        budget, seconds = facts.budget, [one.budget.total - one.budget.start for one in later]
        said = {**describe(model, solver), **_assumed(scene), **_switches(scene, facts, later),
                "run_time": budget.total + sum(seconds)}
        if later:
            said["steps"] = int(facts.steps)
        warned = list(dict.fromkeys([*cautions(facts), *(found for one in later for found in _cautions(one, scene))]))
        return Advice(said, _all_payments(budget, later, seconds), warned, savings(budget),
                      alternatives(scene, budget), unaffordable(budget, "runs"), facts)


def _cautions(facts, scene):
    """`Caution`s of a method that comes later; of that of a zone with the zone's keys."""
    return [replace(one, key=ZONE + one.key, cure=one.cure.replace("solver.", f"{ZONE}solver."))
            if scene.zone and one.key.startswith("solver.") else one for one in cautions(facts)]


def _assumed(scene):
    """Fact, in words, of costs that nobody measured."""
    said = {law.kind: f"{law.kind}, as {costs.taken_as(law.kind)}" for law in scene.materials.values()
            if costs.taken_as(law.kind) != law.kind}
    return {"assumed_cost": f"not measured: {'; '.join(said.values())}"} if said else {}


def _switches(scene, facts, later):
    """Facts, in words, of the hand-overs of a scene; facts of its methods but the first."""
    said = []
    for switch, one in zip(scene.switch, later, strict=False):
        entry = METHODS[switch.to]
        when = f"when {switch.when}" if switch.time is None else f"at t = {switch.time:g} s"
        about = "" if switch.time is not None else f", about at t = {one.begin:.2g} s"
        said.append(f"to {entry.title} {when}{about}: {one.budget.n} {one.scene.solver.pieces}, cells of {one.dx:g} m,"
                    f" then about {one.steps:.0f} steps")
    if scene.zone:
        entry, one = METHODS[scene.zone.solver.method], later[-1]
        return {"zone": f"by {entry.title}, at most {one.budget.n} {entry.particles}, cells of {one.dx:g} m, from about"
                        f" t = {one.begin:.2g} s on, then about {one.steps:.0f} steps"}
    return {"hand_over": "; ".join(said)} if said else {}


def _all_payments(budget, later, seconds):
    """`Payment`s of the first method with their shares of all of the run, and one of each other method."""
    whole = budget.total + sum(seconds)
    found = [payment if payment.share is None else replace(payment, share=payment.seconds / whole)
             for payment in budget.payments()]
    return found + [Payment(f"then {METHODS[one.scene.solver.method].title}",
                            f"{one.budget.n} {one.scene.solver.pieces}, {one.steps:.0f} steps,"
                            f" {one.budget.frames} frames", cost, cost / whole)
                    for one, cost in zip(later, seconds, strict=True)]
