"""A loss of strength that is averaged over a length: the average, and all that it leaves alone."""

import numpy as np
import pytest

from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.components.nonlocal_averaging.average import FadingAverage
from snowmpm.components.nonlocal_averaging.layer import CLAY
from snowmpm.errors import InputError
from snowmpm.materials import StressUpdate
from snowmpm.scenes.schema import Scene
from snowmpm.setup.build import build
from snowmpm.study.problems.particle_states import ParticleStates
from snowmpm.study.problems.schemes import APIC, free_solver, lattice
from tests.components.nonlocal_averaging.averaging_cases import hurried
from tests.support.sph_block import solver_of
from tests.support.thread_counts import with_one_and_two_threads

DX, LENGTH = 0.1, 0.35
AVERAGED = CLAY.model_copy(update={"nonlocal_length": LENGTH})


def block(size, laws=AVERAGED, material=0, moved=0.0):
    """Solver of a block (size) of particles that lie a little at random; the block is `moved` [m] over the lattice."""
    x, volumes = lattice([0.0] * len(size), size, DX)
    rng = np.random.default_rng(5)
    x = x + moved + rng.uniform(-0.01, 0.01, x.shape)
    averaging = FadingAverage(laws if isinstance(laws, list) else [laws])
    return free_solver(x, volumes * rng.uniform(0.8, 1.2, len(x)), laws, APIC, DX, material=material,
                       adapters=[averaging])


def gained(solver, gain):
    """What averaging makes of gains (n,) of plastic strain from 0.05 on, in the order of the numbers."""
    states = ParticleStates(solver)
    state = np.zeros((len(states.reference), solver.particles.layout.sizes["state"]))
    state[:, 0] = 0.05
    states.set(state=state)
    averaging = solver.adapters["nonlocal_averaging"]
    averaging.before_gather(0.0)
    state[:, 0] += gain
    states.set(state=state)
    before = solver.particles.table()
    averaging.after_gather(0.0)
    after, column = solver.particles.table(), solver.particles.layout.offsets["state"]
    others = np.delete(np.arange(before.shape[1]), column)
    assert after[:, others].tobytes() == before[:, others].tobytes()  # motion, stress, and so momentum and energy
    return states.column("state")[:, 0] - 0.05


@pytest.mark.parametrize("size", [
    pytest.param([1.7, 1.1], id="2-D"), pytest.param([0.7, 0.9, 0.6], id="3-D", marks=pytest.mark.slow)])
def test_a_constant_gain_stays_as_it_is(size):
    solver = block(size)
    np.testing.assert_allclose(gained(solver, 0.0123), 0.0123, rtol=1e-9)
    np.testing.assert_array_equal(gained(solver, 0.0), 0.0)


@pytest.mark.parametrize("moved", [0.0, 0.02, 0.05])
def test_a_slip_counts_as_if_spread_over_the_length(moved):
    """kappa = u / (sqrt(3) l) in the middle, the same to either side, and no part of it is lost."""
    solver = block([0.8, 4.0], moved=moved)
    x, volumes = ParticleStates(solver).reference, ParticleStates(solver).read(solver.particles.column("volume")[:, 0])
    row = np.abs(x[:, 1] - moved - 2.025) < 0.02
    found = gained(solver, np.where(row, 1.0, 0.0))
    thickness = volumes[row].sum() / 0.8
    assert found[row].mean() == pytest.approx(thickness / LENGTH, rel=0.03)
    assert volumes @ found == pytest.approx(volumes[row].sum(), rel=0.02)
    middle = (volumes * found) @ x[:, 1] / (volumes @ found)
    assert middle == pytest.approx(x[row, 1].mean(), abs=0.02 * LENGTH)
    assert found[np.abs(x[:, 1] - moved - 2.025) > 1.5 * LENGTH].max() < 1e-3 * found.max()


def test_materials_share_what_they_lose_if_their_lengths_are_the_same():
    other = AVERAGED.model_copy(update={"cohesion": 2e4})
    longer, local = (AVERAGED.model_copy(update={"nonlocal_length": length}) for length in (1.0, None))
    x, _ = lattice([0.0, 0.0], [2.0, 0.8], DX)
    which = np.minimum(3, (2.0 * x[:, 0]).astype(int))
    solver = block([2.0, 0.8], [AVERAGED, other, longer, local], which)
    found = gained(solver, np.where(which == 0, 1.0, 0.0) + np.where(which == 3, 0.5, 0.0))
    beside = (which == 1) & (x[:, 0] < 0.6)
    assert found[beside].min() > 0.1 and found[which == 2].max() == 0.0
    np.testing.assert_allclose(found[which == 3], 0.5, atol=1e-12)


