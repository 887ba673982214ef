"""Settings that a scene could do without, each with the time saved."""

from dataclasses import dataclass, field, replace

import numpy as np

from snowmpm import components
from snowmpm.advice.cautions import cautions
from snowmpm.advice.depth_averaged import PLAN, in_columns
from snowmpm.advice.plane_strain import is_plane_strain
from snowmpm.advice.solved_steps import other_steps
from snowmpm.measured import costs
from snowmpm.measured.borders import shipped
from snowmpm.measured.depth_averaged import in_words
from snowmpm.methods import METHODS
from snowmpm.scenes.loader import with_overrides
from snowmpm.scenes.reasons import reasons

ON_A_PATH = 0.38
"""What depth-averaging added to the affected area on avaGar (`docs/depth_averaged.md`)."""

WORTH_SAYING = 0.05
"""Share of the run time below which a saving is not mentioned."""
SPARSE = 4
"""Particles a cell that do in 2-D, and for flows in 3-D (tests/benchmarks/particles_a_cell.py)."""
FAR = 10.0
"""Cells that snow goes in a flow, at least."""
LEAST_FRAMES = 20
"""Frames that a run is left with, about."""
SPARE_DOMAIN = 1.5
"""Length of a side of the domain, over the length that snow can reach, above which it is mentioned."""


@dataclass(frozen=True)
class Saving:
    """A possible saving: key and new setting; seconds and share of the run saved; overrides: keys with their new
    values, empty if the scene itself must be changed."""

    key: str
    says: str
    seconds: float
    share: float
    overrides: dict = field(default_factory=dict)


def _worth(budget, key, says, seconds, value=None):
    if seconds > WORTH_SAYING * budget.total:
        yield Saving(key, says, seconds, seconds / budget.total, {} if value is None else {key: value})


def _plane(budget):
    facts = budget.facts
    if facts.dim == 3 and 2 in METHODS[facts.scene.solver.method].capabilities.dimensions and is_plane_strain(facts):
        per_axis = facts.per_axis
        deep = max(1.0, np.ptp(facts.model.population.positions[:, 1]) / facts.dx * per_axis + 1.0)
        scheme = replace(budget.scheme, dimension=2)
        step = budget.step(scheme, 1.0 / deep, per_axis / deep)
        saved = budget.stepping - facts.steps * step + budget.output - budget.frames_at(1.0 / deep)
        yield from _worth(budget, "dimension", "2: nothing of it changes along y, it is plane strain", saved)


def _double(budget):
    if budget.scheme.precision != "f64" or "f32" not in METHODS[budget.scheme.method].capabilities.precisions:
        return
    if any(component.double for component in components.used(budget.facts.scene)):
        return
    border = shipped()["small_strains", "f32"]
    if border.failing(budget.facts.least_strain):
        return
    saved = budget.facts.steps * (budget.step() - budget.step(replace(budget.scheme, precision="f32")))
    limit = f"float32 holds to {border.value:.1g}" if border.value else "float32 holds them"
    yield from _worth(budget, "solver.precision", f'"f32": elastic strains are about {budget.facts.least_strain:.1g},'
                            f" and {limit} (atlas: small_strains)", saved, "f32")


def _frames(budget):
    """If frames take more than a fifth of the run: the interval at which they take a tenth."""
    share, own = budget.output / budget.total, budget.facts.scene.output.interval
    if share > 0.2:
        interval = float(f"{own * 9.0 * budget.output / budget.stepping:.1g}")
        interval = min(interval, float(f"{budget.facts.end / LEAST_FRAMES:.1g}"))
        if interval < 1.5 * own:
            return
        yield from _worth(budget, "output.interval", f"{interval:g} s: frames take {share:.0%} of the run,"
                          f" {budget.frames} of them", budget.output * (1.0 - own / interval), interval)


def _spline(budget):
    if METHODS[budget.scheme.method].capabilities.grid and budget.scheme.kernel == "cubic":
        saved = budget.facts.steps * (budget.step() - budget.step(replace(budget.scheme, kernel="quadratic")))
        yield from _worth(budget, "solver.kernel", '"quadratic": cubic is needed only where bodies are stretched to'
                                " twice their length, or bend far", saved, "quadratic")


def _crowded(budget):
    filling = budget.facts.scene.solver.particles_per_cell
    if not METHODS[budget.scheme.method].capabilities.grid or filling <= SPARSE:
        return
    usual, why = 8, "more are needed only where bodies are stretched to twice their length"
    if budget.facts.dim == 2 or _flows(budget.facts):
        usual = SPARSE
    if budget.facts.dim == 3 and usual == SPARSE:
        why = ("front and deposit of a collapse in 3-D were then 3 to 27 % further from those of a finer grid, but"
               " nearer to them for the same time, on smaller cells (`snowmpm docs speed`)")
    if filling > usual:
        share = usual / filling
        steps = budget.facts.steps * (budget.step() - budget.step(particles=share))
        saved = steps + budget.output - budget.frames_at(share)
        yield from _worth(budget, "solver.particles_per_cell", f"{usual}: {why}", saved, usual)


def _flows(facts):
    """Whether snow falls or runs far, beside the size of the cells, and no crack's energy hangs on the particles."""
    return not facts.scene.saw_test and facts.fall_speed * facts.end > FAR * facts.dx


