"""What cannot be handed over is refused in a line or two before anything runs."""

import pytest

import snowmpm
from snowmpm.advice.affordability import refuse_unaffordable
from snowmpm.advice.report import advise
from snowmpm.errors import InputError, SimulationError
from snowmpm.scenes import load_scene
from snowmpm.setup.build import build
from tests.handover.slab_in_two_methods import scene

FORCE = {"kind": "acceleration", "value": [0.0, 0.0, 1.0]}
SKIER = {"kind": "load", "body": "slab", "start": 0.1, "centre": [11.0, 10.0, -6.0], "radius": 1.0,
         "force": [0.0, 0.0, -800.0]}


@pytest.mark.parametrize(("changes", "says"), [
    ({"terrain": None, "initial": {}, "bodies": [{"name": "slab", "material": "snow", "shape": {
        "kind": "box", "min": [5.0, 5.0, 0.0], "max": [9.0, 9.0, 1.0]}}]}, "switch.0.to = 'depth': needs a terrain"),
    ({"forces": [FORCE]}, "forces.0.kind = 'acceleration': needs solver.method = .*switch.0 hands over to it"),
    ({"events": [SKIER]}, "events.0.kind = 'load': needs .*switch.0 hands over"),
    ({"gravity": [1.0, 0.0, -9.7]}, "needs gravity that points down"),
    ({"switch": {"when": "broken"}}, "needs a material with bonds"),
    ({"first": "depth", "then": "depth"}, "must be \"mpm\" or \"sph\" after \"depth\""),
    ({"then": "sph"}, "must be \"depth\" after \"mpm\""),
    ({"first": "depth", "then": "mpm", "terrain": {
        "kind": "plane", "angle": 30.0, "contact": "separate", "friction": 0.3, "entrainment": {
            "law": "rate", "growth_rate": 0.001, "thickness": 0.5, "density": 150.0}}},
     "terrain.entrainment.law = .rate.: does not go with switch"),
    ({"first": "depth", "then": "sph", "terrain": {"kind": "plane", "angle": 30.0, "contact": "separate", "friction": {
        "law": "bingham", "yield_stress": 1e3, "viscosity": 10.0}}},
     "friction.law = 'bingham': .*switch.0 hands over to it"),
    ({"domain": {"min": [0.0, 0.0, -30.0], "max": [40.0, 20.0, 10.0],
                 "boundary": {"y_min": "periodic", "y_max": "periodic"}}}, "not periodic"),
])
def test_what_cannot_be(changes, says):
    with pytest.raises(InputError, match=says) as told:
        build(scene(**changes))
    assert len(str(told.value).splitlines()) <= 2


@pytest.mark.parametrize(("switch", "says"), [
    ({"when": "later"}, "when = .later.: must be \"t > \""), ({"when": "t > -1"}, "must be \"t > \""),
    ({"when": "reached"}, "belong together"), ({"region": {"x": [0.0, 1.0]}}, "belong together"),
    ({"to": "lattice"}, 'must be "mpm", "sph" or "depth"'), ({"solver": {}}, "solver.dx"),
    ({"solver": {"method": "sph", "dx": 1.0}}, "leave it out"), ({"share": 1.5}, "share = 1.5"),
    ({"friction": {"card": "no_such"}}, "no such friction card"),
])
def test_what_is_not_a_switch(switch, says, tmp_path):
    text = scene().to_toml()
    file = tmp_path / "slab.toml"
    file.write_text(text[: text.index("[[switch]]")] + '[picture]\ncamera = "auto"\n')
    given = [{"to": "depth", "when": "flowing", "solver": {"dx": 1.0}, **switch}]
    with pytest.raises(InputError, match=says):
        load_scene(file, {"switch": given})


def test_a_scene_with_switches_comes_back_from_its_text(tmp_path):
    """Resolved and read again: the same, with the numbers of a friction card; a scene without has no word of it."""
    one = scene(switch={"friction": {"card": "voellmy_buser_frutiger"}})
    (tmp_path / "one.toml").write_text(one.to_toml())
    again = load_scene(tmp_path / "one.toml")
    assert again.switch == one.switch and again.switch[0].friction.xi > 0.0
    assert "switch" not in one.model_copy(update={"switch": ()}).to_toml()


def test_too_late(tmp_path):
    """Snow that lies in an obstacle when its method takes over."""
    wall = {"name": "wall", "contact": "separate", "shape": {
        "kind": "box", "min": [16.0, 6.0, -20.0], "max": [18.0, 14.0, 0.0]}}
    one = scene("depth", "mpm", when="t > 0.8", obstacles=[wall])
    with pytest.raises(SimulationError, match="comes too late: snow lies inside an obstacle"):
        snowmpm.run(one, tmp_path)


@pytest.mark.parametrize("order", [("mpm", "depth"), ("depth", "mpm")])
def test_check_forecasts_both_parts(order):
    """Columns and particles to 10 %, and the time of both."""
    one = scene(*order, when="t > 0.6")
    advice = advise(one)
    assert "hand_over" in advice.facts and "at t = 0.6 s" in advice.facts["hand_over"]
    later = next(payment for payment in advice.payments if payment.what.startswith("then "))
    assert sum(payment.share or 0.0 for payment in advice.payments) == pytest.approx(1.0)
    counted = int(later.detail.split()[0])
    wanted = 8.0 * 96.0 / (0.5**3 * 0.866) if order[1] == "mpm" else 4.0 * 96.0
    assert counted == pytest.approx(wanted, rel=0.15)
    assert 0.0 < later.seconds < advice.facts["run_time"]


def test_a_run_is_as_dear_as_its_parts(tmp_path):
    """Months in three dimensions, but handed over after 0.1 s: affordable; the other way it is not."""
    fine, coarse = {"dx": 0.4}, {"dx": 1.0}
    long = {"end_time": 2e7, "output": {"interval": 1e5}}
    early = snowmpm.Simulation(scene("mpm", "depth", "t > 0.1", solver={"method": "mpm", **fine}, **long))
    refuse_unaffordable(early, tmp_path)
    late = snowmpm.Simulation(scene("depth", "mpm", "t > 0.1", solver={"method": "depth", **coarse},
                                    switch={"solver": fine}, **long))
    with pytest.raises(InputError, match="would take about"):
        refuse_unaffordable(late, tmp_path)