def test_both_ways_to_add_up_leave_the_same_bits():
    solver, rng = block([1.2, 1.0]), np.random.default_rng(2)
    gain, found = rng.uniform(size=solver.particles.count), []
    for serial in (True, False):
        solver.serial = serial
        solver.adapters.begin(solver)
        found.append(gained(solver, gain).tobytes())
    assert found[0] == found[1]


@pytest.mark.slow
def test_one_and_two_threads_leave_the_same_bits():
    one, two = with_one_and_two_threads("tests.components.nonlocal_averaging.averaging_cases")
    assert one["hash"] == two["hash"] and one["yielding"] > 100 and not two["alone"]


@pytest.mark.slow
def test_a_restored_solver_goes_on_bit_by_bit():
    (one, _), (other, _) = hurried(), hurried()
    for _ in range(8):
        one.step(1e-5)
    assert one.n_plastic > 100
    other.restore(one.state())
    for solver in (one, other):
        for _ in range(4):
            solver.step(1e-5)
    assert one.particles.table().tobytes() == other.particles.table().tobytes()
    strain = one.particles.column("state")[:, 0]
    assert (strain > 0.0).sum() > one.n_plastic  # beyond what yields


def test_periodic_sides_have_two_neighbours():
    """A row at one side counts at the other one, as much as within."""
    solver, clay = hurried()
    states = ParticleStates(solver)
    column = states.reference[:, 0] < 0.025
    inside = clay & (np.abs(states.reference[:, 1]) < 0.1)
    found = gained(solver, np.where(column & clay, 1.0, 0.0))
    at = np.round(states.reference[:, 0] / 0.025 - 0.5).astype(int)
    profile = np.array([found[inside & (at == k)].mean() for k in range(16)])
    np.testing.assert_allclose(profile[1:], profile[:0:-1], atol=0.03 * profile.max())
    assert profile[15] > 2.0 * profile[8]


def test_sph_averages_as_well():
    x, volumes = lattice([0.0, 0.0], [0.8, 2.0], 0.05, 1)
    solver = solver_of(x, volumes, AVERAGED, dx=0.05, adapters=[FadingAverage([AVERAGED])])
    found = gained(solver, np.where(np.abs(x[:, 1] - 1.025) < 0.01, 1.0, 0.0))
    assert found.max() == pytest.approx(0.05 / LENGTH, rel=0.05)


def test_strength_within_a_step_is_that_of_its_beginning():
    """At a point the average is the strain itself: halved steps halve the distance to the local law."""
    off = []
    for steps in (40, 80):
        A = np.zeros((1, steps, 3, 3))
        A[:, :, 0, 1] = 0.2 / steps
        found = [StressUpdate(law).integrate(np.zeros((1, 6)), np.zeros((1, 2)), A) for law in (CLAY, AVERAGED)]
        off.append(abs(found[0].stress - found[1].stress)[0, :, 3].max())
    assert off[1] < 0.6 * off[0] < 0.05 * CLAY.cohesion


def scene(material=(), body=(), **changes):
    clay = {name: value for name, value in AVERAGED.model_dump().items() if value is not None}
    return Scene.model_validate({
        "name": "block", "dimension": 2, "end_time": 0.1, "solver": {"dx": 0.1},
        "domain": {"min": [-1.0, -1.0], "max": [2.0, 2.0]}, "materials": {"clay": {**clay, **dict(material)}},
        "bodies": [{"name": "block", "material": "clay", "shape": {"kind": "box", "min": [0.0, 0.0], "max": [0.5, 0.5]},
                    **dict(body)}], **changes})


@pytest.mark.parametrize(("changes", "word"), [
    ({"solver": {"dx": 0.1, "method": "implicit", "precision": "f64"}}, "implicit"),
    ({"initial": {"stress": "settle", "relaxation": "static"}}, "static")])
def test_what_leaves_particles_out_is_refused(changes, word):
    with pytest.raises(InputError) as refusal:
        build(scene(**changes))
    text = str(refusal.value)
    assert "materials.clay.nonlocal_length = 0.35" in text and word in text and len(text.splitlines()) <= 2


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), "long"])
def test_a_length_must_be_one(value):
    with pytest.raises(ValueError, match="nonlocal_length"):
        scene({"nonlocal_length": value})


def test_laws_that_do_not_soften_have_none():
    elastic = {"kind": "elastic", "density": 1e3, "youngs_modulus": 1e6, "poisson_ratio": 0.3, "nonlocal_length": 0.3}
    with pytest.raises(ValueError, match="nonlocal_length"):
        scene(materials={"clay": elastic})


@pytest.mark.parametrize(("dx", "told"), [(0.08, False), (0.1, True)])
def test_a_length_of_too_few_cells_is_told(dx, told):
    found = scene(solver={"dx": dx})
    model = build(found)
    said = [one for one in cautions(SceneFacts(found, model, model.solver())) if "nonlocal_length" in one.key]
    assert bool(said) == told
