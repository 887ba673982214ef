"""A saw test by one step at rest: the elastic column of `study.problems.elastic_saw_test`, cut, in its balance."""

from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from snowmpm.study.problems.elastic_saw_test import LENGTH, WEAK_LAYER


def at_rest(cut, slope_angle=0.0, dx=0.025, follow=None):
    """Potential energy Pi [J/m] and deflection of the free end [m]. follow: is given the solver before its step."""
    one = Simulation(load_scene("pst_2d", {
        "solver.method": "implicit", "solver.implicit.time": "quasi_static", "solver.implicit.dt": 0.1,
        "solver.gradient": "shape", "solver.precision": "f64", "solver.dx": dx, "materials.weak_layer": WEAK_LAYER,
        "initial.stress": "geostatic", "saw_test.length": LENGTH, "saw_test.notch": cut, "saw_test.saw_length": cut,
        "saw_test.slope_angle": slope_angle, "saw_test.ends": "normal",
        "saw_test.weak_layer": {"material": "weak_layer", "thickness": 0.05}}))
    if follow:
        follow(one.solver)
    one.step()
    assert one.solver.steps == 1 and one.solver.passed.parts == 1
    particles = one.particles
    moved = particles["position"] - one.model.population.positions[particles["id"]]
    elastic = one.solver.materials.elastic_energy(particles["material"], particles.kirchhoff(), particles.state(),
                                                  particles["volume"] / particles["J"])
    settled = one.crack.values()["settlement"][-1].astype(float)
    return elastic - float(particles["mass"] @ (moved @ one.solver.gravity)), 1.5 * settled[0] - 0.5 * settled[1]
