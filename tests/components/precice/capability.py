"""How a scene asks for a structure of another program, and what shows that it takes part."""

import contextlib
import sys
import tempfile
from pathlib import Path
from unittest import mock

from snowmpm.running.simulation import Simulation
from tests.components.precice.coupled_plate import config, plate
from tests.components.precice.stand_in import StandIn
from tests.contract import method_examples as given
from tests.contract.method_suite import steps

END = 0.01


def beside_another_program(method):
    """A block thrown at a plate that a stand-in computes."""
    dim = given.least_dimension(method)
    corners = [given.point(dim, given.SIDE + 0.14, z, 0.2) for z in (-0.4, 0.8)]
    with tempfile.TemporaryDirectory() as folder, mock.patch.dict(sys.modules, precice=StandIn(plate(), END)):
        file = config(Path(folder), END)
        return Simulation(given.scene(method, bodies=[given.block(dim, (8.0, 0.0))], end_time=END, structures=[
            {"name": "plate", "points": corners, "segments": 6, "width": 0.2, "precice": {"file": str(file)}}]))


def is_met(simulation):
    steps(simulation, 20)
    row, plate = simulation.audit(), simulation.solver.adapters["structures"].rods.rods[0].rod
    assert plate.given[0] > 0.0 and abs(plate.answered).max() > 0.0
    assert row["momentum_residual"] < 1e-11


@contextlib.contextmanager
def part_of(method):
    """Context: what a scene needs for it, beside other components: a plate above the block."""
    dim = given.least_dimension(method)
    corners = [given.point(dim, x, given.SIDE + 0.17, 0.2) for x in (-0.4, 0.3)]
    with tempfile.TemporaryDirectory() as folder, mock.patch.dict(sys.modules, precice=StandIn(plate(), END)):
        yield {"end_time": END, "structures": [
            {"name": "plate", "points": corners, "segments": 6, "width": 0.2,
             "precice": {"file": str(config(Path(folder), END))}}]}


ASKED = beside_another_program, is_met
