"""How a scene asks for each capability of a method, and what shows that it was computed."""

import importlib
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

import snowmpm
from snowmpm import components
from snowmpm.advice.along_front import more_accurate
from snowmpm.errors import InputError
from snowmpm.methods import has
from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import momentum, reach, steps


@dataclass(frozen=True)
class Asked:
    """ask(method) makes what needs the capability, and is refused without it; shown(made) asserts that it acted."""

    ask: Any
    shown: Any


def _free(method, **changes):
    return Simulation(given.scene(method, **changes))


def _with_block(method, velocity, **changes):
    return _free(method, bodies=[given.block(given.least_dimension(method), velocity)], **changes)


def _event(method, **event):
    return _free(method, events=[{"body": "one", **event}])


def _on_ground(method):
    return _free(method, gravity=given.G, terrain=given.ground(method, 10.0, 0.2),
                 bodies=[given.body(given.layer(given.least_dimension(method), 0.0, 0.6, 0.3))])


def _carried(simulation):
    steps(simulation, 10)
    weight = simulation.solver.totals.weight_impulse
    assert simulation.solver.totals.impulse @ weight < -1e-3 * weight @ weight


def _against_wall(method):
    dim = given.least_dimension(method)
    lower, upper = given.point(dim, given.SIDE + 0.02, -0.4, -0.4), given.point(dim, given.SIDE + 0.4, 0.8, 0.8)
    return _with_block(method, (8.0, 0.0), materials={"snow": given.snow(method)}, obstacles=[
        {"name": "wall", "shape": {"kind": "box", "min": lower, "max": upper}}])


def _stopped(simulation):
    steps(simulation, 15)
    assert simulation.solver.obstacle_totals.shape[0] == 1 and simulation.solver.obstacle_totals[0, 0] > 0.0
    assert simulation.audit()["momentum_residual"] < 1e-11


def _on_hats(method):
    dim = given.least_dimension(method)
    lower, upper = given.point(dim, given.SIDE + 0.02, -0.4, -0.4), given.point(dim, given.SIDE + 0.4, 0.8, 0.8)
    return _with_block(method, (8.0, 0.0), solver={"kernel": "gimp", "gradient": "shape", "transfer": "flip"},
                       materials={"snow": given.snow(method)}, obstacles=[
                           {"name": "wall", "shape": {"kind": "box", "min": lower, "max": upper}}])


def _around(method):
    dim = given.least_dimension(method)
    domain = {"min": given.point(dim, -0.8, -2.0, -2.0), "max": given.point(dim, 0.8, 2.0, 2.0),
              "boundary": {"x_min": "periodic", "x_max": "periodic"}}
    return _with_block(method, (20.0, 0.0), domain=domain)


def _came_back(simulation):
    n = simulation.n_particles
    reach(simulation, 0.06)
    x = simulation.particles["position"][:, 0]
    assert simulation.n_particles == n and x.min() >= -0.8 and x.max() <= 0.8
    assert x.min() < -0.3  # 1.2 m on: behind where it was


def _stressed(kind):
    def ask(method):
        dim = given.least_dimension(method)
        floor = {"min": given.point(dim, -2.0, 0.0, -2.0), "max": given.point(dim, 2.0, 2.0, 2.0),
                 "boundary": {"z_min": "slip"}}
        keys = {"terrain": given.ground(method)} if given.able(method).terrain else {"domain": floor}
        return _free(method, gravity=given.G, initial={"stress": kind, "tolerance": 0.05}, **keys)

    return ask


def _bears_its_weight(simulation):
    assert simulation.time == 0.0
    if given.EXAMPLES[simulation.scene.solver.method].in_plan:  # its pressure follows from the depth
        steps(simulation, 1)
        assert simulation.particles["depth"].max() == pytest.approx(given.SIDE, rel=1e-2)
        return
    vertical = simulation.particles["stress"][:, simulation.scene.dimension - 1]
    z = simulation.particles["position"][:, -1]
    expected = -given.DENSITY * given.G * (given.SIDE - z)
    middle = np.abs(z - 0.5 * given.SIDE) < 0.3 * given.SIDE
    # To the weight of half a cell, of a depth of two in the mean
    assert vertical[middle].mean() == pytest.approx(expected[middle].mean(), rel=0.25)


