"""Snow cover thinner than its cells under a flow of MPM, against the equations of a block that takes it up."""

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import snowmpm
from snowmpm.advice.report import advise
from snowmpm.errors import InputError
from snowmpm.scenes.schema import Scene
from tests.support.project import ROOT
from tests.support.same_runs import assert_goes_on_alike

G, MU, ANGLE, DENSITY = 9.81, 0.3, np.radians(30.0), 250.0
SNOW = {"kind": "mohr_coulomb", "density": DENSITY, "youngs_modulus": 1e6, "poisson_ratio": 0.3, "friction_angle": 25.0}
RATE = {"law": "rate", "growth_rate": 0.02, "thickness": 1.2, "density": 200.0}
ENERGY = {"law": "erosion_energy", "energy": 1000.0, "thickness": 1.2, "density": 200.0}
STRENGTH = {"law": "strength", "strength": 400.0, "thickness": 1.2, "density": 200.0}
THICK = 1.2


def slope(entrainment, length=20.0, speed=0.0, dimension=2, **changes):
    """A block, `length` [m] along the slope, that slides down a plane of 30 degrees."""
    across, sides = {}, {}
    if dimension == 3:
        across, sides = {"y": [0.0, 2.0]}, {"boundary": {"y_min": "slip", "y_max": "slip"}}

    def point(x, z, y):
        return [x, z] if dimension == 2 else [x, y, z]

    terrain = {"kind": "plane", "angle": 30.0, "contact": "separate", "friction": MU, "entrainment": entrainment}
    return Scene.model_validate({
        "name": "slope", "dimension": dimension, "end_time": 4.0, "output": {"interval": 0.5},
        "solver": {"dx": 0.25, "precision": "f64"},
        "domain": {"min": point(-5.0, -90.0, 0.0), "max": point(145.0, 8.0, 2.0), **sides},
        "terrain": {name: value for name, value in terrain.items() if value}, "materials": {"snow": SNOW},
        "bodies": [{"name": "block", "material": "snow",
                    "velocity": point(speed * np.cos(ANGLE), -speed * np.sin(ANGLE), 0.0),
                    "shape": {"kind": "layer", "bottom": 0.0, "top": THICK,
                              "region": {"x": [0.0, length * np.cos(ANGLE)], **across}}}],
        "initial": {"stress": "geostatic"}, **changes})


def guide():
    """Mass over that of the start by MPM and by the equation, {law: (MPM, equation)}, as the guide has them."""
    text = (ROOT / "docs" / "snow_cover.md").read_text(encoding="utf-8")
    return {law: (float(mpm), float(equation)) for law, mpm, equation in re.findall(
        r"^\| `(\w+)`, [^|]*\| ([\d.]+) \| ([\d.]+) \|$", text, re.MULTILINE)}


def slid(scene, until):
    """(simulation, first and last row of its history)."""
    simulation = snowmpm.Simulation(scene)
    first = simulation.audit()
    while simulation.time < until:
        simulation.step(until=until)
    return simulation, first, simulation.audit()


def block(cover, speed, until):
    """Mass over that of the start, and speed, of a block that takes snow up:   d(m v)/dt = m g sin - b,   dm/dt = r

    with b = tau = mu m g cos for a cover without strength; r = E m v (Hungr 1995), tau v / e (Sampl and Zwinger 2004);
    or b = tau_c, r = (tau - tau_c) / v (Fraccarollo and Capart 2002).
    """
    def rates(_, state):
        mass, v = state
        tau = MU * mass * G * np.cos(ANGLE)
        rate = {"rate": lambda: cover["growth_rate"] * mass * v, "erosion_energy": lambda: tau * v / cover["energy"],
                "strength": lambda: (tau - cover["strength"]) / v}[cover["law"]]()
        borne = cover.get("strength", tau)
        return [rate, (mass * G * np.sin(ANGLE) - borne - rate * v) / mass]

    mass = DENSITY * THICK
    end = solve_ivp(rates, (0.0, until), [mass, max(speed, 1e-6)], rtol=1e-9, atol=1e-12).y[:, -1]
    return end[0] / mass, end[1]


@pytest.mark.parametrize(("cover", "length", "speed", "until", "share"), [
    (RATE, 20.0, 0.0, 4.0, 0.02), (ENERGY, 20.0, 0.0, 4.0, 0.02), (STRENGTH, 80.0, 6.0, 2.0, 0.05)],
    ids=["rate", "erosion energy", "strength"])
