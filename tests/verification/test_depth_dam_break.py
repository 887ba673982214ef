"""Dams that break, as scenes, against the theory of shallow flow: on the flat (D2, Ritter), on a wet bed (D3, Stoker),
on a slope with friction (D4). Each with the usual settings, and with those that resolve it."""

import numpy as np
import pytest

import snowmpm
from tests.support.dam_breaks import DryDam, WetDam
from tests.support.dam_scenes import dry_scene, profile_of, wet_scene
from tests.support.depth_flows import front, order

RITTER, STEEP, HELD = DryDam(), DryDam(30.0, 20.0), DryDam(22.0, 25.0)
SPACINGS = (0.2, 0.1, 0.05)
NARROW = {"rim": 0.05}
"""Of [solver.depth]: columns at the dam narrow enough for the depth at which fronts are told."""


@pytest.fixture(scope="module")
def profiles(tmp_path_factory):
    """profiles(dam, dx, time, rear, rim=...): x and depth at the end of a scene; each is run once."""
    made = {}

    def of(dam, dx, time, rear, **depth):
        key = dam, dx, time, rear, *depth.items()
        if key not in made:
            run = snowmpm.run(dry_scene(dam, dx, time, rear, **depth), tmp_path_factory.mktemp("dam"))
            made[key] = profile_of(run, dx, dam.slope)
        return made[key]

    return of


def dry_error(dam, profile, dx, time):
    """L1 error of the depth from a metre behind the fan, over the depth behind the dam times c t [-]."""
    x, depth = profile
    fan = x > dam.place(1.0, time) - 1.0
    return np.abs(depth - dam.depth(x, time))[fan].sum() * dx / (np.sqrt(dam.g_z) * time)


def front_error(dam, profile, time, threshold):
    """Of the place at which the flow is `threshold` [m] deep, relative."""
    return front(*profile, threshold) / dam.place(threshold, time) - 1.0


@pytest.mark.parametrize(("dam", "rear", "gate"), [
    pytest.param(RITTER, 6.0, 0.015, marks=pytest.mark.xfail(strict=True, reason="1.56 %")),
    pytest.param(STEEP, 8.0, 0.0195, marks=pytest.mark.xfail(strict=True, reason="1.96 %"))], ids=["D2", "D4"])
def test_depth_of_the_fan(dam, rear, gate, profiles):
    """At 20 cells of the depth behind the dam: what columns that a test graded by hand met on the solver's own nodes.
    By usual columns 6.3 and 6.7 %."""
    assert dry_error(dam, profiles(dam, 0.05, 1.0, rear, rim=0.02), 0.05, 1.0) < gate


@pytest.mark.parametrize(("dam", "rear"), [(RITTER, 6.0), (STEEP, 8.0)], ids=["D2", "D4"])
def test_order(dam, rear, profiles):
    """First order, since slope and curvature of the depth jump at both ends of the fan."""
    errors = [dry_error(dam, profiles(dam, dx, 1.0, rear, rim=0.02), dx, 1.0) for dx in SPACINGS]
    assert order(errors).min() > 0.8


FRONTS = [
    (RITTER, 1.0, 0.025, 6.0, 0.05),
    (STEEP, 1.0, 0.025, 8.0, 0.05),
    pytest.param(HELD, 1.0, 0.025, 5.0, 0.03, marks=pytest.mark.xfail(strict=True, reason="1.03 %")),
    pytest.param(HELD, 1.0, 0.0125, 5.0, 0.03, marks=pytest.mark.slow),
    pytest.param(STEEP, 2.0, 0.05, 12.0, 0.05, marks=pytest.mark.slow),
    pytest.param(HELD, 2.0, 0.025, 9.0, 0.03, marks=pytest.mark.slow)]


@pytest.mark.parametrize(("dam", "time", "dx", "rear", "threshold"), FRONTS)
def test_front(dam, time, dx, rear, threshold, profiles):
    """Within 1 %, by a depth of a twentieth of that behind the dam; on 22 degrees with friction of 25 of 0.03, since
    the theory's tail moves backwards there, where friction holds ours, and so deepens all but the front."""
    assert abs(front_error(dam, profiles(dam, dx, time, rear, **NARROW), time, threshold)) < 0.01


USUAL = {"D2": (RITTER, 6.0, 0.05), "30 degrees": (STEEP, 8.0, 0.05), "22 degrees": (HELD, 5.0, 0.03)}


@pytest.mark.xfail(strict=True, reason="+15, +11 and +6 %: lone columns are as deep as the threshold")
@pytest.mark.parametrize("case", USUAL)
def test_front_of_usual_columns(case, profiles):
    """The same gate at the usual settings."""
    dam, rear, threshold = USUAL[case]
    assert abs(front_error(dam, profiles(dam, 0.025, 1.0, rear), 1.0, threshold)) < 0.01


LONE = {("D2", 0.025): (0.167,), ("22 degrees", 0.05): (-0.096,), ("22 degrees", 0.025): (0.044, 0.037)}
"""Fronts of usual columns that a single column makes, whose place round-off decides: what they are on an AMD EPYC and
on a second Intel Xeon. The table has those of a first Xeon."""


@pytest.mark.parametrize(("case", "usual", "narrow"), [
    ("D2", (-0.116, 0.026, 0.149), (-0.025, -0.015, -0.008)),
    ("30 degrees", (-0.084, -0.004, 0.110), (-0.039, -0.018, -0.008)),
    ("22 degrees", (-0.214, -0.084, 0.056), (-0.082, -0.028, -0.010))])
