"""How a scene asks for one change of volume a cell, and what shows that it acts."""

import numpy as np

from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps


def squeezed(method):
    """Snow on a smooth floor that nothing has settled yet, whose cells change their volume as one."""
    dim = given.least_dimension(method)
    sides = {f"{axis}_{end}": "slip" for axis in ("xz" if dim == 2 else "xyz") for end in ("min", "max")}
    walls = {"min": given.point(dim, 0.0, 0.0, 0.0), "max": given.point(dim, given.SIDE, 2 * given.SIDE, given.SIDE),
             "boundary": sides | {"z_max": "open"}}
    asked = {"implicit": {"f_bar": True}} if method == "implicit" else {"f_bar": True}
    return Simulation(given.scene(method, solver=asked, gravity=given.G, domain=walls, precision="f64"))


def has_one_volume_a_cell(simulation):
    steps(simulation, 10)
    fields, frame = simulation.particles, simulation.solver.frame
    cells = np.floor((fields["position"] - frame.origin) / frame.dx - 0.5).astype(int)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    most, least = (reduce.at for reduce in (np.maximum, np.minimum))
    high, low = np.full(cell.max() + 1, -np.inf), np.full(cell.max() + 1, np.inf)
    most(high, cell, fields["J"])
    least(low, cell, fields["J"])
    assert 0.0 <= (high - low).max() < 1e-6 * np.ptp(fields["J"])
    implicit = simulation.scene.solver.implicit
    assert simulation.audit()["momentum_residual"] < (implicit.tolerance if implicit else 1e-11)


def part(method):
    """What a scene needs for it, beside other components."""
    return {"solver": {"implicit": {"f_bar": True}} if method == "implicit" else {"f_bar": True}}


ASKED = squeezed, has_one_volume_a_cell
