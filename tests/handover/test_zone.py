"""A region in three dimensions within a flow of columns: what goes across its border, and what is kept."""

import json
import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.errors import InputError, SimulationError
from snowmpm.render.run_film import view_of
from snowmpm.scenes import load_scene
from snowmpm.setup.build import build
from tests.handover.slab_in_zone import WALL, level, zoned
from tests.support.same_runs import assert_same, assert_same_runs, run_with_signal
from tests.support.thread_counts import with_one_and_two_threads

LATE = 0.9
"""Time [s] at which the slab is in the zone, at the border and before it."""
NARROW = {"x": [16.0, 21.0], "y": [4.0, 16.0]}
"""A region that the slab flows into and out of."""


def advanced(one, time):
    simulation = snowmpm.Simulation(one)
    while simulation.time < time - 1e-9:
        simulation.step(until=time)
    return simulation


def sums(simulation):
    """Mass, and momentum in plan."""
    fields = simulation.particles
    return np.array([fields["mass"].sum(), *(fields["mass"] @ fields["velocity"][:, :2])])


@pytest.fixture(scope="module")
def through():
    """A simulation of double precision just before snow goes both into its region and out of it."""
    precise = {"method": "depth", "dx": 1.0, "precision": "f64"}
    simulation = advanced(zoned({**NARROW, "x": [15.0, 17.0]}, solver=precise, terrain={
        "kind": "plane", "angle": 30.0, "friction": 0.0, "contact": "separate"}, end_time=2.4), LATE)
    solver = simulation.solver
    while not (solver.border.left(solver.inner.particles.snapshot().plan()).any()
               and solver.border.entered(solver.outer.particles.snapshot().plan()).any()):
        simulation.step()
    return simulation


def test_mass_and_momentum_across_the_border(through):
    """To round-off, in both directions; numbers stay unique, and snow keeps its body; the rest is booked."""
    solver, before, rows = through.solver, sums(through), [through.audit()]
    counts = [(solver.outer.particles.count, solver.inner.particles.count)]
    for cross in (solver._leave, solver._enter):
        cross()
        rows.append(through.audit())
        counts.append((solver.outer.particles.count, solver.inner.particles.count))
        np.testing.assert_allclose(sums(through), before, rtol=1e-12, atol=1e-12 * before[0])
        assert solver.particles.removed["mass"] == pytest.approx(0.0, abs=1e-9 * before[0])
        fields = through.particles
        assert len(np.unique(fields["id"])) == len(fields["id"]) and (fields["body"] == 0).all()
        assert solver.particles.mass == pytest.approx(before[0], rel=1e-12)
    assert counts[1][0] > counts[0][0] and counts[1][1] < counts[0][1]
    assert counts[2][0] < counts[1][0] and counts[2][1] > counts[1][1]
    kinetic = rows[0]["kinetic_energy"]
    for row in rows:
        assert row["momentum_residual"] < 1e-12
        assert row["energy_remainder"] == pytest.approx(rows[0]["energy_remainder"], abs=1e-9 * kinetic)
    assert np.diff([row["handover_energy"] for row in rows]).all()


def test_snow_keeps_where_it_came_from(through):
    """Origins are those of the slab, and their mean over the mass is its centre."""
    fields, solver = through.particles, through.solver
    origins = solver.particles.origins[fields["id"]]
    start = through.model.population
    assert (origins >= start.positions.min(axis=0) - 1e-9).all()
    assert (origins <= start.positions.max(axis=0) + 1e-9).all()
    np.testing.assert_allclose(fields["mass"] @ origins / fields["mass"].sum(),
                               start.volumes @ start.positions / start.volumes.sum(), rtol=1e-9)


def test_a_lake_across_the_border_stays():
    """Level snow at rest, half of it in three dimensions. Seen after 0.4 s: 0.04 m/s on average, 0.28 at most, beside
    3.1 m/s of its waves. Without the pressure of each on the other, columns would run into the particles at 2.9 m/s."""
    simulation = advanced(level(0.0, {"x": [10.0, 20.0], "y": [0.0, 6.0]}), 0.4)
    fields = simulation.particles
    speed = np.linalg.norm(fields["velocity"], axis=1)
    assert np.sqrt(fields["mass"] @ speed**2 / fields["mass"].sum()) < 0.1 and speed.max() < 0.4
    for method in (simulation.solver.outer, simulation.solver.inner):
        assert method.particles.mass == pytest.approx(0.5 * sums(simulation)[0], rel=1e-6)


