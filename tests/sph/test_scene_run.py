"""A scene with method = "sph": from the file to the run file, and what is refused."""

from pathlib import Path

import pytest

import snowmpm
from snowmpm.errors import InputError

SCENE = Path(__file__).with_name("column.toml")


def test_a_scene_runs_to_its_end(tmp_path):
    run = snowmpm.run(snowmpm.load_scene(SCENE), tmp_path / "run")
    assert run.complete and len(run.frame(0)) == 8 * 6  # one particle a cell
    history = run.history
    assert history["momentum_residual"].max() < 1e-5
    # The column leans on the wall: the pressure of its weight at rest times K0, within the shake of the start
    pressure = 0.5 * 1600.0 * 9.81 * 0.3**2 * 0.3 / 0.7
    assert 0.3 * pressure < history["wall_force_x"][-1] < 1.5 * pressure
    assert {"velocity", "density", "p"} <= set(run.field_names)


def test_the_same_scene_settles(tmp_path):
    scene = snowmpm.load_scene(SCENE, {"initial.stress": "settle", "initial.tolerance": 0.02, "end_time": 1e-3,
                                       "domain.boundary": "stick"})
    simulation = snowmpm.Simulation(scene)
    assert simulation.time == 0.0 and simulation.max_speed < 0.1


@pytest.mark.parametrize(("changes", "words"), [
    ({"bodies.0.contact": "separate"}, "bodies.0.contact = 'separate': needs solver.method"),
    ({"solver.sph.smoothin": 1.2}, "solver.sph.smoothin = 1.2: unknown key; did you mean smoothing?"),
    ({"solver.sph.kernel": "gauss"}, 'solver.sph.kernel = "gauss": must be "wendland_c2"'),
    ({"solver.sph.artificial_stress": 0.3, "solver.sph.viscosity": 0.0}, "needs a viscosity above 0"),
    ({"solver.cfl": 1.0}, "unstable: must be at most")])
def test_what_is_refused(changes, words):
    with pytest.raises(InputError) as refusal:
        snowmpm.Simulation(snowmpm.load_scene(SCENE, changes))
    assert words in str(refusal.value) and len(str(refusal.value).splitlines()) <= 2
