"""Components in a flow by finite volumes, through scenes: against columns, in balance, and to the bit."""

import numpy as np
import pytest

import snowmpm
from snowmpm.scenes import Scene
from tests.support.same_runs import assert_goes_on_alike

DENSITY, G, ANGLE = 200.0, 9.81, 30.0
COVER = {"rate": {"law": "rate", "growth_rate": 0.01}, "erosion_energy": {"law": "erosion_energy", "energy": 200.0},
         "strength": {"law": "strength", "strength": 250.0}}
MAST = {"name": "mast", "shape": {"kind": "cylinder", "base": [18.0, 10.0, -40.0], "axis": [0.0, 0.0, 1.0],
                                  "radius": 0.6, "height": 60.0}}
LATER = {"name": "two", "material": "snow", "start_time": 0.6,
         "shape": {"kind": "layer", "top": 0.5, "region": {"x": [24.0, 30.0], "y": [6.0, 14.0]}}}


def scene(scheme="volumes", more=(), obstacles=(), **terrain):
    """A slab at the head of a plane."""
    return Scene.model_validate({
        "name": "slab", "dimension": 3, "end_time": 2.5, "output": {"interval": 0.5, "map_cell": 1.0},
        "solver": {"method": "depth", "dx": 0.5, "precision": "f64", "depth": {"scheme": scheme}},
        "domain": {"min": [0.0, 0.0, -40.0], "max": [60.0, 20.0, 20.0]},
        "terrain": {"kind": "plane", "angle": ANGLE, "friction": {"law": "voellmy", "mu": 0.2, "xi": 800.0}, **terrain},
        "materials": {"snow": {"kind": "elastic", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3}},
        "bodies": [{"name": "one", "material": "snow",
                    "shape": {"kind": "layer", "top": 1.0, "region": {"x": [3.0, 15.0], "y": [4.0, 16.0]}}}, *more],
        "obstacles": list(obstacles)})


def cover(law, thickness=0.3):
    return {**COVER[law], "thickness": thickness, "density": 150.0}


def balanced(run):
    """Mass, less what was taken up, stays; momentum is that of weight, ground and what is gone."""
    history = run.history
    gone = history["removed_mass"] + history.get("laid_mass", 0.0)
    mass = history["mass"] + gone - history.get("entrained_mass", 0.0)
    np.testing.assert_allclose(mass, mass[0], rtol=1e-9)
    assert np.abs(history["momentum_residual"]).max() < 1e-6
    return history


@pytest.mark.parametrize("law", COVER)
def test_it_takes_up_what_columns_do(law, tmp_path):
    """To 4 % of the mass, and of the speed; where the shear stress is near the strength of the cover, to 20 %."""
    found = {scheme: balanced(snowmpm.run(scene(scheme, entrainment=cover(law, 0.05)), tmp_path / scheme))
             for scheme in ("columns", "volumes")}
    taken = {scheme: history["entrained_mass"][-1] for scheme, history in found.items()}
    assert taken["volumes"] > 0.03 * found["volumes"]["mass"][0]
    assert taken["volumes"] == pytest.approx(taken["columns"], rel=0.2 if law == "strength" else 0.04)
    speed = [history["total_momentum"][-1] / history["mass"][-1] for history in found.values()]
    assert speed[1] == pytest.approx(speed[0], rel=0.04)


