"""Parameters from observations by approximate Bayesian computation: adaptive population Monte Carlo.

Lenormand, Jabot, Deffuant (2013), doi:10.1007/s00180-013-0428-3, algorithm 2, in the shares u of the prior, which is
uniform there:

    1. N runs from the prior (Latin hypercube); the N/2 nearest stay
    2. N/2 new runs: each from a sample that stayed, chosen by weight, moved by a normal step of twice their weighted
       covariance; its weight is 1 / sum_j w_j K(u - u_j), 0 outside the prior
    3. of all N the N/2 nearest stay; again from 2, until fewer than a share `accepted` of the new runs stays

Every generation is a set of runs of the campaign: on its workers, resumable, each with a folder. Random numbers follow
from seed, generation and number of the sample, and not from workers. The width of the posterior includes that of the
largest distance that is kept.

pyABC was not taken: which samples its dynamic samplers keep depends on the number of workers and on their speed.
"""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import multivariate_normal

from snowmpm import overwriting
from snowmpm.campaigns import cluster, forecast
from snowmpm.campaigns.design import shares
from snowmpm.campaigns.distributions import Choices, Drawn
from snowmpm.campaigns.launch import conduct_runs, prepare, silent, write_own_file
from snowmpm.campaigns.members import make_plan
from snowmpm.campaigns.observation import Observation
from snowmpm.campaigns.posterior import write_posterior
from snowmpm.campaigns.table import records_of, write_tables
from snowmpm.draft import write_text
from snowmpm.errors import InputError, SimulationError
from snowmpm.io import FolderLock
from snowmpm.quantities.quantity import digits
from snowmpm.scenes.toml import table_text

KEPT = 0.5
"""Share of the samples that stay."""

SPREAD = 2.0
"""Covariance of a step over that of the samples."""


