"""R10: balls of Stomakhin's snow dropped on the ground, five parameter sets side by side (Gaume's chapter, figure 4).

The sets are those of Stomakhin et al. (2013), doi:10.1145/2461912.2461948, table 2: the reference, and one number lower
in each of the others. Discs of 0.2 m, in plane strain, at 5 m/s, each on a plate of its own, which records its load.
No number is published: what is said of the sets is tested, that critical stretch and compression say when snow breaks
and packs, hardening how fast it loses or gains stiffness by that, Young's modulus how hard it hits.
"""

import numpy as np
import pytest

from snowmpm.running.simulation import Simulation
from snowmpm.scenes.schema import Scene

REFERENCE = {"kind": "stomakhin_snow", "density": 400.0, "youngs_modulus": 1.4e5, "poisson_ratio": 0.2,
             "hardening": 10.0, "critical_compression": 0.025, "critical_stretch": 0.0075}
SETS = {"reference": {}, "hardening": {"hardening": 5.0}, "youngs_modulus": {"youngs_modulus": 4.8e4},
        "critical_compression": {"critical_compression": 0.019}, "critical_stretch": {"critical_stretch": 0.005}}
RADIUS, DX, SPEED, END = 0.1, 0.01, 5.0, 0.15


class Ball:
    """What became of one of them. torn, packed: mass shares with J_P above 1.01 and below 0.99; torn_by, packed_by:
    mean of |J_P - 1| over them; stiffness: largest and least factor; width: of what is
    left [m]; peak: largest force on its plate, mean over 1 ms [N/m]."""

    def __init__(self, fields, own, law, peak):
        factor, mass = fields["stiffness_factor"][own], fields["mass"][own]
        ratio = 1.0 - np.log(factor) / law["hardening"]
        self.torn, self.packed = (mass[where].sum() / mass.sum() for where in (ratio > 1.01, ratio < 0.99))
        self.torn_by, self.packed_by = np.maximum(ratio - 1.0, 0.0).mean(), np.maximum(1.0 - ratio, 0.0).mean()
        self.stiffness, self.peak = (factor.min(), factor.max()), peak
        self.width = np.ptp(fields["position"][own, 0])


@pytest.fixture(scope="module")
def balls():
    """`Ball` by the name of its set."""
    bodies, plates = [], []
    for number, name in enumerate(SETS):
        x = 0.6 * number
        bodies.append({"name": name, "material": name, "velocity": [0.0, -SPEED],
                       "shape": {"kind": "sphere", "centre": [x, RADIUS + DX], "radius": RADIUS}})
        plates.append({"name": name, "contact": "separate", "friction": 0.5,
                       "shape": {"kind": "box", "min": [x - 0.29, -6 * DX], "max": [x + 0.29, 0.0]}})
    scene = Scene.model_validate({
        "name": "snow_balls", "dimension": 2, "end_time": END, "solver": {"dx": DX},
        "domain": {"min": [-0.3, -0.06], "max": [2.7, 0.6]}, "bodies": bodies, "obstacles": plates,
        "materials": {name: REFERENCE | changes for name, changes in SETS.items()}})
    simulation, loads = Simulation(scene), []
    while simulation.time < END:
        simulation.step(until=min(END, 1e-3 * (len(loads) + 1)))
        if simulation.time >= 0.999e-3 * (len(loads) + 1):
            loads.append(np.asarray(simulation.solver.obstacle_totals)[: len(SETS), 1].copy())
    force, fields = -np.diff(loads, axis=0) / 1e-3, simulation.particles
    return {name: Ball(fields, fields["body"] == number, REFERENCE | SETS[name], force[:, number].max())
            for number, name in enumerate(SETS)}


@pytest.mark.slow
def test_snow_of_less_critical_stretch_tears_more(balls):
    assert balls["critical_stretch"].torn_by > 1.1 * balls["reference"].torn_by


@pytest.mark.slow
def test_snow_of_less_critical_compression_packs_more(balls):
    assert balls["critical_compression"].packed_by > 1.1 * balls["reference"].packed_by


@pytest.mark.slow
def test_softer_snow_hits_less_hard(balls):
    """With a third of the stiffness it has a third of the strength (its thresholds are strains): it packs 1.7 times
    as much, and loads its plate with 13 % less."""
    assert balls["youngs_modulus"].peak < balls["reference"].peak
    assert balls["youngs_modulus"].packed_by > 1.3 * balls["reference"].packed_by


@pytest.mark.slow
def test_snow_that_hardens_less_gives_way_further(balls):
    less, reference = balls["hardening"], balls["reference"]
    assert less.packed_by > reference.packed_by
    assert less.stiffness[1] < reference.stiffness[1]
