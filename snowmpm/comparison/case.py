"""A run to be compared: its problem, method and cost."""

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.io.parameters import method_of, methods_of
from snowmpm.io.scenario import HASH, scenario_of
from snowmpm.methods import METHODS
from snowmpm.schemes import TRANSFERS


@dataclass(frozen=True)
class Case:
    """A run under a label; scene: the tables of its resolved scene, as TOML gives them."""

    label: str
    run: Run

    @cached_property
    def scene(self):
        return self.run.scene

    @property
    def axes(self):
        """Columns of a frame's points that are the scene's axes, the last one up."""
        return [0, 2] if self.run.dimension == 2 else [0, 1, 2]

    @cached_property
    def body(self):
        """Table of the first body."""
        return self.scene["bodies"][0]

    @cached_property
    def material(self):
        """Table of the first body's material."""
        return self.scene["materials"][self.body["material"]]

    @cached_property
    def gravity(self):
        """Acceleration (dim,) [m/s2]."""
        given = self.scene["gravity"]
        given = given["value"] if isinstance(given, dict) else given
        if isinstance(given, list):
            return np.array(given, float)
        return np.array([0.0] * (self.run.dimension - 1) + [-given])

    @property
    def method(self):
        """Name of `snowmpm.methods.METHODS`."""
        return self.scene["solver"]["method"]

    @property
    def in_plan(self):
        """Whether its particles are columns in plan at the end, each with its depth."""
        entry = method_of(self.run, last=True)
        return entry is not None and entry.capabilities.plan and "depth" in self.run.field_names

    @property
    def dx(self):
        """Spacing of the grid (mpm) or of the particles (sph) [m]."""
        return self.run.provenance["dx"]

    @property
    def spacing(self):
        """Distance of particles at the start [m], of several methods with the last."""
        records = methods_of(self.run)
        return records[-1]["particle_spacing"] if records else self.run.provenance["particle_spacing"]

    @property
    def damping(self):
        """Numerical dissipation of the method, on which run-outs depend: viscosities of sph (alpha of the
        artificial one, beta of its quadratic part, gamma against disorder), transfer and share of FLIP of mpm."""
        solver = self.scene["solver"]
        if self.method == "sph":
            own = solver["sph"]
            keys = {"viscosity": "alpha", "quadratic_viscosity": "beta", "disorder_damping": "gamma"}
            # A key unknown to the run's version was not used
            named = [f"{name} {own[key]:g}" for key, name in keys.items() if own.get(key, 0.0) > 0.0]
            return ", ".join(named) or "none"
        entry = METHODS.get(self.method)
        if entry is None or not entry.capabilities.grid:
            return "not known"
        blend = f" {solver['flip_ratio']:g}" if TRANSFERS[solver["transfer"]].flip else ""
        return solver["transfer"] + blend

    @property
    def steps(self):
        return int(self.run.history["steps"][-1])

    @property
    def wall_time(self):
        """[s]; NaN for an unfinished run."""
        return float(self.run.summary.get("wall_time", np.nan))

    def frame_at(self, time):
        """Index of the frame nearest to a time [s]."""
        return int(np.argmin(np.abs(self.run.times - time)))

    def positions(self, frame):
        """Positions (n, dim) [m] of a `Frame`, in the scene's coordinates."""
        return (np.asarray(frame.points, float) + self.run.origin)[:, self.axes]

    def volumes(self, frame):
        """Volume of each particle (n,) at rest density [m3], per metre of width in 2-D."""
        if "volume" in frame.fields and "J" in frame.fields:
            return frame.fields["volume"] / frame.fields["J"]
        return np.full(len(frame), self.spacing ** self.run.dimension)

    def needs(self, *fields):
        """Raise InputError for a run whose frames lack one of these fields."""
        for name in fields:
            if name not in self.run.field_names:
                raise InputError(f"{self.run.path}: frames hold no {name}: run the scene with {name} in output.fields")


def open_cases(paths):
    """`Case`s of run folders or files, labelled by what tells their paths apart. Raises InputError where there is no
    run with a frame and a history, or for runs of different dimension."""
    cases = [Case(label, Run(path)) for label, path in zip(_labels(paths), paths, strict=True)]
    for case in cases:
        if len(case.run) == 0 or len(case.run.history["time"]) < 2:
            raise InputError(f"{case.run.path}: nothing to compare yet: no frame after the first")
        if case.run.dimension != cases[0].run.dimension:
            raise InputError(f"{case.run.path}: a {case.run.dimension}-D run; {cases[0].run.path} is"
                             f" {cases[0].run.dimension}-D, and both must be the same")
    return cases


def _labels(paths):
    """Names of the run folders, with as many folders above as it takes to tell them apart."""
    folders = [Path(path) if Path(path).is_dir() or Path(path).suffix == "" else Path(path).parent for path in paths]
    varied = [scenario_of(folder) for folder in folders]
    if len(set(varied)) == len(varied) and all(HASH.fullmatch(Path(folder).resolve().name) for folder in folders):
        return varied  # of one campaign: what varies there tells more than a hash
    parts = [Path(os.path.abspath(folder)).parts for folder in folders]
    for depth in range(1, max(map(len, parts)) + 1):
        labels = ["/".join(own[-depth:]) for own in parts]
        if len(set(labels)) == len(labels):
            return labels
    return [f"{own[-1]} ({i + 1})" for i, own in enumerate(parts)]
