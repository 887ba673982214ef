"""Snow cover as particles: balances, and the same flow whether it is laid ahead of it or was there from the start."""

import numpy as np
import pytest

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.components.erodible_snow.mpm import _PlanCells
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene
from tests.support.same_runs import assert_goes_on_alike

FLOW = {"kind": "mohr_coulomb", "density": 250.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3, "friction_angle": 22.0}
OLD = {**FLOW, "density": 200.0, "friction_angle": 25.0}
THICK = 0.6


def slope(cohesion=200.0, ahead=4.0, dimension=2, end_time=3.0, **changes):
    """A slab that slides off onto snow cover on a rough plane of 32 degrees; ahead [m], None: the cover is a body like
    others."""
    across = {} if dimension == 2 else {"y": [0.0, 1.0]}
    cover = {"name": "cover", "material": "old",
             "shape": {"kind": "layer", "bottom": 0.0, "top": THICK, "region": {"x": [8.5, 60.0], **across}}}
    low, high = ([-5.0, -60.0], [70.0, 10.0]) if dimension == 2 else ([-5.0, 0.0, -60.0], [70.0, 1.0, 10.0])
    tables = {"name": "slope", "dimension": dimension, "end_time": end_time, "output": {"interval": 0.5},
              "solver": {"dx": 0.2, "precision": "f64"},
              "domain": {"min": low, "max": high,
                         **({} if dimension == 2 else {"boundary": {"y_min": "slip", "y_max": "slip"}})},
              "terrain": {"kind": "plane", "angle": 32.0, "contact": "stick"},
              "materials": {"flow": FLOW, "old": {**OLD, "cohesion": cohesion}},
              "bodies": [{"name": "release", "material": "flow",
                          "shape": {"kind": "layer", "bottom": 0.0, "top": 1.2, "region": {"x": [0.0, 8.0], **across}}},
                         {**cover, **({} if ahead is None else {"laid_ahead": ahead})}],
              "initial": {"stress": "geostatic"}}
    return Scene.model_validate({**tables, **changes})


def at_end(scene):
    """Simulation at its end, mass of the cover further than a cell from where it lay [kg/m], 99.5 % of x of what has
    moved [m]; without the end of the slope, where a cover that was there from the start slumps."""
    simulation = snowmpm.Simulation(scene)
    while simulation.time < scene.end_time:
        simulation.step(until=scene.end_time)
    fields, first = simulation.particles, simulation.model.body_starts[1]
    number = fields["id"]
    start = simulation.model.population.positions[number]
    moved = np.linalg.norm(fields["position"] - start, axis=1) > scene.solver.dx
    moved &= start[:, 0] < 50.0
    return simulation, fields["mass"][moved & (number >= first)].sum(), np.quantile(fields["position"][moved, 0], 0.995)


@pytest.fixture(scope="module")
def slid():
    return at_end(slope())


def test_balances(slid):
    """Mass of the flow and of all particles, momentum to round-off; energy to 5 % of what was turned over."""
    simulation, taken, _ = slid
    row, start = simulation.audit(), snowmpm.Simulation(slope()).audit()
    assert row["mass"] == pytest.approx(start["mass"] + row["entrained_mass"] - row["removed_mass"], rel=1e-12)
    assert row["entrained_mass"] == pytest.approx(taken, rel=0.02)  # it is looked at every half cell
    assert row["entrained_mass"] > 0.2 * start["mass"]
    population, first = simulation.model.population, simulation.model.body_starts[1]
    there = simulation.particles["id"]
    laid = np.setdiff1d(there[there >= first], snowmpm.Simulation(slope()).particles["id"])
    assert row["cover_mass"] == pytest.approx(200.0 * population.volumes[laid].sum(), rel=1e-9)
    assert row["momentum_residual"] < 1e-12
    fallen = start["potential_energy"] - row["potential_energy"] + row["cover_energy"]
    assert abs(row["energy_remainder"]) < 0.05 * fallen


@pytest.mark.parametrize("ahead", [2.0, None], ids=["two metres ahead", "from the start"])
def test_the_flow_does_not_depend_on_when_the_cover_is_laid(ahead, slid):
    """Mass taken up and front, to 1 %, with a fraction of the particles. A band whose rim is not held gives way: 9 %
    more is then taken up with 4 m ahead, 16 % with 2 m."""
    simulation, taken, front = slid
    other, also_taken, also_front = at_end(slope(ahead=ahead))
    assert also_taken == pytest.approx(taken, rel=0.01) and also_front == pytest.approx(front, rel=0.01)
    assert (other.n_particles > simulation.n_particles) == (ahead is None)


