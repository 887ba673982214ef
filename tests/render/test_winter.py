"""Winter ground: snow where the flow has not been, the bare track behind it, rock where it is steep."""

from types import SimpleNamespace

import numpy as np
import pytest

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter, Terrain
from snowmpm.render import light
from snowmpm.render.ground import bare_albedo
from snowmpm.render.relief import build_relief
from snowmpm.render.run_film import view_of
from snowmpm.render.winter import COVER, SnowCover, snow_cover

SPEED, SPACING, FRAMES, INTERVAL = 8.0, 1.0, 6, 1.0
SLOPE = 0.5


def terrain(slope=SLOPE, half=60.0):
    corners = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    return Terrain(np.column_stack([corners, -slope * corners[:, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))


def write(path, density=250.0, slope=SLOPE):
    """A block of 6 m by 10 m that slides along x from x = -30 m at SPEED, and 5 m beside it another that rests."""
    x, y = (g.ravel() for g in np.meshgrid(np.arange(-30.0, -24.0, SPACING), np.arange(-5.0, 5.0, SPACING)))
    resting = np.column_stack([x, y + 20.0])
    ground = terrain(slope)
    scene = f"[materials.snow]\nkind = 'elastic'\ndensity = {density}\n"
    with RunWriter(path, provenance={"scene_name": "block", "particle_spacing": SPACING, "scene": scene},
                   terrain=(ground.vertices, ground.facets), dimension=3, units={"velocity": "m/s"}) as writer:
        for k in range(FRAMES):
            time = k * INTERVAL
            plan = np.concatenate([np.column_stack([x + SPEED * time, y]), resting])
            velocity = np.zeros((len(plan), 3))
            velocity[: len(x), 0] = SPEED
            writer.frame(time, np.column_stack([plan, 0.5 - slope * plan[:, 0]]), {"velocity": velocity})
    return Run(path)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write(tmp_path_factory.mktemp("winter") / "run")


@pytest.fixture(scope="module")
def cover(run):
    return SnowCover.of(run, build_relief(run.terrain, np.full(2, -50.0), np.full(2, 50.0)), SPACING)


def swept_at(cover, x, y):
    return cover.swept[round((y - cover.y0) / cover.cell), round((x - cover.x0) / cover.cell)]


@pytest.mark.parametrize("x", [-20.0, -13.0, -7.0, 0.0, 10.0])
def test_a_place_is_swept_when_the_front_comes(cover, x):
    # The front begins at its last row of particles, x = -25 m; in the first interval it is looked for backwards in time
    arrival = (x + 25.0) / SPEED
    assert swept_at(cover, x, 0.0) == pytest.approx(arrival, abs=(2.0 * SPACING + 1.5 * cover.cell) / SPEED)


@pytest.mark.parametrize(("x", "y"), [(-27.0, 22.0), (25.0, 0.0), (0.0, 8.0), (-35.0, 0.0)])
def test_snow_that_rests_and_what_the_flow_did_not_reach_stays_covered(cover, x, y):
    assert np.isinf(swept_at(cover, x, y))


def test_strays_leave_no_track(tmp_path, run):
    with RunWriter(tmp_path, provenance={"particle_spacing": SPACING}, dimension=3,
                   terrain=(run.terrain.vertices, run.terrain.facets), units={"velocity": "m/s"}) as writer:
        block = np.stack(np.meshgrid(np.arange(10.0), np.arange(10.0)), axis=-1).reshape(-1, 2)
        plan = np.concatenate([block, [[30.0, 30.0]]])
        for time in (0.0, 1.0):
            writer.frame(time, np.column_stack([plan, -SLOPE * plan[:, 0]]),
                         {"velocity": np.full((len(plan), 3), 0.1)})
    cover = SnowCover.of(Run(tmp_path), build_relief(run.terrain, np.full(2, -50.0), np.full(2, 50.0)), 0.2)
    assert np.isinf(swept_at(cover, 30.0, 30.0))


def test_snow_lies_on_slopes_and_not_on_faces(cover):
    slopes = np.radians([0.0, 30.0, 38.0, 65.0, 80.0])
    normal = np.column_stack([np.sin(slopes), np.zeros(5), np.cos(slopes)])
    grain = np.full(5, 0.5)
    bare = bare_albedo(normal, grain)
    covered = cover.over(bare.copy(), grain, normal)
    assert np.allclose(covered[:3], COVER) and np.allclose(covered[3:], bare[3:])


def brightness(picture, view, x, y):
    """Mean of the pixels around a place on the ground."""
    across, down, _ = view.camera.project(np.array([[x, y, -SLOPE * x]]))
    row, column = int(down[0]), int(across[0])
    return light.decode(picture[row - 2 : row + 3, column - 2 : column + 3] / 255.0).mean()


@pytest.fixture(scope="module")
def views(run):
    return [view_of(run, (240, 136), color="snow", camera="top", ground=ground) for ground in ("auto", "summer")]


def test_track_is_bare_behind_the_flow_and_white_before_it(views):
    winter, summer = views
    first, last, without = winter.picture(0), winter.picture(FRAMES - 1), summer.picture(FRAMES - 1)
    for x in (-20.0, -10.0, -2.0):
        behind = brightness(last, winter, x, 0.0)
        assert brightness(first, winter, x, 0.0) > 1.8 * behind
        assert behind == pytest.approx(brightness(without, summer, x, 0.0), rel=0.02)  # the ground without snow
    beside = [brightness(picture, winter, -10.0, -9.0) for picture in (first, last)]
    assert beside[0] == beside[1] > 1.8 * brightness(without, summer, -10.0, -9.0)


def test_track_grows_from_nothing(views):
    ground = views[0].ground
    assert ground.at(-1.0).light.tobytes() == ground.light.tobytes()
    shares = [np.abs(ground.at(time).light - ground.light).mean() for time in (0.0, 1.0, 3.0, 5.0)]
    assert shares == sorted(shares) and shares[-1] > 3.0 * shares[1] > 0.0


@pytest.mark.parametrize(("apart", "above", "white"), [(1.2, 0.5, True), (1.6, 0.5, True), (4.0, 0.5, False),
                                                       (1.2, 6.0, False)])
def test_snow_that_stays_on_the_track_leaves_no_bare_gaps(views, apart, above, white):
    """Particles 1.2 and 1.6 spacings apart at rest where the flow went: the ground between is covered as before. Those
    4 spacings apart are strays, and those 6 above the ground fly."""
    ground = views[0].ground
    x, y = (SPACING * apart * g.ravel() for g in np.meshgrid(np.arange(-15, 0), np.arange(-6, 7)))
    lying = np.column_stack([x, y, above - SLOPE * x])
    gaps = SPACING * apart * (np.arange(-15, -1) + 0.5)
    gaps = gaps[(gaps > -20.0) & (gaps < 0.0)]
    middle = np.column_stack([gaps, np.full(len(gaps), 0.5 * apart), -SLOPE * gaps])
    across, down, _ = views[0].camera.project(middle)
    at = down.astype(int), across.astype(int)
    bare, left = (ground.at(5.0, points, SPACING).light[at].mean() for points in (None, lying))
    before = ground.at(-1.0).light[at].mean()
    assert before > 1.8 * bare
    assert left == pytest.approx(before, rel=0.03) if white else left < bare + 0.5 * (before - bare)


@pytest.mark.parametrize(("density", "slope", "winter"), [(250.0, SLOPE, True), (1600.0, SLOPE, False),
                                                          (250.0, 0.0, False)])
def test_snow_on_a_slope_is_winter_and_sand_or_a_floor_is_not(tmp_path, density, slope, winter):
    run = write(tmp_path, density, slope)
    relief = build_relief(run.terrain, np.full(2, -50.0), np.full(2, 50.0))
    assert (snow_cover(run, relief, SPACING) is not None) == winter
    assert snow_cover(run, relief, SPACING, "winter") is not None
    assert snow_cover(run, relief, SPACING, "summer") is None


def test_laboratory_and_unknown_materials_stay_bare(run):
    small = build_relief(terrain(half=4.0), np.full(2, -4.0), np.full(2, 4.0))
    assert snow_cover(run, small, SPACING) is None
    large = build_relief(run.terrain, np.full(2, -50.0), np.full(2, 50.0))
    assert snow_cover(SimpleNamespace(provenance={}), large, SPACING) is None


def test_unknown_ground_is_refused(run):
    with pytest.raises(InputError, match="ground"):
        snow_cover(run, None, SPACING, ground="spring")
