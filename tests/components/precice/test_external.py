"""Structures that another program computes: the same plate by snowmpm and by a stand-in of preCICE, and refusals."""

import sys

import numpy as np
import pytest

import snowmpm
from snowmpm import Simulation
from snowmpm.advice.report import advise
from snowmpm.components.precice.external import External
from snowmpm.errors import InputError, SimulationError
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.toml import table_text
from tests.components.precice.coupled_plate import PLATE, computed, config, plate, scene
from tests.components.precice.stand_in import StandIn

FOOT = PLATE["foot"]


def stand_in(monkeypatch, *args, **keys):
    """A stand-in in place of the module, and its plate."""
    module = StandIn(plate(), *args, **keys)
    monkeypatch.setitem(sys.modules, "precice", module)
    return module


def test_windows_of_one_step_are_weak_coupling(monkeypatch, tmp_path):
    """Same numbers in the same order: round-off of x - x_0 + x_0 is all that differs."""
    end = 0.06
    own = computed(scene(end))
    module = stand_in(monkeypatch, end)
    other = computed(scene(end, config(tmp_path, end)))
    assert other.solver.steps == own.solver.steps > 20 and other.audit()["plate_top_x"] > 0.04
    assert other.particles["position"] == pytest.approx(own.particles["position"], abs=1e-12)
    assert other.audit()["plate_top_x"] == pytest.approx(own.audit()["plate_top_x"], abs=1e-12)
    assert module.participants[0].finalized


@pytest.mark.parametrize("names", [{}, {"velocity": None}])
def test_the_other_program_receives_what_the_snow_lost(monkeypatch, tmp_path, names):
    """Windows of several steps: the sum of force times window is the impulse that the snow gave; the plate bends as in
    weak coupling, but for what steps that windows cut short change."""
    end = 0.06
    module = stand_in(monkeypatch, end, size=end / 10)
    other = computed(scene(end, config(tmp_path, end, size=end / 10), names=names))
    lost = other.obstacle_totals[:, :2].sum(axis=0)
    assert len(module.passed) == 10 < other.solver.steps and lost[0] > 200.0
    assert module.peer.received == pytest.approx(lost, rel=1e-13)
    row = other.audit()
    assert row["structure_momentum_residual"] < 1e-13 and row["momentum_residual"] < 1e-13
    assert row["plate_force_x"] == pytest.approx(module.passed[-1][0].sum(axis=0)[0], rel=1e-12)
    assert row["plate_top_x"] == pytest.approx(0.04663, rel=0.01)  # the plate of the test before


def test_repeated_windows_of_one_step_are_strong_coupling(monkeypatch, tmp_path):
    """The plate has half the mass of the snow around it; both methods end rounds at a change of 1e-5 or less."""
    end, dt, light = 0.01, 0.001, {"density": 150.0}
    own = computed(scene(end, coupling="strong", dt=dt, **light))
    module = StandIn(plate(**light), end, size=dt, rounds=100, tolerance=1e-6)
    monkeypatch.setitem(sys.modules, "precice", module)
    other = Simulation(scene(end, config(tmp_path, end, "serial-implicit", size=dt), dt=dt, names={"velocity": None}))
    while other.time < end:
        other.step(until=end / 2 if other.time < 0.49 * end else end)
    assert other.dt_cause == "window" and other.solver.steps == own.solver.steps == 10
    row = other.audit()
    assert row["structure_rounds"] > 30.0 and row["structure_unsettled"] == 0.0
    assert row["plate_top_x"] == pytest.approx(own.audit()["plate_top_x"], rel=1e-4)
    assert module.peer.received == pytest.approx(other.obstacle_totals[:, :2].sum(axis=0), rel=1e-12)
    assert row["structure_momentum_residual"] < 1e-12 and row["momentum_residual"] < 1e-12


def test_a_run_holds_it_bent(monkeypatch, tmp_path):
    stand_in(monkeypatch, 0.06)
    bent = scene(0.06, config(tmp_path, 0.06))
    run = snowmpm.run(bent, tmp_path / "run")
    top = run.obstacles["plate_6"]
    middle = top.placed(len(run) - 1).mean(axis=0) + run.origin
    assert run.history["plate_top_x"][-1] > middle[0] - PLATE["top"][0] > 0.5 * run.history["plate_top_x"][-1] > 1e-3
    assert run.units["plate_force_x"] == "N/m"
    with pytest.raises(InputError, match="is not resumed"):
        snowmpm.run(bent, tmp_path / "run", resume=True)