def test_a_block_slides_across_the_border():
    """Without friction its momentum stays. Seen after 1 s at 8 m/s: 0.3 % more; its energy 0.7 % more."""
    simulation = advanced(level(8.0, {"x": [16.0, 40.0], "y": [0.0, 6.0]}), 1.0)
    row, mass = simulation.audit(), sums(simulation)[0]
    assert simulation.solver.inner.particles.count > 1000 and simulation.solver.outer.particles.count > 50
    assert sums(simulation)[1] == pytest.approx(8.0 * mass, rel=0.006)
    assert abs(row["energy_remainder"]) < 0.015 * 32.0 * mass
    assert row["momentum_residual"] < 1e-6


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """(scene, folder of its run): through a region, around a post, with maps."""
    post = {"name": "post", "contact": "separate", "shape": {
        "kind": "box", "min": [19.5, 9.0, -16.0], "max": [20.5, 11.0, -6.0]}}
    sign = {"name": "sign", "shape": {"kind": "box", "min": [12.0, 9.0, -9.0], "max": [12.5, 11.0, 0.0]}}
    folder = tmp_path_factory.mktemp("zone")
    one = zoned(NARROW, {"solver": {"dx": 0.8}}, obstacles=[post, sign], end_time=2.2)
    snowmpm.run(one, folder)
    return one, folder


def test_one_run(whole):
    """One history, one set of maps, one film; the loads of both methods."""
    run = snowmpm.Run(whole[1])
    history = run.history
    np.testing.assert_allclose(history["mass"] + history["removed_mass"], history["mass"][0], rtol=1e-6)
    assert history["momentum_residual"].max() < 1e-6
    assert history["handover_energy"][0] == 0.0 and history["handover_energy"][-1] != 0.0
    assert history["post_force_x"][-1] > 0.0 and np.nan_to_num(history["sign_force_x"]).max() > 0.0
    # The front never goes back: maps and origins hold for both
    assert (np.diff(history["front"]) > 0.0)[4:].all()
    depth = np.nan_to_num(run.maps["peak_depth"].values)
    assert depth.shape == run.maps["arrival_time"].values.shape and depth.max() < 3.0
    arrival = run.maps["arrival_time"].values
    assert (np.diff(np.nanmin(arrival[:, 18:23], axis=0)) >= 0.0).all()
    frame = run.frame(len(run) - 1)
    beyond = frame.points[:, 0] > 23.6  # columns again
    assert beyond.sum() > 5 and (frame.fields["depth"][beyond] > 0.0).all()
    assert (frame.fields["depth"] > 0.0).any() and (frame.fields["depth"] == 0.0).any()
    assert run.provenance["zone_spacing"] == pytest.approx(0.4)
    picture = view_of(run, (320, 180)).picture(len(run) - 1)  # of balls of two sizes
    assert picture.shape == (180, 320, 3) and picture.std() > 0.0
    assert run.summary["particle_steps"] > 20 * run.summary["particles"]


def test_restored_to_the_bit(through):
    """Another simulation goes on from its state as it does itself, while snow enters and leaves the zone."""
    other = snowmpm.Simulation(through.scene)
    other.restore(through.state())
    for _ in range(3):
        for one in (through, other):
            one.step()
    assert_same(*(one.solver.state() for one in (through, other)))
    assert through.audit() == other.audit()


@pytest.mark.slow
def test_resumed_to_the_bit(whole, tmp_path):
    """Stopped when the first snow has entered the zone, and while snow enters and leaves it."""
    one, folder = whole
    for i, time in enumerate((0.01, 2.1)):
        with pytest.raises(KeyboardInterrupt):
            run_with_signal(one, tmp_path, signal.SIGTERM, time, resume=i > 0)
    run = snowmpm.run(one, tmp_path, resume=True)
    assert len(run.provenance["resumed"]) == 2
    assert_same_runs(folder, tmp_path)
    for name, raster in snowmpm.Run(folder).maps.items():
        assert_same(raster.values, run.maps[name].values, name)


@pytest.mark.slow
def test_one_and_two_threads_leave_the_same_bits():
    one, two = with_one_and_two_threads("tests.handover.zone_threads")
    assert one["hash"] == two["hash"] and one["particles"] > 1000


