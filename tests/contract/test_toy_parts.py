"""A toy law, transfer, event and field: what is declared is computed, written and resumed; what is missing is an error
and never something else. docs/developer.md counts the files that each takes."""

from typing import ClassVar, Literal

import numpy as np
import pytest

import snowmpm
from snowmpm.compiler import ti
from snowmpm.errors import InputError
from snowmpm.materials import LAWS, Elastic, StateVariable
from snowmpm.measured import costs
from snowmpm.particles.fields import READERS
from snowmpm.quantities.particle_fields import UNITS
from snowmpm.running.events import MAKERS, Event
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.spec import Spec
from snowmpm.schemes import TRANSFERS, Transfer

SNOW = {"density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}
elastic_update = Elastic.update


def block(fields=("velocity",), **solver):
    """A block of snow in free fall."""
    return Scene.model_validate({
        "name": "block", "dimension": 2, "end_time": 0.02,
        "solver": {"dx": 0.2, "precision": "f64", **solver}, "output": {"interval": 0.01, "fields": list(fields)},
        "domain": {"min": [-1.0, -1.0], "max": [2.0, 2.0]}, "materials": {"snow": {"kind": "elastic", **SNOW}},
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


@pytest.mark.filterwarnings("ignore:Pydantic serializer")  # the union does not know it
def test_a_law_is_stored_reported_and_restored_as_it_declares(monkeypatch, tmp_path):
    monkeypatch.setitem(LAWS, "aged", Aged)
    scene = block(["age"]).model_copy(update={"materials": {"snow": Aged(**SNOW)}})
    run = snowmpm.run(scene, tmp_path)
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

class Kick(Spec):
    """Gives a body a velocity at once."""

    NEEDS: ClassVar = "loads"
    kind: Literal["kick"] = "kick"
    body: str
    start: float = 0.0
    gain: tuple[float, ...]


class Kicking(Event):
    def apply(self, simulation):
        if simulation.time >= self._spec.start:
            gain, own = np.array(self._spec.gain), simulation.particles["body"] == self._body
            mass = float(simulation.particles["mass"][own].sum())
            simulation.solver.push(simulation.numbers_of_body(self._body), gain, mass)
            self.done = True


def test_an_event_is_a_table_and_a_row(monkeypatch):
    scene = block().model_copy(update={"gravity": 0.0, "events": (Kick(body="block", start=0.005, gain=(2.0, 0.0)),)})
    with pytest.raises(KeyError, match="kick"):
        snowmpm.Simulation(scene)
    monkeypatch.setitem(MAKERS, "kick", lambda spec, body, dx: Kicking(spec, body))
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

def test_a_field_is_a_unit_and_a_reader(monkeypatch, tmp_path):
    with pytest.raises(ValueError, match="'velocity'"):
        block(["speed"])
    monkeypatch.setitem(UNITS, "speed", "m/s")
    with pytest.raises(KeyError, match="no particle field 'speed'"):  # no zeros
        _ = snowmpm.Simulation(block()).particles["speed"]
    monkeypatch.setitem(READERS, "speed", lambda fields: np.linalg.norm(fields["velocity"], axis=1))
    run = snowmpm.run(block(["speed", "velocity"]), tmp_path)
    last = run.frame(-1)
    assert run.units["speed"] == "m/s" and last.fields["speed"].min() > 0.1
    assert np.allclose(last.fields["speed"], np.linalg.norm(last.fields["velocity"], axis=1), rtol=1e-6)


def test_every_field_with_a_unit_has_a_reader():
    assert UNITS.keys() == READERS.keys()
