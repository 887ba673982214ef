"""A scene moved along the Pareto front: changes by `--fast` and `--accurate`, and their measured effect.

The moves and their effect on the error are those of `presets`, from problems with known answers. The time saved is
computed for the given scene from its own `Budget`: particles, blocks, steps, calls and frames at their measured costs.
"""

from dataclasses import dataclass, replace

import numpy as np

from snowmpm import components
from snowmpm.advice.facts import SceneFacts
from snowmpm.advice.weak_layers import coarsest_dx, tuned_to_grid
from snowmpm.errors import InputError
from snowmpm.scenes.loader import with_overrides
from snowmpm.schemes import misfit
from snowmpm.setup.build import build
from snowmpm.setup.refusals import require
from snowmpm.stepping.time_step import critical_cfl, grain_stiffness, usual_cfl
from snowmpm.study import presets
from snowmpm.study.measurement import read
from snowmpm.study.presets import FASTER, LESS_ERROR, MARGIN

WORTH_IT = 0.95
"""Share of the time that a move must leave at most to be a saving."""
LEAST_CELLS = 0.7
"""Least thickness of the thinnest part of a scene [cells]: a row or two of particles, with the stiffness of a cell."""


@dataclass(frozen=True)
class Change:
    """overrides: keys of the scene with their new values; lines: description; ratio: expected time of the run over
    the time before, without the start."""

    overrides: dict
    lines: tuple
    ratio: float


def _refuse_unmeasured(scene, option):
    require(scene, "presets", "solver.method", scene.solver.method, what=f"for {option}, measured for nothing else")


def faster(scene, budget=None):
    """`Change` that makes a scene run FASTER with the least measured loss of accuracy. budget: of the scene, if known.
    Raises InputError as `build`."""
    _refuse_unmeasured(scene, "--fast")
    budget = budget or _budget_of(scene)
    limit, saving = coarsest(scene), _saving(scene, budget)
    tuned = tuned_to_grid(scene)
    allowed = [gain for gain in _table(scene) if gain.move.coarser <= (1.0 if tuned else limit)]
    gains = [gain for gain in allowed if saving(gain.move) <= WORTH_IT]
    refused = None
    while gains and (refusal := _refusal(scene, (gain := presets.fastest(gains, saving)).move)):
        gains = [other for other in gains if other.move.coarser < gain.move.coarser]
        refused = refusal
    if not gains:
        thin = "" if tuned or thinnest(scene) == float("inf") else f": its thinnest part is {thinnest(scene):.3g} m"
        why = f"; on coarser cells {refused}" if refused else thin
        return _unchanged("--fast", f"nothing that was measured makes it faster on this grid{why}", tuned)
    ratio = _ratio(scene, gain.move, saving, budget)
    lines = _said(scene, gain, ratio, "--fast")
    if refused:
        lines.append(f"no coarser cells: {refused}")
    thin = thinnest(scene)
    if gain.move.coarser > 1.0 and thin < gain.move.coarser * scene.solver.dx:
        lines.append(f"its thinnest part, {thin:.3g} m, is then {thin / (gain.move.coarser * scene.solver.dx):.2g} of a"
                     " cell: what happens in it is smeared over one")
    if ratio > 1.0 / (FASTER * MARGIN):
        held = len(allowed) < len(_table(scene))
        lines.append(f"not {FASTER:g} times for sure: its thinnest part is {thin:.3g} m, which a coarser grid would not"
                     " resolve" if held else f"not {FASTER:g} times for sure: frames and calls of kernels stay")
    return Change(_overrides(scene, gain.move), tuple(lines), ratio)


def more_accurate(scene, budget=None):
    """`Change` that reduces the typical error to LESS_ERROR of its value, at the least measured cost."""
    _refuse_unmeasured(scene, "--accurate")
    budget = budget or _budget_of(scene)
    saving, tuned = _saving(scene, budget), tuned_to_grid(scene)
    gains = [gain for gain in _table(scene) if gain.typical < 1.0 and (gain.move.coarser == 1.0 or not tuned)]
    if not gains:
        return _unchanged("--accurate", "nothing that was measured leaves less error", tuned)
    gain = presets.most_accurate(gains, saving)
    ratio = _ratio(scene, gain.move, saving, budget)
    lines = _said(scene, gain, ratio, "--accurate")
    if gain.typical > LESS_ERROR:
        lines.append(f"not {LESS_ERROR:g} of the error: nothing that was measured does that for this choice of solver")
    return Change(_overrides(scene, gain.move), tuple(lines), ratio)


def _refusal(scene, move):
    """Why a scene is refused after a move, or None. Asked only of scenes with bodies or structures that move with the
    snow: how light they may be goes with the grid. It takes as long as the set-up of the moved scene."""
    if move.coarser == 1.0 or not any(component.solid for component in components.used(scene)):
        return None
    try:
        build(with_overrides(scene, _overrides(scene, move))).solver()
    except InputError as error:
        return str(error).splitlines()[0].removeprefix(f"{scene.source}: ")
    return None