def test_what_holds_is_left_and_what_does_not_is_taken():
    """Cohesion of the cover: the weaker, the more is taken up, the further it comes along with the flow."""
    taken = [at_end(slope(cohesion))[1] for cohesion in (100.0, 400.0, 5000.0)]
    assert taken[0] > 2.0 * taken[1] > 0.0 and taken[2] == 0.0


def test_maps_and_masses_leave_out_what_nothing_has_moved(tmp_path):
    """In 3-D: no depth, no deposit and no area where the cover lies as it was laid."""
    run = snowmpm.run(slope(cohesion=5000.0, dimension=3, end_time=1.0, solver={"dx": 0.25}), tmp_path / "run")
    cells = run.maps["deposit_depth"]
    x = cells.x0 + run.origin[0] + cells.cell * np.arange(cells.values.shape[1])
    front = 8.0 + run.history["front_distance"][-1]
    assert np.isnan(cells.values[:, x > front + 2.0]).all() and np.nanmax(cells.values) > 0.5
    release = run.history["mass"][0]
    numbers = run.summary["hazard"]
    assert numbers["release_mass"] == pytest.approx(release, rel=1e-3)
    assert numbers["deposit_mass"] == pytest.approx(run.history["mass"][-1], rel=1e-3)
    assert run.history["entrained_mass"][-1] < 0.05 * release
    assert numbers["release_area"] == pytest.approx(8.0, rel=0.02)  # of the release alone
    assert len(run.frame(-1).points) > len(run.frame(0).points)


def test_it_goes_on_to_the_bit(tmp_path):
    simulation = snowmpm.Simulation(slope(solver={"dx": 0.4}))
    while simulation.time < 1.5:
        simulation.step()
    before = simulation.n_particles
    other = assert_goes_on_alike(simulation, 2.5, tmp_path)
    assert other.n_particles > before


@pytest.mark.parametrize(("changes", "said"), [
    ({"velocity": [1.0, 0.0]}, "a cover lies at rest"), ({"laid_ahead": -1.0}, "greater than 0"),
    ({"laid_ahead": 0.79}, "at least 4 cells, 0.8 m")])
def test_wrong_covers(changes, said):
    tables = slope().model_dump(exclude_unset=True)
    tables["bodies"] = [tables["bodies"][0], {**tables["bodies"][1], **changes}]
    with pytest.raises((InputError, ValueError), match=said):
        snowmpm.Simulation(Scene.model_validate(tables))


@pytest.mark.parametrize(("changes", "said"), [
    ({"initial": {"stress": "settle"}}, "settle"), ({"solver": {"dx": 0.2, "method": "sph"}}, "mpm"),
    ({"gravity": {"ramp": 0.5}}, "gravity that changes"),
    ({"events": [{"kind": "remove", "body": "cover", "start": 0.5}]}, "must be a body without laid_ahead"),
    ({"bodies": [slope().bodies[1].model_dump(exclude_unset=True)]}, "needs a body without it")])
def test_scenes_that_it_does_not_go_with(changes, said):
    with pytest.raises((InputError, ValueError), match=said):
        snowmpm.Simulation(slope(**changes))


def test_a_cover_far_from_the_origin_needs_no_more_memory():
    """Coordinates of a country."""
    x, y = np.meshgrid(np.arange(0.0, 50.0, 0.5), np.arange(0.0, 20.0, 0.5))
    plan = np.column_stack([x.ravel(), y.ravel()])
    away = np.array([2.6e6, 1.2e6])
    near, far = (_PlanCells(plan + shift, np.full(len(plan), 4.0), 0.5) for shift in (0.0, away))
    assert (near._shape == far._shape).all()
    flow = np.array([[-2.0, 10.0]])
    np.testing.assert_array_equal(near.near(flow), far.near(flow + away))
    assert near.near(flow).sum() == (np.hypot(*(np.floor(plan) - [-2.0, 10.0]).T) <= 4.0).sum()


def test_what_check_says():
    advice = advise(slope(solver={"dx": 0.5}))
    assert "bodies.1.shape.top" in {caution.key for caution in advice.cautions}
