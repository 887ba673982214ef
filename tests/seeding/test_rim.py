"""Columns that are divided at the free rim of a layer: widths, mass, mass centres, rims that are held."""

import numpy as np
import pytest
import shapely

from snowmpm.advice.report import advise
from snowmpm.errors import InputError
from snowmpm.running.simulation import Simulation
from snowmpm.scenes import load_scene
from snowmpm.scenes.loader import with_overrides
from snowmpm.seeding import seed_body
from snowmpm.seeding.rim import DEPTHS, Rim, counted, distance_of
from snowmpm.terrain import load_terrain
from tests.support.dam_breaks import DryDam
from tests.support.dam_scenes import dry_scene
from tests.support.tables import Table as Spec

DX = 0.5
DISC = [(20.0 + 8.0 * np.cos(a), 20.0 + 8.0 * np.sin(a)) for a in np.linspace(0.0, 2.0 * np.pi, 65)[:-1]]


def seeds(region, rim, *, angle=30.0, top=1.0, cut=None, columns=4):
    terrain = load_terrain(Spec(kind="plane", point=(0.0, 0.0, 50.0), angle=angle, azimuth=0.0),
                           extent=([0, 0], [40, 40]))
    return seed_body(Spec(kind="layer", bottom=0.0, top=top, region=region), terrain, dim=3, dx=DX,
                     particles_per_cell=columns, sampling="regular", rng=np.random.default_rng(0), columns=True,
                     rim=rim, cut=cut)


def test_widths_follow_the_law():
    """`distance_of` inverts `counted`, whose slope is one over the width."""
    s = np.concatenate([np.linspace(0.0, 0.1, 50), np.linspace(0.1, 5.0, 200)])
    number = counted(s, DX, 3.0, 0.05)
    np.testing.assert_allclose(distance_of(number, DX, 3.0, 0.05), s, atol=1e-12)
    middle, width = 0.5 * (s[1:] + s[:-1]), np.diff(s)[np.diff(s) > 0] / np.diff(number)[np.diff(s) > 0]
    law = 0.5 * DX * np.clip(np.cbrt(middle / 3.0) ** 2, 0.05, 1.0)
    np.testing.assert_allclose(width, law[np.diff(s) > 0], rtol=0.05)


@pytest.mark.parametrize("region", [Spec(x=(10.0, 25.0), y=(12.0, 20.0)), Spec(polygon=DISC)], ids=["box", "disc"])
@pytest.mark.parametrize("columns", [1, 4, 9])
def test_mass_and_mass_centre_stay(region, columns):
    whole, divided = (seeds(region, rim, columns=columns) for rim in (0.0, 0.05))
    assert len(divided.volumes) > 1.5 * len(whole.volumes)
    assert divided.volumes.sum() == pytest.approx(whole.volumes.sum(), rel=1e-12)
    centres = [part.volumes @ part.positions / part.volumes.sum() for part in (whole, divided)]
    np.testing.assert_allclose(*centres, atol=1e-9)
    assert (divided.volumes > 0.0).all()


def test_columns_lie_within_the_region():
    divided = seeds(Spec(polygon=DISC), 0.05, angle=0.0)
    assert shapely.contains_xy(shapely.Polygon(DISC).buffer(1e-6), *divided.positions[:, :2].T).all()
    away = shapely.distance(shapely.Polygon(DISC).boundary, shapely.points(divided.positions[:, :2]))
    assert away.min() < 0.05 * 0.5 * DX and np.median(away) < DEPTHS


def test_a_wall_is_no_rim():
    """Sides that cut the snow hold it: only the end at x = 25 is divided."""
    region, cut = Spec(x=(10.0, 25.0), y=(12.0, 20.0)), (np.array([10.0, 12.0, -99.0]), np.array([99.0, 20.0, 99.0]))
    whole, divided = (seeds(region, rim, angle=0.0, cut=cut) for rim in (0.0, 0.05))
    assert np.unique(np.round(divided.positions[:, 1], 9)).size == np.unique(np.round(whole.positions[:, 1], 9)).size
    near = divided.positions[:, 0] < 25.0 - DEPTHS - 0.5
    assert near.sum() == (whole.positions[:, 0] < 25.0 - DEPTHS - 0.5).sum()
    assert (~near).sum() > 2 * (len(whole.volumes) - near.sum())
    assert Rim(0.05, ((0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0))).free(
        Spec(outline=lambda: shapely.box(0, 0, 1, 1).boundary, lower=np.zeros(2), upper=np.ones(2))) is None


def test_more_columns_than_the_memory_holds_are_refused():
    """A layer of a million metres: a line of 15 m across its rim would have 3e6 columns."""
    with pytest.raises(InputError, match=r"solver\.depth\.rim"):
        seeds(Spec(x=(10.0, 25.0), y=(12.0, 20.0)), 1e-6, top=1e9)


def test_a_rim_without_a_layer_of_one_thickness_is_refused():
    """It would do nothing, without a word."""
    scene = dry_scene(DryDam(), 0.2, 1.0, 6.0, rim=0.05)
    box = {"kind": "box", "min": [-6.0, 0.0, 0.0], "max": [0.0, 0.6, 1.0]}
    with pytest.raises(InputError, match="acts on layers of one thickness"):
        Simulation(with_overrides(scene, {"bodies": [{"name": "snow", "material": "snow", "shape": box}]}))


def test_check_names_layers_deeper_than_a_cell():
    """Its advice is accepted, and then it is silent; a release thinner than its cells is not named."""
    scene = dry_scene(DryDam(), 0.2, 1.0, 6.0)
    said = [caution for caution in advise(scene).cautions if caution.key == "solver.depth.rim"]
    assert len(said) == 1 and "deeper than a cell" in said[0].says
    key, value = said[0].cure.split(" = ")
    again = with_overrides(scene, {key: float(value)})
    assert not [caution for caution in advise(again).cautions if caution.key == key]
    assert not [c for c in advise(load_scene("avalanche_depth_averaged")).cautions if c.key == key]
