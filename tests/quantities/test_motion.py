"""When snow is at rest: numbers that can be counted by hand."""

import numpy as np
import pytest

import snowmpm
from snowmpm.quantities.motion import CREEP, MOVING_SPEED, REST_MOMENTUM, REST_SHARE, Motion, at_rest

MASS = np.array([1.0, 2.0, 3.0, 4.0])


def along_x(*speeds):
    return np.column_stack([speeds, np.zeros((len(speeds), 2))])


def test_shares_are_of_mass_and_of_the_largest_momentum():
    motion = Motion.of(MASS, along_x(0.0, 5.0, 0.5, -2.0), peak=39.0)
    assert motion.moving_share == pytest.approx(0.6)  # 2 + 4 of 10 kg are faster than 1 m/s
    assert motion.total_momentum == pytest.approx(19.5) and motion.momentum_share == pytest.approx(0.5)
    later = Motion.of(MASS, along_x(20.0, 20.0, 20.0, 20.0), motion.peak_momentum)
    assert later.peak_momentum == pytest.approx(200.0) and later.momentum_share == 1.0


def test_a_fast_branch_and_a_creeping_deposit_are_both_motion():
    mass = np.ones(1000)
    fast, creeping = np.zeros(1000), np.full(1000, 0.9 * MOVING_SPEED)
    fast[: round(1.5 * 1000 * REST_SHARE)] = 25.0
    branch, creep = Motion.of(mass, along_x(*fast), 30e3), Motion.of(mass, along_x(*creeping), 10e3)
    assert branch.momentum_share < REST_MOMENTUM and not branch.at_rest
    assert creep.moving_share == 0.0 and not creep.at_rest
    assert Motion.of(mass, along_x(*np.full(1000, 0.04)), 1e3).at_rest


def test_noise_of_what_never_moved_is_rest_but_no_reason_to_stop():
    still = Motion.of(MASS, along_x(*np.full(4, 0.5 * CREEP)), 0.0)
    assert still.at_rest and not still.has_moved and still.momentum_share == 0.0
    assert Motion.of(MASS[:0], along_x()[:0]).at_rest


def test_the_history_holds_the_same_numbers_and_resumes_them():
    scene = snowmpm.load_scene("column_collapse_2d", {"solver.dx": 0.04, "end_time": 0.1})
    simulation = snowmpm.Simulation(scene)
    rows = []
    for _ in range(3):
        for _ in range(20):
            simulation.step()
        rows.append(simulation.audit())
        p = simulation.particles
        speed = np.linalg.norm(p["velocity"], axis=1)
        assert rows[-1]["total_momentum"] == pytest.approx(float((p["mass"] * speed).sum()), rel=1e-12)
        assert bool(at_rest(rows[-1]["moving_share"], rows[-1]["momentum_share"])) == simulation.motion.at_rest
    assert rows[-1]["momentum_share"] == 1.0  # it is still accelerating
    peak = simulation.motion.peak_momentum
    again = snowmpm.Simulation(scene)
    again.restore(simulation.state())
    assert again.motion.peak_momentum == peak