def test_mass_and_speed_are_those_of_a_block(cover, length, speed, until, share):
    """Mass at the end: 1.40, 1.05 and 1.42 of the start, to 1, 1 and 4.6 % of the gain. Under the thin ends of a block,
    friction does not reach the strength of the cover: 6.5 % less for 60 m. Speed to 1.5 %. Mass and momentum to
    round-off; energy to 2 % of the work of friction."""
    simulation, first, row = slid(slope(cover, length, speed), until)
    mass, v = block(cover, speed, until)
    assert row["mass"] / first["mass"] - 1.0 == pytest.approx(mass - 1.0, rel=share)
    assert (row["mass"] / first["mass"], mass) == pytest.approx(guide()[cover["law"]], abs=0.003)
    assert np.hypot(row["momentum_x"], row["momentum_z"]) / row["mass"] == pytest.approx(v, rel=0.015)
    assert row["mass"] == pytest.approx(first["mass"] + row["entrained_mass"] - row["removed_mass"], rel=1e-12)
    assert row["momentum_residual"] < 1e-12
    assert abs(row["energy_remainder"]) < 0.02 * row["contact_work"]
    assert simulation.n_particles > len(simulation.model.population.volumes)


@pytest.mark.parametrize(("until", "share"), [(2.0, 0.07), (4.0, 0.02)])
def test_the_snow_above_is_raised_by_what_comes_in(until, share):
    """Surface over the middle of the block, against all snow there: 6 % higher after 2 s, to 1 % after 4 s. Nothing is
    pressed together (0.97 < J)."""
    simulation, _, row = slid(slope(RATE), until)
    fields = simulation.particles
    x, along = fields["position"], np.array([np.cos(ANGLE), -np.sin(ANGLE)])
    place, normal = x @ along, x @ np.array([np.sin(ANGLE), np.cos(ANGLE)])
    middle = np.abs(place - np.median(place)) < 3.0
    volume = fields["volume"][middle].sum() / 6.0
    assert volume > 1.05 * THICK
    column = np.floor(place / 0.5)
    tops = [normal[middle & (column == one)].max() for one in np.unique(column[middle])]
    assert np.mean(tops) + 0.0625 == pytest.approx(volume, rel=share)
    assert row["min_J"] > 0.97


def test_no_more_than_lies_there():
    """A thin cover that the flow takes up at once: all of what it has passed, to 3 %, and the front is braked by it."""
    thin = {**RATE, "growth_rate": 1.0, "thickness": 0.05}
    simulation, _, row = slid(slope(thin, speed=6.0), 3.0)
    _, _, bare = slid(slope(None, speed=6.0), 3.0)
    passed = simulation.particles["position"][:, 0].max() / np.cos(ANGLE)
    assert row["entrained_mass"] == pytest.approx(0.05 * 200.0 * passed, rel=0.03)
    assert row["front_distance"] < bare["front_distance"]
    lain = slid(slope({**thin, "thickness": 0.0}, speed=6.0), 0.5)[2]
    assert lain["entrained_mass"] == 0.0


def test_snow_in_the_air_takes_nothing_up():
    """A block that flies 3 m above the slope, until it lands."""
    flying = slope(RATE, 8.0, 8.0).model_dump(exclude_unset=True)
    flying["bodies"][0]["shape"] |= {"bottom": 3.0, "top": 3.0 + THICK}
    flying["initial"] = {}
    simulation = snowmpm.Simulation(Scene.model_validate(flying))
    while simulation.time < 0.7:  # it falls 2.4 m, or 2.1 m across the slope
        simulation.step(until=0.7)
    assert simulation.audit()["entrained_mass"] == 0.0
    while simulation.time < 1.5:
        simulation.step(until=1.5)
    assert simulation.audit()["entrained_mass"] > 0.0


def test_a_block_at_rest_takes_nothing_up():
    """It trembles by centimetres a second on friction that is not that of sliding."""
    rest = slope(STRENGTH).model_dump(exclude_unset=True)
    rest["terrain"] |= {"friction": 0.7}
    rest["materials"]["snow"] |= {"friction_angle": 45.0, "cohesion": 5e3}
    simulation = snowmpm.Simulation(Scene.model_validate(rest))
    while simulation.time < 0.5:
        simulation.step(until=0.5)
    assert simulation.audit()["max_speed"] < 0.5 and simulation.audit()["entrained_mass"] == 0.0


