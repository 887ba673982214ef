"""A toy law, transfer, event and field: what is declared is computed, written and resumed; what is missing is an error
and never something else. docs/developer.md counts the files that each takes."""

from typing import ClassVar, Literal

import numpy as np
import pytest

import snowmpm
from snowmpm.compiler import ti
from snowmpm.errors import InputError
from snowmpm.materials import Elastic, StateVariable
from snowmpm.measured import costs
from snowmpm.particles.fields import ParticleField
from snowmpm.running import event as running
from snowmpm.scenes import events, load_scene
from snowmpm.scenes.schema import Scene
from snowmpm.schemes import TRANSFERS, Transfer
from tests.support.registered import registered

SNOW = {"density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
elastic_update = Elastic.update


def block(fields=("velocity",), material=None, events=(), gravity=9.81, **solver):
    """A block of snow in free fall."""
    return Scene.model_validate({
        "name": "block", "dimension": 2, "end_time": 0.02,
        "solver": {"dx": 0.2, "precision": "f64", **solver}, "output": {"interval": 0.01, "fields": list(fields)},
        "domain": {"min": [-1.0, -1.0], "max": [2.0, 2.0]}, "gravity": gravity,
        "materials": {"snow": material or {"kind": "elastic", **SNOW}}, "events": events,
        "bodies": [{"name": "block", "material": "snow",
                    "shape": {"kind": "box", "min": [0.0, 0.4], "max": [0.4, 0.8]}}]})


# ---- a law ----------------------------------------------------------------------------------------------------------

@ti.func
def aged_update(prm: ti.template(), h, state, A, dt):
    h_new, tau, state_new, dissipation, iterations = elastic_update(prm, h, state, A, dt)
    state_new[0] = state[0] + dt
    return h_new, tau, state_new, dissipation, iterations


class Aged(Elastic):
    """Elastic snow that knows how old it is."""

    STATE: ClassVar = (StateVariable("age", "s", "time since the start"),)
    OUTPUTS: ClassVar = {"age": "s"}
    kind: Literal["aged"] = "aged"
    update = staticmethod(aged_update)

    def initial_state(self):
        return (0.0,)

    def outputs(self, state):
        return {"age": np.asarray(state)[..., 0]}


def test_a_law_is_stored_reported_and_restored_as_it_declares(tmp_path):
    with pytest.raises(ValueError, match="'aged'"):
        block(["age"], material={"kind": "aged", **SNOW})
    with registered(Aged):
        aged(tmp_path)


def reloaded(scene, folder):
    (folder / "again.toml").write_text(scene.to_toml())
    return load_scene(folder / "again.toml")


def aged(folder):
    scene = block(["age"], material={"kind": "aged", **SNOW})
    assert reloaded(scene, folder).model_dump() == scene.model_dump()  # what is written can be read
    run = snowmpm.run(scene, folder)
    assert run.units["age"] == "s"
    assert np.allclose(run.frame(-1).fields["age"], 0.02, rtol=1e-12, atol=0.0)
    simulation = snowmpm.Simulation(scene)
    simulation.step()
    state, other = simulation.state(), snowmpm.Simulation(scene)
    other.restore(state)
    assert other.particles["age"].tobytes() == simulation.particles["age"].tobytes()


# ---- a transfer -----------------------------------------------------------------------------------------------------

def test_a_transfer_is_a_row(monkeypatch):
    """Of one that does what APIC does, the bits are those of APIC."""
    monkeypatch.setitem(TRANSFERS, "twin", Transfer("twin", affine=True, flip=False))
    ends = []
    for name in ("apic", "twin"):
        simulation = snowmpm.Simulation(block(transfer=name))
        for _ in range(3):
            simulation.step()
        ends.append(simulation.particles["velocity"].tobytes())
    assert ends[0] == ends[1]
    with pytest.raises(InputError, match="no row more, 2, f32, twin"):
        costs.transfers(costs.Scheme(2, transfer="twin"))


# ---- an event -------------------------------------------------------------------------------------------------------

class Kicking(running.Event):
    def apply(self, simulation):
        if simulation.time >= self._spec.start:
            gain, own = np.array(self._spec.gain), simulation.particles["body"] == self._body
            mass = float(simulation.particles["mass"][own].sum())
            simulation.solver.push(simulation.numbers_of_body(self._body), gain, mass)
            self.done = True


class Kick(events.Event):
    """Gives a body a velocity at once."""

    NEEDS: ClassVar = "loads"
    ACTS: ClassVar = Kicking
    kind: Literal["kick"] = "kick"
    body: str
    start: float = 0.0
    gain: tuple[float, ...]


def test_an_event_is_a_table_with_what_it_does():
    with pytest.raises(ValueError, match="'kick'"):
        kicked()
    with registered(Kick):
        moves_at_once(kicked())


def kicked():
    return block(gravity=0.0, events=[{"kind": "kick", "body": "block", "start": 0.005, "gain": [2.0, 0.0]}])


def moves_at_once(scene):
    simulation = snowmpm.Simulation(scene)
    while simulation.time < 0.004:
        simulation.step(until=0.004)
    assert np.abs(simulation.particles["velocity"]).max() == 0.0
    state, other = simulation.state(), snowmpm.Simulation(scene)
    other.restore(state)
    for one in (simulation, other):
        while one.time < 0.03:  # some steps
            one.step(until=0.03)
        assert np.allclose(one.particles["velocity"], [2.0, 0.0], rtol=1e-9)
        assert one.audit()["momentum_residual"] < 1e-12
    assert other.particles["velocity"].tobytes() == simulation.particles["velocity"].tobytes()


# ---- a field --------------------------------------------------------------------------------------------------------

def test_a_field_is_a_unit_and_a_reader(tmp_path):
    with pytest.raises(ValueError, match="'velocity'"):
        block(["speed"])
    with pytest.raises(KeyError, match="no particle field 'speed'"):  # no zeros
        _ = snowmpm.Simulation(block()).particles["speed"]
    with registered(ParticleField("speed", "m/s", lambda fields: np.linalg.norm(fields["velocity"], axis=1))):
        run = snowmpm.run(block(["speed", "velocity"]), tmp_path)
    last = run.frame(-1)
    assert run.units["speed"] == "m/s" and last.fields["speed"].min() > 0.1
    assert np.allclose(last.fields["speed"], np.linalg.norm(last.fields["velocity"], axis=1), rtol=1e-6)
