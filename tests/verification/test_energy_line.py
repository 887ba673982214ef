"""A thin strip stops where Coulomb friction says, and keeps to the energy line on its way (M19, `energy_line`)."""

import pytest

from snowmpm.study.problems.energy_line import MU, THICK, G, exact_way, stops, strip
from snowmpm.study.problems.schemes import Scheme


@pytest.mark.parametrize("transfer", ["apic", "aflip"])
def test_strip_stops_where_friction_says(transfer):
    solver, ground = strip(Scheme(transfer), 2)
    x = solver.particles.positions()
    begin, checked = ground.way(x).mean(), False
    for _ in stops(solver):
        now, v = solver.particles.positions(), solver.particles.column("velocity")
        if not checked and ground.way(now).max() > -2.0:
            # Still on the slope: the energy line falls by mu a metre in plan
            drop = x.mean(axis=0)[1] - now.mean(axis=0)[1] - 0.5 * (v**2).sum(axis=1).mean() / G
            assert drop / (now.mean(axis=0) - x.mean(axis=0))[0] == pytest.approx(MU, rel=0.02)
            checked = True
    assert checked
    run = ground.way(solver.particles.positions()).mean() - begin
    assert run == pytest.approx(exact_way(begin, 0.5 * THICK) - begin, rel=0.02)