BINGHAM = {"law": "bingham", "yield_stress": 1e3, "viscosity": 10.0}


@pytest.mark.parametrize(("changes", "says"), [
    ({"zone": {"solver": {"dx": 0.5, "method": "sph"}}}, "zone.solver.method = 'sph': must be \"mpm\""),
    ({"zone": {"solver": {"dx": 0.5, "method": "depth"}}}, "zone.solver.method = 'depth': must be \"mpm\""),
    ({"solver": {"method": "mpm", "dx": 0.5}}, "solver.method = 'mpm': must be \"depth\" around a zone"),
    ({"region": {"x": [50.0, 60.0]}}, "zone.region: holds the middle of no cell"),
    ({"terrain": {"kind": "plane", "angle": 30.0, "contact": "separate", "friction": 0.3, "deposition": {"time": 1.0}}},
     "terrain.deposition.law = .*zone computes with it"),
    ({"domain": {"min": [0.0, 0.0, -30.0], "max": [40.0, 20.0, 10.0],
                 "boundary": {"y_min": "periodic", "y_max": "periodic"}}}, "does not go with zone"),
    ({"obstacles": [{**WALL, "shape": {**WALL["shape"], "min": [17.0, 4.0, -24.0]}}]},
     r"obstacles.0 \(wall\): stands on the border of zone.region"),
])
def test_what_cannot_be(changes, says):
    with pytest.raises(InputError, match=says) as told:
        build(zoned(**changes)).solver()
    assert len(str(told.value).splitlines()) <= 2


def test_a_switch_beside_a_zone_is_refused():
    one = zoned()
    switch = {"to": "mpm", "when": "t > 1", "solver": {"dx": 0.5}}
    both = type(one).model_validate({**one.model_dump(exclude_none=True, by_alias=True), "switch": [switch]})
    with pytest.raises(InputError, match=r"switch.0.to = 'mpm': does not go with zone"):
        build(both)


@pytest.mark.parametrize(("zone", "says"), [
    ({"solver": {"dx": 0.5, "dt": 1e-3}}, "zone.solver.dt = 0.001: is chosen as the flow asks"),
    ({"solver": {}}, "zone.solver.dx"), ({"regions": {}}, "zone.regions"),
])
def test_what_is_not_a_zone(zone, says, tmp_path):
    (tmp_path / "slab.toml").write_text(zoned().to_toml())
    with pytest.raises(InputError, match=says):
        load_scene(tmp_path / "slab.toml", {f"zone.{name}": value for name, value in zone.items()})


def test_a_scene_with_a_zone_comes_back_from_its_text(tmp_path):
    one = zoned(solver={"method": "depth", "dx": 1.0, "precision": "f64"})
    (tmp_path / "one.toml").write_text(one.to_toml())
    again = load_scene(tmp_path / "one.toml")
    assert again.zone == one.zone and again.zone.solver.method == "mpm" and again.zone.solver.precision == "f64"
    assert "zone" not in one.model_copy(update={"zone": None}).to_toml()


def test_an_obstacle_at_the_border():
    """Snow that becomes particles inside an obstacle ends the run; `check` has warned of it."""
    near = {**WALL, "shape": {**WALL["shape"], "min": [18.1, 4.0, -24.0], "max": [19.0, 16.0, -4.0]}}
    one = zoned(obstacles=[near], end_time=2.0)
    assert any(found.key == "zone.region" and "less than 6 cells" in found.says for found in advise(one).cautions)
    with pytest.raises(SimulationError, match="snow that enters the zone lies inside an obstacle"):
        advanced(one, 2.0)


def test_check_counts_the_zone():
    """Particles for all of the snow, and a share of the time; a wall 12 m from the border is far enough."""
    advice = advise(zoned(obstacles=[WALL], end_time=4.0))
    assert "by MPM, at most" in advice.facts["zone"]
    later = next(payment for payment in advice.payments if payment.what == "then MPM")
    assert int(later.detail.split()[0]) == pytest.approx(8.0 * 96.0 / (0.5**3 * np.cos(np.radians(30.0))), rel=0.15)
    assert sum(payment.share or 0.0 for payment in advice.payments) == pytest.approx(1.0)
    assert not [found for found in advice.cautions if found.key == "zone.region"]
    assert all(found.key.startswith("zone.solver") for found in advice.cautions if "solver" in found.key)
    json.dumps(advice.record())