class Rigid:
    """A structure that does not move, in space; received (3,) [N s]."""

    received = np.zeros(3)

    def window(self, dt, force):
        """No displacement, no velocity."""
        self.received = self.received + dt * force.sum(axis=0)
        return np.zeros_like(force), np.zeros_like(force)


@pytest.mark.parametrize("dim", [2, 3])
def test_meshes_in_space(monkeypatch, tmp_path, dim):
    """Of a scene in space, and of one in the plane of x and z, where y stays 0."""
    def lifted(x):
        return [x[0], 0.35, x[1]] if dim == 3 else list(x)

    file = config(tmp_path, 0.01)
    file.write_text(file.read_text().replace('dimensions="2"', 'dimensions="3"'))
    monkeypatch.setitem(sys.modules, "precice", module := StandIn(Rigid(), 0.01, dim=3))
    body = {"kind": "box", "min": [0.0] * dim, "max": [0.4, 0.7, 0.4][:dim]}
    simulation = computed(Scene.model_validate({
        "name": "struck", "dimension": dim, "end_time": 0.01, "solver": {"dx": 0.1, "precision": "f64"},
        "domain": {"min": [-1.0, 0.0, 0.0][:dim], "max": [3.0] * dim},
        "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}},
        "bodies": [{"name": "snow", "material": "snow", "shape": body, "velocity": [3.0] + [0.0] * (dim - 1)}],
        "structures": [{"name": "mast", "points": [lifted(FOOT), lifted(PLATE["top"])], "segments": 3, "width": 0.2,
                        "precice": {"file": str(file)}}]}))
    assert module.participants[0].positions[-1] == pytest.approx([0.513, 0.35 * (dim == 3), 0.583])
    lost = simulation.obstacle_totals[:, :dim].sum(axis=0)
    assert lost[0] > 1.0
    assert module.peer.received[[0, 2] if dim == 2 else [0, 1, 2]] == pytest.approx(lost, abs=1e-11 * lost[0])
    assert simulation.audit()["structure_momentum_residual"] < 1e-12