def _unchanged(option, why, tuned):
    """A `Change` of nothing; tuned: the weak layer that holds the grid, or None."""
    lines = [f"{option}: changes nothing: {why}"]
    if tuned:
        lines.append(f"the softening of materials.{tuned.material} was chosen for this solver.dx, on another cracks run"
                     " at another load; with reference_thickness it would not depend on it")
    return Change({}, tuple(lines), 1.0)


def _table(scene):
    """Moves that change something in this scene. Its explicit choices stay: a scene that already has cubic splines uses
    the other moves."""
    chosen = scene.solver
    return [gain for gain in presets.gains(read(presets.DATA))
            if all(chosen[name] != value for name, value in gain.move.variation.scheme.items())
            and not misfit(**_scheme(chosen, gain.move))
            and (gain.move.variation.per_axis == 2 or _per_cell(gain.move, scene) > chosen.particles_per_cell)]


def _per_cell(move, scene):
    return move.variation.per_axis**scene.dimension


def _step(scene, move=None):
    """C of the elastic limit of a scene after a move."""
    chosen = scene.solver
    stiffness = max(grain_stiffness(law, scene.dimension) for law in scene.materials.values())
    critical = critical_cfl(**_scheme(chosen, move), stiffness=stiffness)
    return min(chosen.cfl or usual_cfl(critical), critical)


def _scheme(chosen, move=None):
    """Kernel, gradient and transfer of a scene's solver table after a move."""
    changed = move.variation.scheme if move else {}
    return {name: changed.get(name, chosen[name]) for name in ("kernel", "gradient", "transfer")}


def _budget_of(scene):
    model = build(scene)
    return SceneFacts(scene, model, model.solver()).budget


def _ratio(scene, move, saving, budget):
    """Expected time after a move over the time before. Where a component shortens the steps, which it does by another
    law than the grid, it is that of the moved scene itself, whose set-up this takes."""
    if not budget.facts.solver.workload.shortened:
        return saving(move)
    after = _budget_of(with_overrides(scene, _overrides(scene, move)))
    return (after.total - after.start) / (budget.total - budget.start)


def _saving(scene, budget):
    """saving(move): expected time of the run after it over the time before, steps and frames at their measured costs;
    both without the start, which no move shortens."""

    def saving(move):
        size = move.coarser**-scene.dimension
        share = size * _particles(scene, move)
        longer = move.coarser * (1.0 if scene.solver.dt else _step(scene, move) / _step(scene))
        step = budget.step(replace(budget.scheme, **move.variation.scheme), share, size)
        stepping = budget.facts.steps / longer * step
        settling = budget.settling * step / budget.step()
        return (stepping + settling + budget.frames_at(share)) / (budget.total - budget.start)

    return saving


def _particles(scene, move):
    """Particles a cell over those before."""
    return _per_cell(move, scene) / scene.solver.particles_per_cell if move.variation.per_axis != 2 else 1.0


def _overrides(scene, move):
    chosen = scene.solver
    changed = {f"solver.{name}": value for name, value in move.variation.scheme.items()}
    if move.coarser != 1.0:
        changed["solver.dx"] = float(f"{chosen.dx * move.coarser:.4g}")
        if chosen.dt:
            changed["solver.dt"] = float(f"{chosen.dt * move.coarser:.4g}")
    if move.variation.per_axis != 2:
        changed["solver.particles_per_cell"] = _per_cell(move, scene)
    if chosen.cfl and _step(scene, move) < chosen.cfl:
        # Rounded down: it must stay below the critical one
        changed["solver.cfl"] = float(np.floor(1e3 * _step(scene, move)) / 1e3)
    return changed


def _said(scene, gain, ratio, option):
    before = {"solver.cfl": round(_step(scene), 3)}
    parts = []
    for key, value in _overrides(scene, gain.move).items():
        was = before.get(key, scene.solver[key.partition(".")[2]])
        parts.append(f"{key} {_text(was)} -> {_text(value)}")
    time = f"{1.0 / ratio:.2g} times faster" if ratio < 1.0 else f"{ratio:.2g} times the time"
    return [f"{option}: {', '.join(parts)}",
            f"expected: {time} once it has started, {presets.in_words(gain.error)} times the error, as measured in"
            f" {len(gain.error)} problems with known answers (median, range)"]


def _text(value):
    return f"{value:g}" if isinstance(value, float) else str(value)


def thinnest(scene):
    """Least extent of a body that a grid must resolve [m]; inf where none is known before it is built. A weak layer
    that is drawn some cells thick follows the grid, one that a component carries has no cells."""
    if scene.saw_test:
        test = scene.saw_test
        carried = next(components.carried(scene, body) for body in scene.bodies if body.name == "weak_layer")
        return min((layer.thickness for _, layer in test.layers
                    if layer is not test.weak_layer or not (layer.cells or carried)), default=float("inf"))
    return min((body.shape.thickness for body in scene.bodies if not components.carried(scene, body)),
               default=float("inf"))


def coarsest(scene):
    """Largest factor of dx at which the thinnest part is still LEAST_CELLS thick, and a weak layer has the cells that
    it needs; 1 where it is less already."""
    dx = min(thinnest(scene) / LEAST_CELLS, coarsest_dx(scene))
    return max(1.0, dx / scene.solver.dx * (1.0 + 1e-9))
