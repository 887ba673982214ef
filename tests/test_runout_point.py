"""Run-out point, thalweg and furthest deposit on made-up flows whose lengths can be counted."""

import numpy as np
import pytest
import shapely

from snowmpm.results import hazard

CELL, N = 5.0, 160
MIDDLES = CELL * (np.stack(np.indices((N, N)), axis=-1) + 0.5)


def assessed(flow, deposit, ground, release, arrival=0.0, speed=20.0):
    """`Hazard` of a flow of 1 m over cells (N, N), with a deposit of 1 m."""
    maps = {"release_depth": np.zeros((N, N)), "peak_depth": flow.astype(float), "deposit_depth": deposit.astype(float),
            "peak_speed": np.where(flow, speed, 0.0), "arrival_time": np.where(flow, arrival, 0.0),
            "peak_pressure": np.zeros((N, N))}
    return hazard.assess(maps, np.zeros(2), CELL, 0.1, {}, ground, release)


def lies_in(cells, found):
    """Whether the run-out point lies in one of the cells."""
    at = np.floor(np.array([found["runout_x"], found["runout_y"]]) / CELL).astype(int)
    return bool(cells[tuple(at)])


@pytest.mark.parametrize("angle", [0.0, 11.25, 18.0, 22.5, 30.0, 36.0, 45.0])
def test_a_straight_way_is_as_long_in_every_direction(angle):
    """Down a plane, 80 m wide: the length of the thalweg is the distance of its ends."""
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    across = np.array([-along[1], along[0]])
    u, v = (MIDDLES - 80.0) @ along, (MIDDLES - 80.0) @ across
    flow = (u > 0.0) & (u < 600.0) & (np.abs(v) < 40.0)
    corners = [80.0 + s * along + side * across for s, side in ((0.0, 20.0), (0.0, -20.0), (30.0, -20.0), (30.0, 20.0))]
    found = assessed(flow, flow & (u > 500.0), lambda plan: 900.0 - 0.5 * ((plan - 80.0) @ along),
                     shapely.Polygon(corners), u / 20.0)
    numbers, top = found.numbers, np.array([found.profile["x"][0], found.profile["y"][0]])
    end = np.array([numbers["runout_x"], numbers["runout_y"]])
    assert numbers["runout"] == pytest.approx(np.linalg.norm(end - top), rel=2e-3)
    assert (end - 80.0) @ along == pytest.approx(599.0, abs=CELL)
    assert lies_in(flow & (u > 500.0), numbers)
    assert numbers["deposit_reach"] >= numbers["runout"] and numbers["thalweg_dry"] == 0.0


def test_the_thalweg_follows_a_bend():
    """A quarter circle of 400 m radius, 40 m wide: longer than its inner edge, shorter than its outer one."""
    radius, beside = np.linalg.norm(MIDDLES - 100.0, axis=-1), MIDDLES - 100.0
    angle = np.arctan2(beside[..., 1], beside[..., 0])
    flow = (np.abs(radius - 400.0) < 20.0) & (angle > 0.0) & (angle < 0.5 * np.pi)
    found = assessed(flow, flow & (angle > 0.45 * np.pi),
                     lambda plan: 500.0 - 200.0 * np.arctan2(plan[:, 1] - 100.0, plan[:, 0] - 100.0),
                     shapely.box(480.0, 100.0, 520.0, 115.0), 20.0 * angle,
                     20.0 * np.cos((radius - 400.0) / 20.0)).numbers
    assert 380.0 < found["runout"] / (0.5 * np.pi) < 420.0
    assert found["thalweg_dry"] < 0.05 and lies_in(flow & (angle > 0.45 * np.pi), found)


def straight(y=400.0, ends=700.0):
    return (np.abs(MIDDLES[..., 1] - y) < 20.0) & (MIDDLES[..., 0] > 20.0) & (MIDDLES[..., 0] < ends)


def test_snow_that_another_release_left_beside_does_not_move_the_end():
    """A side branch stops 150 m from the main path, higher up: it counts where it joins."""
    x, y = np.moveaxis(MIDDLES, -1, 0)
    main, side = straight(), (np.abs(x - 300.0) < 20.0) & (y > 400.0) & (y < 700.0)
    arrival = np.where(main, x / 20.0, (700.0 - y) / 20.0)

    def ground(plan):
        return 1000.0 - 0.5 * plan[:, 0] + 0.4 * np.maximum(plan[:, 1] - 420.0, 0.0)

    release = shapely.unary_union([shapely.box(21.0, 385.0, 50.0, 415.0), shapely.box(285.0, 670.0, 315.0, 699.0)])
    found = assessed(main | side, (main & (x > 640.0)) | (side & (y > 600.0)), ground, release, arrival).numbers
    assert lies_in(main & (x > 640.0), found)
    assert found["runout"] == pytest.approx(699.0 - 22.0, abs=2.0 * CELL)
    assert found["thalweg_climb"] == 0.0


def test_a_hole_in_the_flow_is_passed():
    """Round a house that the flow left dry, not through it."""
    x, y = np.moveaxis(MIDDLES, -1, 0)
    house = (np.abs(x - 350.0) < 10.0) & (np.abs(y - 400.0) < 10.0)
    flow = straight() & ~house
    found = assessed(flow, flow & (x > 640.0), lambda plan: 1000.0 - 0.5 * plan[:, 0],
                     shapely.box(21.0, 385.0, 50.0, 415.0), x / 20.0)
    assert found.numbers["thalweg_dry"] < 0.05
    assert 677.0 - CELL < found.numbers["runout"] < 677.0 + 3.0 * CELL


def test_what_lies_at_its_own_release_has_no_run_out():
    """Two cells that hardly moved, and a release of one cell."""
    flow = np.zeros((N, N), bool)
    flow[50:52, 50] = True
    found = assessed(flow, flow, lambda plan: 1000.0 - 0.5 * plan[:, 0], shapely.box(250.0, 250.0, 255.0, 255.0))
    assert "runout" not in found.numbers and found.line is None


def test_a_thalweg_over_bare_ground_is_counted_as_dry():
    """A gap of 100 m that only a film thinner than what counts crossed."""
    x = MIDDLES[..., 0]
    flow = straight()
    maps = {"release_depth": np.zeros((N, N)), "peak_depth": np.where((x > 300.0) & (x < 400.0), 0.01, 1.0) * flow,
            "deposit_depth": (flow & (x > 640.0)).astype(float), "peak_speed": 20.0 * flow,
            "arrival_time": x / 20.0 * flow, "peak_pressure": np.zeros((N, N))}
    found = hazard.assess(maps, np.zeros(2), CELL, 0.1, {}, lambda plan: 1000.0 - 0.5 * plan[:, 0],
                          shapely.box(21.0, 385.0, 50.0, 415.0)).numbers
    assert found["thalweg_dry"] == pytest.approx(100.0 / 677.0, abs=0.02)


def test_a_climb_on_the_way_is_told():
    """Over a wall of 8 m across the path."""
    x = MIDDLES[..., 0]
    flow = straight()
    found = assessed(flow, flow & (x > 640.0), wall_across, shapely.box(21.0, 385.0, 50.0, 415.0), x / 20.0)
    assert found.numbers["thalweg_climb"] == pytest.approx(8.0, abs=1.0)


def wall_across(plan):
    """A slope of one in two with a wall of 8 m at x = 400 m."""
    return 1000.0 - 0.5 * plan[:, 0] + np.where(np.abs(plan[:, 0] - 400.0) < 2.5, 8.0, 0.0)