@dataclass(frozen=True)
class Posterior:
    """names: of the parameters; values (n, d), weights (n,), distances (n,): its samples; runs, generations: of the
    search; tolerance: largest distance of a sample; accepted: share of the last generation; ranges: of the prior, by
    parameter."""

    names: list[str]
    values: np.ndarray
    weights: np.ndarray
    distances: np.ndarray
    runs: int
    generations: int
    accepted: float
    ranges: dict[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def mean(self):
        """Weighted mean (d,)."""
        return self.weights @ self.values / self.weights.sum()

    @property
    def deviation(self):
        """Weighted standard deviation (d,)."""
        return np.sqrt(self.weights @ (self.values - self.mean) ** 2 / self.weights.sum())

    def record(self) -> dict[str, Any]:
        """As plain values."""
        return {"parameters": {name: {"mean": float(mean), "deviation": float(wide)} for name, mean, wide in
                               zip(self.names, self.mean, self.deviation, strict=True)},
                "runs": self.runs, "generations": self.generations, "tolerance": float(self.distances.max()),
                "accepted": self.accepted}

    def facts(self) -> dict[str, Any]:
        """In words, for a terminal."""
        found = {name: f"{digits(mean)} ± {digits(wide)}" for name, mean, wide in
                 zip(self.names, self.mean, self.deviation, strict=True)}
        return {**found, "largest distance kept": f"{self.distances.max():.3g} deviations",
                "accepted in the last generation": f"{100 * self.accepted:.0f} %"}


class Sampler:
    """Samples (n, d) of shares, generation by generation. particles: N; seed: of all random numbers."""

    def __init__(self, d, particles, seed):
        self._d, self._particles, self._seed = d, particles, seed
        self.u, self.weights, self.distances = np.empty((0, d)), np.empty(0), np.empty(0)
        self.generation = 0

    @property
    def kept(self):
        """Number of samples that stay."""
        return max(2, int(KEPT * self._particles))

    def propose(self):
        """Shares (n, d) to be run next."""
        if self.generation == 0:
            return shares("latin_hypercube", self._particles, self._d, self._seed)
        step = self._step()
        return np.array([self._moved(k, step) for k in range(self._particles - self.kept)])

    def _step(self):
        mean = self.weights @ self.u / self.weights.sum()
        apart = self.u - mean
        covariance = (self.weights[:, None] * apart).T @ apart / self.weights.sum()
        return SPREAD * covariance + 1e-12 * np.eye(self._d)

    def _moved(self, k, step):
        rng = np.random.default_rng([self._seed, self.generation, k])
        while True:  # until it lies within the prior
            start = self.u[rng.choice(len(self.u), p=self.weights / self.weights.sum())]
            new = rng.multivariate_normal(start, step)
            if ((new >= 0.0) & (new <= 1.0)).all():
                return new

    def take(self, u, distances):
        """Take the distances (n,) of the runs at u; -> share of them that stays."""
        if self.generation == 0:
            weights = np.ones(len(u))
        else:
            step, own = self._step(), self.weights / self.weights.sum()
            density = np.array([own @ multivariate_normal.pdf(self.u, mean=one, cov=step) for one in u])
            weights = 1.0 / np.maximum(density, 1e-300)
        new = np.concatenate([np.zeros(len(self.u), bool), np.ones(len(u), bool)])
        # The weights of both generations have the same scale: that of a density in the prior
        self.u = np.concatenate([self.u, u])
        self.weights = np.concatenate([self.weights, weights])
        self.distances = np.concatenate([self.distances, distances])
        stay = np.argsort(self.distances, kind="stable")[: self.kept]
        stay = stay[np.isfinite(self.distances[stay])]
        self.u, self.weights, self.distances = self.u[stay], self.weights[stay], self.distances[stay]
        self.generation += 1
        return float(new[stay].sum() / max(len(u), 1))


def calibrate_campaign(file, folder, *, scheduler=None, workers=None, resume=False, say=silent):
    """Calibrate the parameters of a `CampaignFile`; -> `Posterior`, also written: posterior.csv, forecast.toml, tables.

    Raises InputError for a file without calibration, SimulationError when hardly any run succeeds.
    """
    folder = Path(folder).resolve()
    with FolderLock(folder) as lock, overwriting.keeping():
        return _calibrated(file, folder, (scheduler, workers), (resume, lock), say)


def _calibrated(file, folder, where, again, say):
    scheduler, workers = where
    overwriting.guard_in(folder, ("posterior.csv", "posterior.png", "forecast.toml"))
    plan, surveys = _prepared(file, folder, workers, again)
    file, observation = plan.file, Observation(file)
    names = list(file.parameters)
    wanted = file.calibration
    sampler, members, accepted = Sampler(len(names), wanted.particles, file.seed), [], 1.0
    with cluster.site(file.cluster, scheduler, workers, surveys.memory) as site:
        for generation in range(wanted.generations):
            u = sampler.propose()
            values = [{name: file.parameters[name].quantile(share) for name, share in zip(names, row, strict=True)}
                      for row in u]
            part = make_plan(file, folder, surveys.cell, values)
            conduct_runs(part, site, say)
            records = records_of(part)
            distances = np.array([observation.distance(records.get(member.hash, {}), part.results(member))
                                  for member in part.members])
            accepted = sampler.take(u, distances)
            members += [replace(member, run=len(members) + k) for k, member in enumerate(part.members)]
            if len(sampler.u) < len(names) + 1:
                raise SimulationError(f"{folder}: {len(sampler.u)} of {len(u)} runs succeeded:"
                                      " results/*/record.json says why")
            say(f"generation {generation}: {len(members)} runs, largest distance {sampler.distances.max():.3g}, new"
                f" samples kept {100 * accepted:.0f} %")
            if generation and accepted < wanted.accepted:
                break
    plan.members[:] = members
    plan.write()
    write_tables(plan, records_of(plan))
    return _written(plan, sampler, accepted, len(members))


@dataclass(frozen=True)
class _Needs:
    """memory: of a run [bytes]; cell: side of the map cells [m]."""

    memory: float
    cell: float | None


def _prepared(file, folder, workers, again):
    if file.calibration is None:
        raise InputError(f"{file.source}: calibration is missing: a table with what was observed")
    for name, one in file.parameters.items():
        if isinstance(one, Choices | Drawn):
            raise InputError(f"{file.source}: parameters.{name}.distribution = \"{one.distribution}\": calibrated are"
                             " numbers: uniform, normal or lognormal")
    if file.variants or file.correlated:
        raise InputError(f"{file.source}: variants, correlated: not of a calibration")
    Observation(file)
    runs = file.calibration.particles * (1 + file.calibration.generations) // 2
    wanted = file.model_copy(update={"design": "latin_hypercube", "runs": runs})
    wanted._base_dir, wanted._source = file.base_dir, file.source
    plan, expected = prepare(wanted, folder, workers, *again)
    write_own_file(plan.folder, wanted)
    one = forecast.survey(plan.scene(plan.members[0]), file.cluster.threads)
    return plan, _Needs(expected.memory, one.cell)


def _written(plan, sampler, accepted, runs):
    file, names = plan.file, list(plan.file.parameters)
    values = np.array([[file.parameters[name].quantile(share) for name, share in zip(names, row, strict=True)]
                       for row in sampler.u])
    ends = {name: (one.quantile(0.0 if one.bounded else 0.005), one.quantile(1.0 if one.bounded else 0.995))
            for name, one in file.parameters.items()}
    found = Posterior(names, values, sampler.weights / sampler.weights.sum(), sampler.distances, runs,
                      sampler.generation, accepted, ends)
    write_posterior(plan.folder / "posterior.csv", names, found.values, found.weights, found.distances)
    write_text(plan.folder / "forecast.toml", _forecast_text(plan))
    return found


def _forecast_text(plan):
    """A campaign that draws from the posterior."""
    file = plan.file
    data = file.model_dump(exclude_none=True, exclude_unset=True, exclude={"calibration", "parameters"})
    data |= {"name": f"{file.name}_forecast", "scene": "base.toml", "design": "latin_hypercube", "runs": 100, "set": {}}
    data["parameters"] = {name: {"key": list(one.keys), "distribution": "posterior", "file": "posterior.csv"}
                          for name, one in file.parameters.items()}
    return f"# Runs with parameters drawn from posterior.csv.\n{table_text(data)}"
