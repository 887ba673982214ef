"""The largest stable step is a measured one: quiet below it, gone above it, and refused where a user asks for more."""

import numpy as np
import pytest

from snowmpm import Simulation
from snowmpm.errors import InputError, SimulationError
from snowmpm.materials import Elastic
from snowmpm.scenes.schema import Scene
from snowmpm.schemes import SCHEMES
from snowmpm.stepping.time_step import (
    LARGE_STRAIN,
    SMALL_STRAIN,
    critical_cfl,
    grain_stiffness,
    strained_cfl,
    usual_cfl,
)
from snowmpm.study.atlas.stirring import DX, blows_up, lone_grain, spread, stirred

ICE = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.3)
NEARLY_LIQUID = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=0.45)


def survives(share, grains, law, steps=1000, **options):
    """Whether grains stay quiet at this share of the solver's own critical step."""
    solver, energy = stirred(grains, law, **options)
    dt, cause = solver.critical_dt()
    assert cause == "elastic"
    return not blows_up(solver, energy, share * dt, steps)


@pytest.mark.parametrize("law", [ICE, NEARLY_LIQUID])
@pytest.mark.parametrize(
    ("options", "offset"),
    [({}, 0.3), ({"transfer": "pic"}, 0.3), ({"transfer": "flip", "kernel": "cubic", "gradient": "shape"}, 0.22),
     ({"transfer": "flip", "kernel": "gimp", "gradient": "shape"}, 0.2499),
     ({"transfer": "pic", "kernel": "linear", "gradient": "shape"}, 0.0312)],
    ids=["apic", "pic", "classical", "gimp", "linear"])
def test_the_critical_step_of_a_lone_grain_lies_where_it_is_said(law, options, offset):
    grain = lone_grain(2, offset)
    assert survives(0.98, grain, law, **options)
    assert not survives(1.15, grain, law, steps=300, **options)


@pytest.mark.parametrize("grains", [spread(2, 4, 2, 0.25), spread(1, 4, 2, 0.0), spread(3, 3, 2, 0.1)],
                         ids=["full", "sparse", "dense"])
def test_no_body_is_less_stable_than_a_grain(grains):
    assert survives(0.98, grains, ICE)
    assert not survives(1.7, grains, ICE, steps=300)  # a full one bears 1.31 times as much, not more


def test_squeezed_snow_carries_faster_waves():
    """F = diag(1/2, 1) between periodic sides: the same share of the limit is stable, that of snow at rest is not."""
    axis, across = DX * (np.arange(32) + 0.5) / 4.0, DX * (np.arange(16) + 0.5) / 2.0
    positions = np.stack(np.meshgrid(axis, across, indexing="ij"), axis=-1).reshape(-1, 2)
    grains = positions, np.full(len(positions), DX**2 / 4.0)
    box = {"origin": np.zeros(2), "lower": np.zeros(2), "upper": np.full(2, 8.0 * DX),
           "sides": [["periodic", "periodic"]] * 2}
    strain = np.log([0.5, 1.0])
    solver, energy = stirred(grains, ICE, strain=strain, **box)
    dt, _ = solver.critical_dt()
    at_rest = critical_cfl("quadratic", "affine", "apic", grain_stiffness(ICE, 2)) * DX / ICE.wave_speed()
    assert dt == pytest.approx(at_rest / np.sqrt(1.0 + np.log(2.0)), rel=1e-9)
    assert not blows_up(solver, energy, dt, 1000)
    # Measured: this lattice bears C = 1.34 with the faster speed, full ones 1.15 with that at rest
    limit = 1.34 * DX / (ICE.wave_speed() * np.sqrt(1.0 + np.log(2.0)))
    for share, unstable in ((0.97, False), (1.05, True)):
        solver, energy = stirred(grains, ICE, strain=strain, **box)
        assert blows_up(solver, energy, share * limit, 400) == unstable


def test_what_a_scene_gets_without_a_wish_is_stable():
    for scheme in SCHEMES:
        for dim in (2, 3):
            for ratio in (-0.5, 0.0, 0.3, 0.49):
                law = Elastic(density=300.0, youngs_modulus=1e6, poisson_ratio=ratio)
                critical = critical_cfl(*scheme, grain_stiffness(law, dim))
                assert 0.85 * critical < usual_cfl(critical) < 0.95 * critical