def _cut(method):
    dim = given.least_dimension(method)
    return _event(method, kind="cut", path=[given.point(dim, -0.2, 0.2, 0.0), given.point(dim, 0.1, 0.2, 0.0)])


def _bonds_gone(simulation):
    simulation.step()
    damage = simulation.particles["damage"]
    assert 0 < (damage == 1.0).sum() < len(damage)


def _loaded(method):
    dim = given.least_dimension(method)
    return _event(method, kind="load", force=given.point(dim, 100.0, 0.0))


def _pushed(simulation):
    for time in np.linspace(0.0, 0.02, 21)[1:]:
        reach(simulation, time)
    assert momentum(simulation)[0] == pytest.approx(100.0 * 0.02, rel=0.06)  # a step late at most


def _gone(simulation):
    n = simulation.n_particles
    simulation.step()
    assert n > 0 and simulation.n_particles == 0


def _saw(method):
    return Simulation(snowmpm.load_scene("pst_2d", {
        "solver.method": method, "solver.dx": 0.04, "saw_test.length": 1.2, "initial.stress": "geostatic"}))


def _is_recorded(simulation):
    steps(simulation, 2)
    assert simulation.crack is not None and np.isfinite(simulation.particles["position"]).all()


def _along(method):
    # Where bonds break, the fracture energy holds the grid unless it has a thickness of its own
    snow = {**given.SNOW, "reference_thickness": 2.0 * given.DX}
    return more_accurate(given.scene(method, materials={"snow": snow}))


def _changes_something(change):
    assert change.overrides and change.lines


CAPABILITIES = {
    "terrain": Asked(_on_ground, _carried),
    "obstacles": Asked(_against_wall, _stopped),
    "periodic": Asked(_around, _came_back),
    "initial_stress": Asked(_stressed("geostatic"), _bears_its_weight),
    "settling": Asked(_stressed("settle"), _bears_its_weight),
    "cuts": Asked(_cut, _bonds_gone),
    "loads": Asked(_loaded, _pushed),
    "removal": Asked(lambda method: _event(method, kind="remove"), _gone),
    "saw_test": Asked(_saw, _is_recorded),
    "averaged_hats": Asked(_on_hats, _stopped),
    "presets": Asked(_along, _changes_something),
}
"""How each capability that is true or false is asked for."""
for name in (component.name for component in components.declared()):
    CAPABILITIES[name] = Asked(*importlib.import_module(f"tests.components.{name}.capability").ASKED)


def choices(capability, value):
    """`Asked` for one of the values of dimensions or precisions."""
    key = {"dimensions": "dim", "precisions": "precision"}[capability]

    def ask(method):
        return Simulation(given.eventful(method, **{key: value}))

    return Asked(ask, _runs)


def _runs(simulation):
    steps(simulation, 5)
    assert simulation.solver.steps == 5
    for name in ("position", "velocity", "stress"):
        assert np.isfinite(simulation.particles[name]).all()
    assert simulation.particles["position"].shape[1] == simulation.scene.dimension


def is_as_declared(method, capability, value=None):
    """A capability that a method has acts; one that it has not is refused in two lines that name another way."""
    told = getattr(given.able(method), capability, None)
    able = bool(told) if value is None and told is not None else has(method, capability, value or True)
    asked = CAPABILITIES[capability] if value is None else choices(capability, value)
    if able:
        asked.shown(asked.ask(method))
        return
    with pytest.raises(InputError) as refusal:
        asked.ask(method)
    text = str(refusal.value)
    assert len(text.splitlines()) <= 2 and ("solver.method" in text or "another" in text), text
