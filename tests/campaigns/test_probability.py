"""C4: the share of runs above a limit is a count, with the exact binomial interval."""

import numpy as np
import pytest
from scipy.stats import binomtest

from snowmpm.campaigns import convergence
from snowmpm.campaigns.launch import run_campaign
from snowmpm.campaigns.probability import interval
from tests.support.small_campaign import small_file

pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def campaign(site, tmp_path_factory):
    """Ten runs on the workers of all tests."""
    folder = tmp_path_factory.mktemp("campaign") / "small"
    return run_campaign(small_file(runs=10), folder, scheduler=site.client.scheduler.address, workers=2)


def test_probability_is_a_count_by_hand(campaign):
    stack, maps = campaign.stack, campaign.maps
    for name, raster in (("depth", "peak_depth"), ("speed", "peak_speed"), ("pressure", "peak_pressure")):
        for k, limit in enumerate(maps[f"{name}_limit"].values):
            by_hand = np.zeros(maps.agreement.shape)
            for i in range(10):
                run = campaign.run(i)
                own = run.to_xarray("maps")[raster].fillna(0.0).reindex(y=maps.y, x=maps.x, fill_value=0.0)
                by_hand += own.values >= np.float32(limit)
            assert np.array_equal(maps[f"{name}_probability"].values[k], by_hand / 10)
    assert 0.0 < float(maps.depth_probability[0].mean()) < 1.0
    middle = np.quantile(stack.peak_depth.values, 0.5, axis=0)
    assert np.array_equal(maps.depth_quantile.sel(quantile=0.5).values, middle.astype(np.float32))
    share = maps.depth_probability.values[0]
    assert np.allclose(maps.agreement.values, np.maximum(share, 1.0 - share))


@pytest.mark.parametrize(("k", "n"), [(0, 10), (3, 10), (10, 10), (1, 200), (117, 200)])
def test_interval_is_that_of_scipy(k, n):
    low, high = interval(np.array([k]), n)
    exact = binomtest(k, n).proportion_ci(0.95, method="exact")
    assert (low[0], high[0]) == pytest.approx((exact.low, exact.high), abs=1e-12)


def test_interval_in_the_maps(campaign):
    maps = campaign.maps
    count = np.round(10 * maps.depth_probability.values).astype(int)
    low, high = interval(count, 10)
    assert np.allclose(maps.depth_probability_low.values, low) and np.allclose(maps.depth_probability_high.values, high)


def test_table_holds_every_number(campaign):
    table = campaign.table
    assert list(table.run) == list(range(10)) and (table.status == "done").all()
    for i in (0, 9):
        numbers = campaign.run(i).hazard["numbers"]
        assert table.runout[i] == numbers["runout"] and table.affected_area[i] == numbers["affected_area"]
    # More friction, less run-out: the parameters have reached the runs
    assert np.corrcoef(table.mu, table.runout)[0, 1] < -0.5


def test_files_hold_the_same(campaign):
    import pandas

    parquet, csv = (read(campaign.folder / name) for read, name in ((pandas.read_parquet, "table.parquet"),
                                                                    (pandas.read_csv, "table.csv")))
    for name in ("mu", "xi", "runout"):
        assert np.array_equal(parquet[name], campaign.table[name]) and np.array_equal(csv[name], campaign.table[name])


def test_geotiffs_lie_where_the_maps_do(campaign, tmp_path):
    rasterio = pytest.importorskip("rasterio")
    from snowmpm.campaigns.geotiff import write_geotiffs

    paths = {path.name: path for path in write_geotiffs(campaign, tmp_path)}
    with rasterio.open(paths["depth_probability_0.5.tif"]) as file:
        values, transform = file.read(1), file.transform
    maps = campaign.maps
    assert np.allclose(values[::-1], maps.depth_probability.sel(depth_limit=0.5).values)
    assert (transform.c, transform.f) == (float(maps.x[0]) - 10.0, float(maps.y[-1]) + 10.0)


def test_convergence_ends_at_all_runs(campaign):
    rows = campaign.convergence.to_dict("records")
    last = [row for row in rows if row["runs"] == 10]
    assert last and all(row["difference"] == 0.0 for row in last)
    widths = [row["half_width"] for row in rows if row["quantity"] == "depth"]
    assert widths == sorted(widths, reverse=True)
    assert all(n > 10 for n in convergence.enough(rows).values())