def test_fronts_of_the_guide(case, usual, narrow, profiles):
    """The table of docs/depth_averaged.md; what it rounds to per cent. `LONE` fronts move with the processor."""
    dam, rear, threshold = USUAL[case]
    for dx, errors in zip((0.1, 0.05, 0.025), zip(usual, narrow, strict=True), strict=True):
        found = [front_error(dam, profiles(dam, dx, 1.0, rear, **keys), 1.0, threshold) for keys in ({}, NARROW)]
        known = (errors[0], *LONE.get((case, dx), ()))
        usual_front = min(known, key=lambda front: abs(found[0] - front))
        assert found[0] == pytest.approx(usual_front, abs=0.006), dx
        assert found[1] == pytest.approx(errors[1], abs=0.006), dx


def test_friction_holds_the_tail(tmp_path):
    """On 22 degrees with friction of 25 the snow behind the fan lies still; the theory moves it backwards."""
    frame = snowmpm.run(dry_scene(HELD, 0.1, 1.0, 5.0), tmp_path).frame(-1)
    velocity = frame.fields["velocity"][:, 0]
    assert velocity.min() == 0.0
    assert (velocity[frame.points[:, 0] < -3.5] == 0.0).all()


class TestWetBed:
    dam = WetDam()

    @pytest.fixture(scope="class")
    def runs(self, tmp_path_factory):
        """runs(dx, columns a cell): x and depth; the usual 4 when missing."""
        made = {}

        def of(dx, columns=None):
            if (dx, columns) not in made:
                more = {"particles_per_cell": columns} if columns else {}
                run = snowmpm.run(wet_scene(dx, 1.0, self.dam.ahead, **more), tmp_path_factory.mktemp("wet"))
                made[dx, columns] = profile_of(run, dx)
            return made[dx, columns]

        return of

    def overshoot(self, profile, dx):
        """Largest departure from the plateau between the rounded end of the fan and the shock, over its depth; and
        largest depth over it."""
        x, depth = profile
        away = depth / self.dam.plateau - 1.0
        inside = x > self.dam.end_of_fan + 5.0 * dx
        return np.abs(away[inside & (x < self.dam.shock - 4.0 * dx)]).max(), away[inside].max()

    def error(self, profile, dx):
        x, depth = profile
        inside = (x > -6.0 + dx) & (x < 8.0 - dx)
        return np.abs(depth - self.dam.depth(x, 1.0))[inside].sum() * dx / 3.13209

    def behind(self, profile):
        """Way that the shock lacks, over its own."""
        return 1.0 - front(*profile, 0.5 * (self.dam.plateau + self.dam.ahead)) / self.dam.shock

    def test_depth(self, runs):
        """Of first order, the best that a shock allows; eight columns a cell along the channel."""
        assert order([self.error(runs(dx, 64), dx) for dx in (0.1, 0.05, 0.025)]).min() > 0.7

    @pytest.mark.xfail(strict=True, reason="2.00 %")
    def test_error_of_the_depth(self, runs):
        """What the solver's own nodes met, with columns by hand."""
        assert self.error(runs(0.05, 64), 0.05) < 0.0195

    def test_shock(self, runs):
        """Its place, where the depth is half-way."""
        assert order([self.behind(runs(dx, 16)) for dx in (0.1, 0.05, 0.025)]).min() > 0.8

    @pytest.mark.xfail(strict=True, reason="0.67 %, since exchange at shocks reaches further")
    def test_place_of_the_shock(self, runs):
        assert self.behind(runs(0.025, 16)) < 0.0065

    @pytest.mark.parametrize("dx", [0.05, pytest.param(0.025, marks=pytest.mark.slow)])
    def test_no_oscillation(self, dx, runs):
        """Within 2 % of the plateau's depth, with eight columns a cell along the channel: exchange at nodes in place of
        corners would let 5 % stand in a cell at the shock."""
        assert max(self.overshoot(runs(dx, 64), dx)) < 0.02

    @pytest.mark.xfail(strict=True, reason="5.7 %: 0.8 columns a cell along the channel on the plateau")
    def test_no_oscillation_of_usual_columns(self, runs):
        assert max(self.overshoot(runs(0.05), 0.05)) < 0.02

    def test_usual_columns(self, runs):
        """2.4 % for 1.9 of the depth, the shock within 1.5 %."""
        assert self.error(runs(0.05), 0.05) < 0.026
        assert abs(self.behind(runs(0.05))) < 0.015

    @pytest.mark.parametrize("start", [0.9, pytest.param(0.8, marks=pytest.mark.xfail(
        strict=True, reason="1.15 % at 0.83 m, where the rounded end of the fan still reaches"))])
    def test_plateau(self, start, runs):
        """Between the rounded end of the fan and the shock's spike."""
        x, depth = runs(0.05, 64)
        plateau = (x > start) & (x < 2.5)
        np.testing.assert_allclose(depth[plateau], self.dam.plateau, rtol=0.01)

    def test_momentum(self, tmp_path):
        """The only force along the channel is the difference of pressure on its ends, g (1 - 0.01) / 2 a metre of
        width."""
        run = snowmpm.run(wet_scene(0.05, 1.0, self.dam.ahead), tmp_path)
        momentum = run.history["total_momentum"][-1]
        assert momentum / (250.0 * 3 * 0.05) == pytest.approx(0.5 * 9.81 * 0.99, rel=2e-3)
