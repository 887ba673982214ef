"""Dams that break, against the theory of shallow flow: on the flat (D2, Ritter), on a wet bed (D3, Stoker), on a slope
with friction (D4)."""


import numpy as np
import pytest

from tests.support.dam_breaks import DryDam, WetDam
from tests.support.depth_flows import USUAL, front, order

RITTER, STEEP, HELD = DryDam(), DryDam(30.0, 20.0), DryDam(22.0, 25.0)
SPACINGS = (0.2, 0.1, 0.05)


def dry_error(dam, dx, time, rear):
    """L1 error of the depth from a metre behind the fan, over the depth behind the dam times c t [-]."""
    x, depth, _ = dam.broken(dx, time, rear)
    fan = x > dam.place(1.0, time) - 1.0
    return np.abs(depth - dam.depth(x, time))[fan].sum() * (x[1] - x[0]) / (np.sqrt(dam.g_z) * time)


def front_error(dam, dx, time, rear, threshold):
    """Of the place at which the flow is `threshold` [m] deep, relative."""
    x, depth, _ = dam.broken(dx, time, rear)
    return front(x, depth, threshold) / dam.place(threshold, time) - 1.0


@pytest.mark.parametrize(("dam", "rear", "gate"), [(RITTER, 6.0, 0.015), (STEEP, 8.0, 0.0195)], ids=["D2", "D4"])
def test_depth_of_the_fan(dam, rear, gate):
    """First order, since slope and curvature of the depth jump at both ends of the fan. Seen at 20 cells of the
    depth behind the dam: 1.47 and 1.95 %. Orders of 0.8."""
    errors = [dry_error(dam, dx, 1.0, rear) for dx in SPACINGS]
    assert errors[-1] < gate
    assert order(errors).min() > 0.8


@pytest.mark.parametrize(("dam", "time", "dx", "rear", "threshold"), [
    (RITTER, 1.0, 0.025, 6.0, 0.05),
    (STEEP, 1.0, 0.025, 8.0, 0.05),
    pytest.param(HELD, 1.0, 0.025, 5.0, 0.03, marks=pytest.mark.xfail(strict=True, reason="1.05 %")),
    pytest.param(HELD, 1.0, 0.0125, 5.0, 0.03, marks=pytest.mark.slow),
    pytest.param(STEEP, 2.0, 0.05, 12.0, 0.05, marks=pytest.mark.slow),
    pytest.param(HELD, 2.0, 0.025, 9.0, 0.03, marks=pytest.mark.slow)])
def test_front(dam, time, dx, rear, threshold):
    """Within 1 %, by a depth of a twentieth of that behind the dam; on 22 degrees with friction of 25 of 0.03, since
    the theory's tail moves backwards there, where friction holds ours, and so deepens all but the front."""
    assert abs(front_error(dam, dx, time, rear, threshold)) < 0.01


def test_friction_holds_the_tail():
    """On 22 degrees with friction of 25 the snow behind the fan lies still; the theory moves it backwards."""
    _, _, solver = HELD.broken(0.1, 1.0, 5.0)
    velocity, place = solver.particles.column("velocity")[:, 0], solver.particles.positions()[:, 0]
    assert velocity.min() == 0.0
    assert (velocity[place < -3.5] == 0.0).all()


class TestWetBed:
    dam = WetDam()

    @pytest.fixture(scope="class")
    def runs(self):
        return [self.dam.broken(dx, 1.0) for dx in (0.1, 0.05, 0.025)]

    def overshoot(self, dx, options):
        """Largest departure from the plateau between the rounded end of the fan and the shock, over its depth; and
        largest depth over it. Eight columns a cell: of four, there are 1.6 on the plateau, a ripple of 1.5 %."""
        x, depth, _ = self.dam.broken(dx, 1.0, options=options, per_cell=8)
        away = depth / self.dam.plateau - 1.0
        inside = x > self.dam.end_of_fan + 5.0 * dx
        return np.abs(away[inside & (x < self.dam.shock - 4.0 * dx)]).max(), away[inside].max()

    def test_depth(self, runs):
        """Of first order, the best that a shock allows. Seen: 1.95 % of 1 m times c t at dx = 0.05, orders of 0.8."""
        errors = [np.abs(depth - self.dam.depth(x, 1.0)).sum() * (x[1] - x[0]) / 3.13209 for x, depth, _ in runs]
        assert errors[1] < 0.0195
        assert order(errors).min() > 0.7

    def test_shock(self, runs):
        """Its place, where the depth is half-way. Seen: 2.3, 1.2 and 0.67 % behind."""
        assert order(self.behind(runs)).min() > 0.8

    @pytest.mark.xfail(strict=True, reason="0.67 %, since exchange at shocks reaches further")
    def test_place_of_the_shock(self, runs):
        assert self.behind(runs)[-1] < 0.0065

    def behind(self, runs):
        """Way that the shock lacks, over its own."""
        half = 0.5 * (self.dam.plateau + self.dam.ahead)
        return [1.0 - front(x, depth, half) / self.dam.shock for x, depth, _ in runs]

    @pytest.mark.parametrize("dx", [0.05, pytest.param(0.025, marks=pytest.mark.slow)])
    def test_no_oscillation(self, dx):
        """Within 2 % of the plateau's depth. Seen: 1.6 %; exchange at nodes in place of corners would let 5 % stand in
        a cell at the shock."""
        assert max(self.overshoot(dx, USUAL)) < 0.02

    @pytest.mark.parametrize("start", [0.9, pytest.param(0.8, marks=pytest.mark.xfail(
        strict=True, reason="1.15 % at 0.83 m, where the rounded end of the fan still reaches"))])
    def test_plateau(self, start):
        """Between the rounded end of the fan and the shock's spike. Seen: 0.5 %."""
        x, depth, _ = self.dam.broken(0.05, 1.0, per_cell=8)
        plateau = (x > start) & (x < 2.5)
        np.testing.assert_allclose(depth[plateau], self.dam.plateau, rtol=0.01)

    def test_momentum(self):
        """The only force along the channel is the difference of pressure on its ends, g (1 - 0.01) / 2 a metre of
        width."""
        _, _, solver = self.dam.broken(0.05, 1.0)
        gained = (solver.particles.masses() @ solver.particles.column("velocity"))[0] / (250.0 * 3 * 0.05)
        assert gained == pytest.approx(0.5 * 9.81 * 0.99, rel=2e-3)
