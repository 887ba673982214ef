"""Runs of two methods, one after the other: one folder, one history, one set of maps, one film; resumed to the bit."""

import signal

import numpy as np
import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.render.view import particle_spacing
from snowmpm.setup.build import build
from tests.handover.slab_in_two_methods import scene
from tests.support.same_runs import assert_same, assert_same_runs, run_with_signal


@pytest.fixture(scope="module", params=[("mpm", "depth"), ("depth", "mpm")], ids="-".join)
def both(request, tmp_path_factory):
    """(scene, folder of its run) from the first method to the second."""
    one, folder = scene(*request.param), tmp_path_factory.mktemp("whole")
    snowmpm.run(one, folder)
    return one, folder


def test_resumed_to_the_bit(both, tmp_path):
    """Stopped before the hand-over, between it and the next frame, and after: the same end, frames, history, maps."""
    one, whole = both
    for i, time in enumerate((0.3, 0.61, 0.9)):
        with pytest.raises(KeyboardInterrupt):
            run_with_signal(one, tmp_path, signal.SIGTERM, time, resume=i > 0)
    run = snowmpm.run(one, tmp_path, resume=True)
    assert len(run.provenance["resumed"]) == 3
    assert_same_runs(whole, tmp_path)
    for name, raster in snowmpm.Run(whole).maps.items():
        assert_same(raster.values, run.maps[name].values, name)
    assert run.provenance["methods"] == snowmpm.Run(whole).provenance["methods"]


def test_one_run(both):
    """History and maps go on; the run says which method was at work when."""
    one, folder = both
    run = snowmpm.Run(folder)
    history, records = run.history, run.provenance["methods"]
    assert history["method"].tolist() == [0, 0, 0, 0, 1, 1, 1]
    assert [record["method"] for record in records] == [one.solver.method, one.switch[0].to]
    assert records[1]["time"] == pytest.approx(0.6)
    assert run.summary["methods"] == records
    np.testing.assert_allclose(history["mass"], history["mass"][0], rtol=1e-6)
    assert np.abs(history["momentum_residual"]).max() < 1e-6
    assert (np.diff(history["contact_work"]) >= 0.0).all() and (np.diff(history["steps"]) > 0).all()
    along = history["momentum_x"]  # a block on a plane: in proportion to time, to what its edges do
    np.testing.assert_allclose(along[1:], along[3] / 0.6 * history["time"][1:], rtol=0.1)
    kinds = [name for name in records[1] if name.endswith("_energy")]
    assert history["handover_energy"][-1] == pytest.approx(sum(records[1][name] for name in kinds))
    # Maps: peaks at least as deep as at the start, and the arrival after the hand-over where only it came
    depth, late = run.maps["peak_depth"].values, run.maps["arrival_time"].values
    release = run.maps["release_depth"].values
    assert (np.nan_to_num(depth) >= np.nan_to_num(release) - 1e-12).all()
    assert np.nanmin(late) == 0.0 and 0.6 < np.nanmax(late) <= np.float32(1.2)
    spacings = [particle_spacing(run, time) for time in (0.0, 0.6, 0.8)]
    assert spacings == [records[0]["particle_spacing"]] * 2 + [records[1]["particle_spacing"]]


def test_no_scene_starts_from_what_was_handed_over(both):
    one, folder = both
    other = one.model_dump(by_alias=True, exclude_none=True, exclude={"switch"})
    with pytest.raises(InputError, match="handed over to another method"):
        build(type(one).model_validate({**other, "initial": {"from": str(folder)}}))


def test_when_the_slab_flows():
    """Half of the mass faster than 2 m/s: on 30 degrees with mu = 0.3 after 0.85 s, and not before."""
    simulation = snowmpm.Simulation(scene(when="flowing", switch={"speed": 2.0}))
    while simulation.relay.index == 0:
        fields = simulation.particles
        moving = fields["mass"] @ (np.linalg.norm(fields["velocity"], axis=1) > 2.0) / fields["mass"].sum()
        simulation.step()
    assert simulation.relay.records[1]["time"] == pytest.approx(2.0 / (9.81 * (0.5 - 0.3 * np.cos(np.radians(30.0)))),
                                                                rel=0.1)
    assert moving >= 0.5


def test_when_the_weak_layer_is_broken():
    """A saw takes the bonds of two thirds of a weak layer at 0.05 s; before, it has all of them."""
    snow = {"youngs_modulus": 1e6, "poisson_ratio": 0.3, "cohesion": 0.3, "hardening": 1.0, "critical_slope": 0.8}
    laws = {"slab": {"kind": "cohesive_cam_clay", "density": 250.0, "p0": 3e4, **snow},
            "weak": {"kind": "anticrack_cam_clay", "density": 150.0, "p0": 1.2e4, "softening": 1.8, **snow}}
    shape = {"kind": "layer", "region": {"x": [5.0, 11.0], "y": [8.0, 12.0]}}
    bodies = [{"name": name, "material": name, "shape": {**shape, "bottom": bottom, "top": bottom + 0.5}}
              for name, bottom in (("weak", 0.0), ("slab", 0.5))]
    saw = {"kind": "cut", "body": "weak", "start": 0.05, "path": [[8.0, 8.0, -5.0], [8.0, 12.0, -5.0]], "width": 4.0}
    simulation = snowmpm.Simulation(scene(when="broken", switch={"share": 0.6}, materials=laws, bodies=bodies,
                                          events=[saw]))
    broken = []
    while simulation.relay.index == 0 and simulation.time < 0.2:
        broken.append((simulation.time, simulation.relay.next.share(simulation.particles)))
        simulation.step()
    assert max(share for time, share in broken if time < 0.05) == 0.0
    assert broken[-1][1] == pytest.approx(2.0 / 3.0, abs=0.02)
    assert simulation.relay.index == 1 and 0.05 < simulation.relay.records[1]["time"] < 0.2


def test_when_it_reaches_a_region():
    """Columns become particles as soon as one is inside."""
    region = {"x": [18.0, 30.0], "y": [8.0, 12.0]}
    simulation = snowmpm.Simulation(scene("depth", "mpm", when="reached", switch={"region": region}))
    furthest = 0.0
    while simulation.relay.index == 0:
        furthest = simulation.particles["position"][:, 0].max()
        simulation.step()
    assert 18.0 <= furthest < 19.0
    assert simulation.solver.particles.count > 3000


def test_snow_at_rest_stays(tmp_path):
    """A second slab on rough ground that friction holds: it is left lying, and counted."""
    still = {"name": "still", "material": "snow", "shape": {
        "kind": "layer", "top": 1.0, "region": {"x": [25.0, 29.0], "y": [8.0, 12.0]}}}
    changes = {"terrain": {"kind": "profile", "points": [[0.0, 10.0], [20.0, -10.0], [40.0, -10.0]], "friction": 0.3,
                           "contact": "separate"}, "domain": {"min": [0.0, 0.0, -14.0], "max": [40.0, 20.0, 12.0]}}
    one = scene(end_time=0.8, switch={"at_rest": "stays"}, **changes)
    both = one.model_copy(update={"bodies": (*one.bodies, type(one.bodies[0]).model_validate(still))})
    history = snowmpm.run(both, tmp_path).history
    share = history["taken_mass"][-1] / history["mass"][0]
    assert share == pytest.approx(16.0 / (16.0 + 96.0 * np.sqrt(2.0)), rel=0.05)
    np.testing.assert_allclose(history["mass"] + history["removed_mass"], history["mass"][0], rtol=1e-6)
    assert history["momentum_residual"][-1] < 1e-6