def test_nodes_go_on_as_they_went_or_come_where_they_are_awaited():
    one = External([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]], 2)
    assert one.n == 4 and np.array_equal(one.start[3], [0.5, 0.0, 1.0])
    assert np.array_equal(one.along[1:3], [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    moved = np.full((5, 3), 0.1)
    one.take_displacement(moved, 0.5)
    assert np.allclose(one.v, 0.2)
    one.advance(0.25, np.ones((5, 3)))
    assert np.allclose(one.x - one.start, 0.15)
    one.head_for(2.0 * moved, 0.25, 3.0 * moved)
    assert np.allclose(one.v, 0.3)
    one.advance(0.25, np.ones((5, 3)))
    assert np.allclose(one.x - one.start, 0.2)
    one.hand_over(0.5)
    assert np.allclose(one.force, 1.0) and np.allclose(one.given, 2.5) and np.allclose(one.held, -2.5)
    kept = one.state()
    one.begin()
    assert not one.v.any() and not one.given.any() and np.array_equal(one.x, one.start)
    one.restore(kept)
    assert np.allclose(one.x - one.start, 0.2)


@pytest.mark.parametrize("size", [None, 0.0013])
def test_after_its_end_there_is_no_step(monkeypatch, tmp_path, size):
    stand_in(monkeypatch, 0.004, size=size)
    simulation = Simulation(scene(0.004, config(tmp_path, 0.004, size=size)))
    while simulation.time < 0.004:
        simulation.step()
    with pytest.raises(SimulationError, match=r"ended at t = 0\.004 s"):
        simulation.step()


def test_a_step_must_not_end_within_a_repeated_window(monkeypatch, tmp_path):
    stand_in(monkeypatch, 0.004, size=0.002, rounds=9)
    simulation = Simulation(scene(0.004, config(tmp_path, 0.004, "serial-implicit", size=0.002)))
    with pytest.raises(InputError, match=r"lies in a time window of preCICE, from 0 to 0\.002 s"):
        simulation.step(until=0.001)


def test_a_failure_of_the_library_says_when(monkeypatch, tmp_path):
    module = stand_in(monkeypatch, 0.01)
    simulation = Simulation(scene(0.01, config(tmp_path, 0.01)))
    simulation.step()
    monkeypatch.setattr(module.peer, "window", lambda *_: (_ for _ in ()).throw(RuntimeError("the socket\nis closed")))
    with pytest.raises(SimulationError, match=r"preCICE, at t = .* s: the socket"):
        simulation.step()


def test_check_says_what_it_leaves_out(tmp_path):
    def about_it(scene):
        return [caution for caution in advise(scene).cautions if caution.key == "structures.0.precice.file"]

    explicit = about_it(scene(0.06, config(tmp_path, 0.06)))
    assert [caution.entry for caution in explicit] == ["", "light_structure"]
    assert "leaves out the other program: each step" in explicit[0].says and "60 kg/m" in explicit[1].says
    [implicit] = about_it(scene(0.06, config(tmp_path, 0.06, "serial-implicit", size=0.001)))
    assert "60 time windows of 0.001 s, each computed several times" in implicit.says


@pytest.mark.parametrize(("written", "change", "words"), [
    ({}, {"participant": "Snwo"}, 'structures.0.precice.participant = \'Snwo\': must be a participant'),
    ({}, {"mesh": "Snow"}, "did you mean Snow-Mesh?"),
    ({}, {"mesh": "Solid-Mesh"}, "must be a mesh that Snow provides"),
    ({}, {"force": "Forces"}, "'Forces': must be what Snow has as write-data of Snow-Mesh in"),
    ({}, {"displacement": "Force"}, "must be what Snow has as read-data"),
    ({}, {"end_time": 0.05}, "end_time = 0.05: must be 0.06 s, where the coupling in"),
    ({"first": "Solid"}, {}, 'must be the first of a serial-explicit scheme'),
    ({"scheme": "serial-implicit"}, {}, 'must be the first of a serial-explicit scheme'),
    ({"scheme": "parallel-implicit", "size": 0.02}, {}, "output.interval = 0.03: must be a multiple"),
    ({"scheme": "parallel-explicit", "size": "long"}, {}, "<time-window-size> must have a number"),
])
def test_what_does_not_fit_the_configuration_is_refused(tmp_path, written, change, words):
    end = change.pop("end_time", 0.06)
    with pytest.raises(InputError) as refusal:
        Simulation(scene(end, config(tmp_path, 0.06, **written), names=change))
    assert words in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2


@pytest.mark.parametrize(("text", "words"), [
    ("<precice-configuration>", "not valid XML"), ("<other/>", "must be a <precice-configuration>"),
    ("<precice-configuration><solver-interface/></precice-configuration>", "preCICE, version 3"),
])
def test_what_is_no_configuration_is_refused(tmp_path, text, words):
    path = tmp_path / "precice-config.xml"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        Simulation(scene(0.06, path))


def test_without_the_library_nothing_is_begun(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "precice", None)
    with pytest.raises(InputError) as refusal:
        snowmpm.run(scene(0.06, config(tmp_path, 0.06)), tmp_path / "run")
    assert "pip install pyprecice" in str(refusal.value) and len(str(refusal.value).splitlines()) == 2
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(("change", "words"), [
    ({"points": [FOOT]}, "structures.0.points"), ({"points": [FOOT, FOOT]}, "is where the point before it is"),
    ({"segments": 129}, "structures.0.segments"), ({"youngs_modulus": 1e9}, "structures.0.youngs_modulus"),
    ({"precice": {"file": "no.xml"}}, "no such file"),
])
def test_tables_that_cannot_be_are_refused(tmp_path, change, words):
    table = {"name": "plate", "points": [FOOT, PLATE["top"]], "width": 0.2,
             "precice": {"file": str(config(tmp_path, 1.0))}}
    text = {"name": "one", "dimension": 2, "end_time": 1.0, "solver": {"dx": 0.1},
            "materials": {"snow": {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}},
            "bodies": [{"name": "snow", "material": "snow", "shape": {"kind": "box", "min": [0, 0], "max": [1, 1]}}]}
    path = tmp_path / "scene.toml"
    path.write_text(table_text({**text, "structures": [table | change]}))
    with pytest.raises(InputError) as refusal:
        snowmpm.load_scene(path)
    assert words in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2