@pytest.mark.parametrize("side", ["slip", "symmetric", "periodic"])
@pytest.mark.parametrize("law", [None, "rate"])
def test_snow_along_a_side_is_counted_once(side, law):
    """A slab from side to side. Cells beyond a side are images of those within: they take nothing up, and their
    friction is no work of this flow. Mass to 1e-9; work of friction that of columns to 2 %. Energy to 2 % of that work,
    and 5 % with a cover, into whose place the snow above sinks."""
    def rows(scheme):
        cut = scene(scheme, **({"entrainment": cover(law)} if law else {})).model_dump(exclude_unset=True)
        cut["domain"] = {"min": [0.0, 6.0, -40.0], "max": [60.0, 8.0, 20.0],
                         "boundary": {"y_min": side, "y_max": side}}
        cut["bodies"][0]["shape"] = {"kind": "layer", "top": 1.0, "region": {"x": [3.0, 15.0], "y": [6.0, 8.0]}}
        simulation = snowmpm.Simulation(Scene.model_validate(cut))
        first = simulation.audit()
        while simulation.time < 1.5:
            simulation.step(until=1.5)
        return first, simulation.audit()

    (first, row), (_, columns) = rows("volumes"), rows("columns")
    assert row["mass"] + row["removed_mass"] == pytest.approx(first["mass"] + row["entrained_mass"], rel=1e-9)
    assert row["contact_work"] == pytest.approx(columns["contact_work"], rel=0.02)
    assert abs(row["energy_remainder"]) < (0.05 if law else 0.02) * row["contact_work"]
    assert (row["entrained_mass"] > 0.02 * first["mass"]) == (law is not None)


def test_a_cover_is_taken_up_once(tmp_path):
    """All of it where the flow is strong, and the ground sinks by its thickness."""
    simulation = snowmpm.Simulation(scene(entrainment=cover("strength", 0.2)))
    solver = simulation.solver
    before = solver.heights.copy()
    while simulation.time < 2.0:
        simulation.step(2.0)
    sunk = (before - solver.heights)[4:-4, 4:-4]
    assert sunk.max() == pytest.approx(0.2 / np.cos(np.radians(ANGLE)), rel=1e-6)
    assert sunk.sum() * 0.25 * 150.0 == pytest.approx(solver.particles.removed["entrained"], rel=1e-9)


def test_a_mast_feels_what_it_does_in_columns(tmp_path):
    """Its largest load to 10 %."""
    forces = [snowmpm.run(scene(scheme, obstacles=[MAST]), tmp_path / scheme).history["mast_force_x"]
              for scheme in ("columns", "volumes")]
    columns, volumes = (np.abs(force).max() for force in forces)
    assert volumes == pytest.approx(columns, rel=0.1) and volumes > 0.0


def test_all_of_them_go_on_to_the_bit(tmp_path):
    wood = {"name": "wood", "region": {"x": [16.0, 40.0], "y": [0.0, 10.0]}, "drag": 0.02, "detrainment": 20.0}
    made = scene(more=[LATER], obstacles=[MAST], entrainment=cover("rate"), forest=[wood],
                 deposition={"law": "stopped", "time": 0.5})
    balanced(snowmpm.run(made, tmp_path / "run"))
    for time in (0.3, 1.2):
        simulation = snowmpm.Simulation(made)
        while simulation.time < time:
            simulation.step(time)
        assert_goes_on_alike(simulation, 1.9, tmp_path)


def test_a_later_release_is_let_go_in_time():
    """It is in the mass from the start, moves at its time, and starts as a block does."""
    simulation = snowmpm.Simulation(scene(more=[LATER]))
    cells, whole = simulation.solver.particles, simulation.audit()["mass"]
    assert len(cells.later) == 1 and cells.mass == pytest.approx(whole, rel=1e-12)
    while simulation.time < 0.6 - 1e-9:
        simulation.step(0.6)
    assert not cells.later and simulation.audit()["mass"] == pytest.approx(whole, rel=1e-8)
    start = simulation.time
    while simulation.time < start + 0.1 - 1e-9:
        simulation.step(start + 0.1)
    x = simulation.particles["position"][:, 0]
    speed = np.linalg.norm(simulation.particles["velocity"], axis=1)[np.abs(x - 27.0) < 0.6]
    drive = np.sin(np.radians(ANGLE)) - 0.2 * np.cos(np.radians(ANGLE))
    assert np.median(speed) == pytest.approx(G * drive * (simulation.time - start), rel=0.03)
