"""C1: samples follow from seed and index, and are as even as SciPy's."""

import numpy as np
import pytest
from scipy import stats
from scipy.stats import qmc

from snowmpm.campaigns import design
from snowmpm.campaigns.distributions import Choices, LogNormal, Normal, Uniform
from snowmpm.campaigns.members import samples
from tests.support.small_campaign import small_file


@pytest.mark.parametrize("kind", design.COUNTED)
def test_a_seed_gives_the_same_samples_and_another_seed_others(kind):
    one, again, other = (design.shares(kind, 16, 3, seed) for seed in (5, 5, 6))
    assert np.array_equal(one, again)
    assert not np.any(np.all(one == other, axis=1))
    assert one.min() >= 0.0 and one.max() <= 1.0


def test_a_random_sample_needs_its_index_only():
    few, many = design.shares("random", 5, 2, 3), design.shares("random", 50, 2, 3)
    assert np.array_equal(few, many[:5])


@pytest.mark.parametrize(("kind", "engine"), [("latin_hypercube", qmc.LatinHypercube), ("sobol", qmc.Sobol)])
def test_discrepancy_is_that_of_scipy(kind, engine):
    own = design.shares(kind, 128, 4, 11)
    reference = engine(4, **design.random_of(engine, 11)).random(128)
    independent = np.random.default_rng(11).random((128, 4))
    assert qmc.discrepancy(own) == pytest.approx(qmc.discrepancy(reference), rel=1e-12)
    assert qmc.discrepancy(own) < 0.5 * qmc.discrepancy(independent)


def test_latin_hypercube_takes_each_share_once():
    u = design.shares("latin_hypercube", 40, 3, 2)
    for column in u.T:
        assert sorted(np.floor(40 * column)) == list(range(40))


def test_grid_and_one_at_a_time():
    levels = ([0.0, 0.5, 1.0], [0.25, 0.75])
    assert design.shares("grid", None, 2, 1, levels).tolist() == [[a, b] for a in levels[0] for b in levels[1]]
    alone = design.shares("one_at_a_time", None, 2, 1, levels)
    assert len(alone) == 5 and (np.sum(alone != 0.5, axis=1) <= 1).all()


def test_correlation_of_the_normal_scores():
    u = design.correlated(design.shares("sobol", 4096, 2, 1), np.array([[1.0, -0.6], [-0.6, 1.0]]))
    scores = stats.norm.ppf(u)
    assert np.corrcoef(scores.T)[0, 1] == pytest.approx(-0.6, abs=0.01)
    assert stats.kstest(u[:, 1], "uniform").statistic < 0.02


@pytest.mark.parametrize(("parameter", "reference"), [
    (Uniform(key="a", low=2.0, high=5.0), stats.uniform(2.0, 3.0)),
    (Normal(key="a", distribution="normal", mean=3.0, deviation=2.0), stats.norm(3.0, 2.0)),
    (Normal(key="a", distribution="normal", mean=3.0, deviation=2.0, low=2.0, high=6.0),
     stats.truncnorm(-0.5, 1.5, loc=3.0, scale=2.0)),
    (LogNormal(key="a", distribution="lognormal", median=100.0, factor=1.5), stats.lognorm(np.log(1.5), scale=100.0)),
])
def test_quantiles_are_those_of_scipy_and_shares_their_inverse(parameter, reference):
    for u in (0.01, 0.3, 0.5, 0.97):
        value = parameter.quantile(u)
        assert value == pytest.approx(reference.ppf(u), rel=1e-7)
        assert parameter.share(value) == pytest.approx(u, abs=1e-6)


def test_choices_by_weight():
    parameter = Choices(key="a", distribution="choices", values=("x", "y", "z"), weights=(1.0, 2.0, 1.0))
    assert [parameter.quantile(u) for u in (0.0, 0.24, 0.26, 0.74, 0.76, 1.0)] == ["x", "x", "y", "y", "z", "z"]
    assert [parameter.quantile(u) for u in parameter.shares()] == ["x", "y", "z"]


def test_samples_of_a_file_are_those_of_its_seed():
    first, second = samples(small_file(runs=6)), samples(small_file(runs=6))
    assert first == second and first != samples(small_file(runs=6, seed=2))
    assert all(0.2 <= one["mu"] <= 0.35 and 1000.0 <= one["xi"] <= 2000.0 for one in first)