@pytest.mark.parametrize("width", [1.0, 2.0])
def test_a_channel_has_the_cover_that_lies_in_it(width):
    """All of a thin cover between walls two and four cells apart, but for 5.6 % that the front has not taken yet: half
    of the cell of a node at a wall lies behind it."""
    channel = slope({**RATE, "growth_rate": 1.0, "thickness": 0.05}, 8.0, 8.0, dimension=3, solver={"dx": 0.5})
    tables = channel.model_dump(exclude_unset=True)
    tables["domain"]["max"] = [145.0, width, 8.0]
    tables["bodies"][0]["shape"]["region"]["y"] = [0.0, width]
    simulation = snowmpm.Simulation(Scene.model_validate(tables))
    while simulation.time < 2.0:
        simulation.step(until=2.0)
    passed = (simulation.particles["position"][:, 0].max()) / np.cos(ANGLE) * width
    assert simulation.audit()["entrained_mass"] == pytest.approx(0.05 * 200.0 * passed, rel=0.07)


def test_nothing_lies_under_an_obstacle():
    """A step that the flow runs over."""
    tables = slope({**RATE, "growth_rate": 1.0, "thickness": 0.1}, 20.0, 10.0).model_dump(exclude_unset=True)
    corners = [[30.0, -30.0], [40.0, -30.0], [40.0, -40.0 * np.tan(ANGLE) + 1.0], [30.0, -30.0 * np.tan(ANGLE) + 1.0]]
    tables["obstacles"] = [{"name": "step", "contact": "separate", "friction": 0.2,
                            "shape": {"kind": "polygon", "points": corners}}]
    simulation = snowmpm.Simulation(Scene.model_validate(tables))
    cover = simulation.solver.adapters["entrainment"]
    x = cover._nodes.plan[:, 0]
    assert (cover._cover[(x > 30.5) & (x < 39.5)] == 0.0).all() and (cover._cover[(x > 41.0) & (x < 100.0)] > 0.0).all()
    while simulation.time < 3.0:
        simulation.step(until=3.0)
    fields = simulation.particles
    came = fields["position"][fields["id"] >= len(simulation.model.population.volumes)]
    assert len(came) > 20
    inside = (came[:, 0] > 31.0) & (came[:, 0] < 39.0) & (came[:, 1] < 0.5 - came[:, 0] * np.tan(ANGLE))
    assert not inside.any()


def test_forces_go_with_it():
    """A load on a body, for which what joins is none of it, and a pressure on its surface: momentum to round-off."""
    loads = {"events": [{"kind": "load", "body": "block", "start": 0.5, "force": [2e4, -1e4]}],
             "forces": [{"kind": "pressure", "acts_on": "surface", "value": 500.0}]}
    for name, value in loads.items():
        row = slid(slope(RATE, speed=6.0, **{name: value}), 1.5)[2]
        assert row["momentum_residual"] < 1e-11 and row["entrained_mass"] > 100.0


def test_only_snow_gives_its_law_to_what_joins():
    """An elastic body that the flow meets does not grow."""
    tables = slope(RATE, 10.0, 8.0).model_dump(exclude_unset=True)
    tables["materials"]["wood"] = {"kind": "elastic", "density": 600.0, "youngs_modulus": 1e7, "poisson_ratio": 0.3}
    log = {"kind": "layer", "bottom": 0.0, "top": 0.5, "region": {"x": [14.0, 15.0]}}
    tables["bodies"] = [*tables["bodies"], {"name": "log", "material": "wood", "shape": log}]
    simulation = snowmpm.Simulation(Scene.model_validate(tables))
    while simulation.time < 2.0:
        simulation.step(until=2.0)
    fields = simulation.particles
    came = fields["id"] >= len(simulation.model.population.volumes)
    assert came.sum() > 20 and (fields["material"][came] == 0).all() and (fields["body"][came] == 0).all()


def test_traces_of_snow_make_no_dust():
    """0.1 mm: few particles of an eighth of the usual volume, and together the mass of what was passed, to 30 %."""
    simulation, _, row = slid(slope({**RATE, "growth_rate": 1.0, "thickness": 1e-4}, speed=6.0), 3.0)
    fields = simulation.particles
    came = fields["id"] >= len(simulation.model.population.volumes)
    assert 0 < came.sum() < 20
    passed = fields["position"][:, 0].max() / np.cos(ANGLE)
    assert row["entrained_mass"] == pytest.approx(1e-4 * 200.0 * passed, rel=0.3)


