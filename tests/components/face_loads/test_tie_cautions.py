"""`snowmpm check` on surfaces that are tied by a penalty, and what it says of forces on surfaces."""

from snowmpm.advice.cautions import cautions
from snowmpm.advice.facts import SceneFacts
from snowmpm.running.description import describe
from snowmpm.running.simulation import Simulation
from tests.components.forcing_and_damping.forced_block import scene_of


def told(**force):
    scene = scene_of(forces=[{"kind": "displacement", "name": "grip", "body": "block", "value": [0.01, 0.0], **force}])
    simulation = Simulation(scene)
    facts = SceneFacts(scene, simulation.model, simulation.solver)
    found = [str(caution) for caution in cautions(facts) if caution.key.startswith("forces")]
    return found, describe(simulation.model, simulation.solver)


def test_a_soft_tie_is_named_with_its_cure():
    """A block of four cells: a layer of a tenth of a cell is 2.9 % of the way between its outermost particles."""
    found, facts = told()
    assert len(found) == 1 and "forces.0.penalty: 10 lets the surface give way as a layer of 2.9 % of block" in found[0]
    cure = float(found[0].partition("penalty = ")[2].split()[0])
    assert told(penalty=1.05 * cure)[0] == []
    assert facts["forces"] == {"0 displacement": "0.01, 0.0 m on the surface of block"}
    stiffer = told(penalty=1000.0)[1]
    assert stiffer["dt"] < 0.5 * facts["dt"] and stiffer["steps"] > 2 * facts["steps"]