def _short(budget):
    """A cfl or dt below the usual one."""
    scene, solver = budget.facts.scene, budget.facts.solver
    critical = solver.limits.critical_cfl
    usual = solver.limits.usual_cfl or solver.limits.cfl
    own = scene.solver.cfl
    if scene.solver.dt:
        own = usual * scene.solver.dt / (solver.critical_dt()[0] * usual / critical)
    if own and own < 0.8 * usual:
        key = "solver.dt" if scene.solver.dt else "solver.cfl"
        value = (scene.solver.dt or own) * usual / own
        yield from _worth(budget, key, f"leave it out: {own:.2g} of a cell a step where {usual:.2g} is stable and"
                                " usual", budget.stepping * (1.0 - own / usual), _below(value))


def _below(value):
    """A value rounded down to three digits."""
    unit = 10.0 ** (np.floor(np.log10(value)) - 2)
    return float(f"{np.floor(value / unit) * unit:.3g}")


def _stiff(budget):
    """A single material that limits the time step."""
    if budget.facts.scene.solver.dt:
        return
    speeds = {name: law.wave_speed() for name, law in zip(budget.facts.scene.materials, budget.facts.model.laws,
                                                          strict=True)}
    fastest = max(speeds, key=speeds.get)
    rest = max((speed for name, speed in speeds.items() if name != fastest), default=speeds[fastest])
    if speeds[fastest] > 2.0 * rest:
        soft = (speeds[fastest] / rest) ** 2
        yield from _worth(budget, f"materials.{fastest}.youngs_modulus", f"its waves alone set the step; {soft:.0f}"
                                " times softer it would be as fast as the rest, if its deformation does not matter",
                                budget.stepping * (1.0 - rest / speeds[fastest]), _softer(budget, fastest, soft))


def _softer(budget, name, factor):
    return float(f"{budget.facts.scene.materials[name].youngs_modulus / factor:.3g}")


def _domain(budget):
    """A domain larger than snow can reach: it costs memory, not time, since blocks follow the snow."""
    scene = budget.facts.scene
    if not scene.domain or scene.domain.min is None or budget.facts.model.surface is not None:
        return
    x = budget.facts.model.population.positions
    way = max(budget.facts.start_speed, budget.facts.fall_speed) * scene.end_time
    for a, axis in enumerate("xz" if budget.facts.dim == 2 else "xyz"):
        reach = np.ptp(x[:, a]) + 2.0 * way
        length = budget.facts.model.upper[a] - budget.facts.model.lower[a]
        if length > SPARE_DOMAIN * reach:
            yield Saving("domain", f"{length:.3g} m along {axis}, of which {reach:.3g} m can be reached: the rest"
                         " costs nothing, blocks of the grid follow the snow", 0.0, 0.0)


def _return_maps(budget):
    """A return map more accurate than the time step needs."""
    for name, law in zip(budget.facts.scene.materials, budget.facts.model.laws, strict=True):
        if law.integration == "substepped":
            kind = f"{law.kind}, substepped"
            more = costs.law(budget.scheme, kind) - costs.law(budget.scheme, law.kind)
            yield from _worth(budget, f"materials.{name}.return_map", '"implicit": sub-stepping pays where a step'
                                    " strains by a thousandth or more (atlas: apex)",
                                    budget.facts.steps * 1e-9 * budget.particles[law.kind] * more, "implicit")


def _columns(budget):
    """A thin flow in three dimensions that could be depth-averaged."""
    found = in_columns(budget.facts)
    if found:
        overrides, facts = found
        saved = budget.total - facts.budget.total
        says = (f'"{PLAN}", with solver.dx = {facts.dx:g}: the flow is thin, and could be depth-averaged. In the valley'
                f" of avalanche_on_raster that changed: {in_words()}; on a real path with a gully, the affected area by"
                f" {100.0 * ON_A_PATH:+.0f} %. Lost: all that happens within the depth, the laws of the snow, and what"
                " obstacles do to the flow; the loads on them follow from depth and speed")
        if saved > WORTH_SAYING * budget.total:
            yield Saving("solver.method", says, saved, saved / budget.total, overrides)


def _other_steps(budget):
    """Steps that are solved for in place of those of waves, or the other way."""
    for overrides, facts, says in other_steps(budget.facts):
        saved = budget.total - facts.budget.total
        if saved > WORTH_SAYING * budget.total:
            yield Saving("solver.method", says, saved, saved / budget.total, overrides)


FINDERS = (_columns, _other_steps, _plane, _double, _frames, _spline, _crowded, _short, _stiff, _domain, _return_maps)


def savings(budget):
    """`Saving`s of a scene, by its `Budget`, the largest first.

    A key with a comment on its line in the scene file is left alone, since the comment gives its reason. A saving that
    would cause a warning of the atlas is left out.
    """
    explained = reasons(budget.facts.scene.source)
    found = [saving for find in FINDERS for saving in find(budget)]
    kept = [saving for saving in found if saving.key not in explained and not _leads_astray(budget.facts, saving)]
    return sorted(kept, key=lambda saving: -saving.seconds)


def _leads_astray(facts, saving):
    """Whether a saving would cause a new warning."""
    if not saving.overrides:
        return False
    before = {caution.entry for caution in cautions(facts)}
    after = {caution.entry for caution in cautions(facts.with_scene(with_overrides(facts.scene, saving.overrides)))}
    return bool(after - before)