@pytest.mark.parametrize(("name", "change"), [
    ("left", lambda values: values[:-1]), ("owed", lambda values: values + 1e6), ("given", lambda values: values[:1]),
    ("left", lambda values: values - 1e9), ("sums", lambda values: values * np.nan),
    ("places", lambda values: values[:-1]), ("bodies", lambda values: values + 99)])
def test_a_state_that_no_run_leaves(name, change):
    simulation, _, _ = slid(slope(RATE, speed=8.0, solver={"dx": 0.5}), 1.0)
    cover = simulation.solver.adapters["entrainment"]
    state = cover.state()
    assert len(state["places"]) > 3
    cover.restore(state)
    with pytest.raises(ValueError, match="none of this scene"):
        cover.restore({**state, name: change(state[name])})


def test_what_joins_is_what_the_law_has_taken():
    """Under a flow that leaves each place after half a particle; and it is of the block's material and body."""
    simulation, _, row = slid(slope({**ENERGY, "energy": 5000.0}), 4.0)
    cover = simulation.solver.adapters["entrainment"]
    taken = cover._cover.sum() - cover._left.sum()
    assert 0.0 < taken < 0.3 * (cover._portion * (cover._left < cover._cover)).sum()
    assert row["entrained_mass"] == pytest.approx(taken, abs=3.0 * cover._portion.max())
    fields = simulation.particles
    assert (fields["body"] == 0).all() and (fields["material"] == 0).all()
    assert (fields["id"] >= len(simulation.model.population.volumes)).sum() > 10


def test_it_goes_on_to_the_bit(tmp_path):
    simulation = snowmpm.Simulation(slope(STRENGTH, speed=6.0, solver={"dx": 0.4}))
    while simulation.time < 1.0:
        simulation.step()
    before = simulation.n_particles
    other = assert_goes_on_alike(simulation, 2.0, tmp_path)
    assert other.n_particles > before


def test_a_raster_of_thickness_in_space(tmp_path):
    """In 3-D: snow is taken up only where the raster has some, and is in the frames and masses of the run."""
    rows = "\n".join(" ".join("0.3" if 15.0 <= 5.0 * (i - 2) < 45.0 else "0" for i in range(31)) for _ in range(3))
    (tmp_path / "cover.asc").write_text("ncols 31\nnrows 3\nxllcorner -10\nyllcorner -5\ncellsize 5\n"
                                        f"NODATA_value -1\n{rows}\n")
    cover = {**RATE, "growth_rate": 0.2, "thickness": {"file": str(tmp_path / "cover.asc")}}
    scene = slope(cover, 8.0, 8.0, dimension=3, end_time=3.0, solver={"dx": 0.4})
    run = snowmpm.run(scene, tmp_path / "run")
    assert run.history["entrained_mass"][1] == 0.0 and run.history["entrained_mass"][-1] > 0.2 * run.history["mass"][0]
    assert len(run.frame(-1).points) > len(run.frame(0).points)
    numbers = run.summary["hazard"]
    assert numbers["deposit_mass"] == pytest.approx(run.history["mass"][-1], rel=1e-3)
    assert numbers["release_mass"] == pytest.approx(run.history["mass"][0], rel=1e-3)


@pytest.mark.parametrize(("cover", "changes", "says"), [
    (STRENGTH, {"terrain": {"contact": "stick"}}, 'must be "rate" beside terrain.contact = "stick"'),
    (RATE, {"domain": {"boundary": {"x_min": "periodic", "x_max": "periodic"}}}, "periodic sides"),
    (RATE, {"gravity": {"ramp": 0.5}}, "gravity that changes"),
    (RATE, {"solver": {"method": "sph"}}, 'solver.method = "depth" or "mpm"|"mpm" or "depth"')])
def test_what_it_does_not_go_with(cover, changes, says):
    tables = slope(RATE).model_dump(exclude_unset=True)
    tables["terrain"]["entrainment"] = cover
    for key, value in changes.items():
        tables[key] = {**tables.get(key, {}), **value}
    with pytest.raises((InputError, ValueError), match=says) as refused:
        snowmpm.Simulation(Scene.model_validate(tables))
    assert len(str(refused.value).splitlines()) <= 4


def test_what_check_says_of_a_thick_cover():
    told = {caution.key: str(caution) for caution in advise(slope(RATE)).cautions}
    assert "laid_ahead" in told["terrain.entrainment.thickness"]
    thin = advise(slope({**RATE, "thickness": 0.2})).cautions
    assert "terrain.entrainment.thickness" not in {caution.key for caution in thin}
