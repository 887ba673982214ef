"""A run that goes unstable says which entry of the atlas of failures it looks like."""

import pytest

from snowmpm import Simulation, components
from snowmpm.errors import SimulationError
from snowmpm.running.failure import diagnose
from snowmpm.scenes.schema import Scene
from snowmpm.study.problems.soaked_column import soaked_column


def block(**solver):
    """A soft elastic block above a floor."""
    law = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.3}
    return Scene.model_validate({
        "name": "block", "dimension": 2, "end_time": 1.0, "gravity": 0.0,
        "solver": {"dx": 0.1, "precision": "f64", **solver},
        "domain": {"min": [-4.0, 0.0], "max": [4.0, 4.0], "boundary": {"z_min": "stick"}}, "materials": {"snow": law},
        "bodies": [{"name": "block", "material": "snow", "velocity": [0.0, -3.0],
                    "shape": {"kind": "box", "min": [0.0, 0.2], "max": [0.4, 0.6]}}]})


def failure(simulation, factor):
    """Message of a run whose steps are `factor` times the stable ones."""
    stable = simulation.solver.stable_dt
    simulation.solver.stable_dt = lambda: (factor * stable()[0], "elastic")
    with pytest.raises(SimulationError) as error:
        for _ in range(2000):
            simulation.step()
    assert str(error.value).count("\n") == 1
    return str(error.value)


def test_a_step_beyond_the_elastic_limit():
    said = failure(Simulation(block()), 3.5)
    assert "no longer finite" in said
    assert 'looks like "' in said and "of the atlas of failures" in said and "cured by: " in said
    assert any(f'"{name}"' in said for name in ("long_step_lone_grain", "deformation_step", "crossing_step"))


def test_a_step_beyond_undrained_waves():
    """Of pore water with the explicit split alone: the other one does not follow these waves."""
    simulation = soaked_column(split="explicit", surface="sealed", pressure=9e3)
    dt, more = simulation.solver.critical_dt()[0], components.symptoms(simulation.scene)
    said = diagnose(simulation.scene.solver, simulation.solver, 4.0 * dt, more)
    assert 'looks like "undrained_step"' in said and "semi_implicit" in said
    assert "undrained_step" not in str(diagnose(simulation.scene.solver, simulation.solver, 2.0 * dt, more))
    other = soaked_column(surface="sealed", pressure=9e3)
    assert "undrained_step" not in str(diagnose(other.scene.solver, other.solver, 4.0 * dt, more))


@pytest.mark.parametrize(("extremes", "entry"), [
    (dict(speed=1e4, gradient=0.0), "crossing_step"), (dict(speed=1.0, gradient=2e3), "deformation_step")])
def test_what_the_last_good_step_did_decides(extremes, entry):
    simulation = Simulation(block())
    simulation.step()
    solver = simulation.solver
    solver.extremes = type(solver.extremes)(**extremes)
    assert f'"{entry}"' in diagnose(simulation.scene.solver, solver, 1e-3)


def test_noise_of_flip_is_looked_for_last():
    simulation = Simulation(block(transfer="flip", flip_ratio=1.0))
    simulation.step()
    assert '"null_space_noise"' in diagnose(simulation.scene.solver, simulation.solver, 1e-4)


def test_nothing_is_made_up():
    simulation = Simulation(block())
    simulation.step()
    assert diagnose(simulation.scene.solver, simulation.solver, 1e-4) is None