def test_the_step_shortens_with_the_strain_and_never_jumps():
    strains = np.linspace(0.0, 3.0 * LARGE_STRAIN, 301)
    found = np.array([strained_cfl(0.75, 0.4, strain) for strain in strains])
    assert (found[strains <= SMALL_STRAIN] == 0.75).all()
    assert found[strains > 1.001 * LARGE_STRAIN] == pytest.approx(0.4)
    assert (np.diff(found) <= 0.0).all() and np.diff(found).min() > -0.01
    assert strained_cfl(0.3, 0.3, 1.0) == 0.3


@pytest.mark.parametrize(("squeezed", "way"), [(0, 0.0), (32, 0.25), (128, 1.0), (6400, 1.0)])
def test_a_few_squeezed_grains_leave_the_step_alone(make_solver, squeezed, way):
    """The first `squeezed` of 6400 particles have a strain beyond LARGE_STRAIN, and so many of 128 shorten C."""
    solver = make_solver(2, 0.01, [0.0, 0.0], [0.4, 0.4], law=ICE)
    table = solver.particles.table()
    table[:squeezed, solver.particles.layout.columns("elastic")] = [-0.2, -0.2, -0.2, 0.0]
    solver.particles.overwrite(table)
    solver.step(1e-9)
    extremes, careful = solver.extremes, solver.breaking_cfl
    assert solver.particles.count == 6400 and extremes.strained == pytest.approx(way)
    wave = ICE.wave_speed() * (np.sqrt(1.0 - 0.5 * np.log(1.0 - 0.2 * np.sqrt(3.0))) if squeezed else 1.0)
    expected = (solver.cfl + way * (careful - solver.cfl)) * 0.01 / wave
    assert solver.stable_dt()[0] == pytest.approx(expected, rel=1e-3)  # f32


def block(velocity=0.0, **solver):
    """Elastic block above a floor that falls at `velocity` [m/s]; nothing else moves it."""
    material = {"kind": "elastic", "density": 300.0, "youngs_modulus": 1e6, "poisson_ratio": 0.3}
    return Scene.model_validate({
        "name": "block", "dimension": 2, "end_time": 0.1, "gravity": 0.0,
        "solver": {"dx": DX, "precision": "f64", **solver},
        "domain": {"min": [-1.0, 0.0], "max": [1.4, 1.0], "boundary": {"z_min": "stick"}},
        "materials": {"snow": material},
        "bodies": [{"name": "block", "material": "snow", "velocity": [0.0, -velocity],
                    "shape": {"kind": "box", "min": [0.0, 0.1], "max": [0.4, 0.4]}}]})


LIMIT = np.sqrt(0.7) * DX / ICE.wave_speed()
"""Critical fixed step [s] of the block: C = 1 / sqrt(s), s = 1 / (1 - nu)."""


def test_a_fixed_step_above_the_critical_one_is_refused_at_the_start():
    with pytest.raises(InputError, match=r"solver\.dt = .*: unstable: must be at most 0\.00124 s here \(elastic limit"):
        Simulation(block(dt=1.01 * LIMIT))
    Simulation(block(dt=0.99 * LIMIT)).step()


def test_a_fixed_step_that_becomes_too_long_ends_the_run():
    simulation = Simulation(block(velocity=8.0, dt=0.97 * LIMIT))
    with pytest.raises(SimulationError, match=r"solver\.dt = .* is too long at t = .*: the elastic limit is"):
        while simulation.time < 0.1:
            simulation.step()
    assert simulation.time > 0.0 and np.isfinite(simulation.particles["velocity"]).all()


@pytest.mark.parametrize(
    ("scheme", "allowed"),
    [({"cfl": 0.9}, 0.836), ({"cfl": 0.6, "transfer": "pic"}, 0.591),
     ({"cfl": 0.5, "transfer": "flip", "gradient": "shape"}, 0.482)])
def test_a_cfl_beyond_the_critical_one_is_refused(scheme, allowed):
    with pytest.raises(InputError, match=rf"solver\.cfl = {scheme['cfl']}: unstable: must be at most {allowed} for"):
        Simulation(block(**scheme))
