"""The file of a campaign: base scene, parameters, design, what is mapped, where it runs, what was observed."""

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, model_validator

from snowmpm.annotations import Floats
from snowmpm.campaigns.design import COUNTED, RANDOM
from snowmpm.campaigns.distributions import AnyParameter, Choices, Drawn, Scenarios
from snowmpm.errors import did_you_mean
from snowmpm.quantities.table import QUANTITIES
from snowmpm.scenes.file_spec import FileSpec
from snowmpm.scenes.spec import Name, NonNegative, Number, Positive, Spec, refuse

RESERVED = ("run", "variant", "hash", "status", "reason", "final", "complete", "weight")
"""Columns of the table that are no parameters."""

Count = Annotated[int, Field(strict=True, ge=1, le=10_000_000)]


class Correlation(Spec):
    """Two parameters that vary together (correlation of their normal scores)."""

    EXAMPLES: ClassVar = {"parameters": ["mu", "xi"], "coefficient": -0.5}

    parameters: Annotated[tuple[Name, ...], Field(min_length=2, max_length=2)]
    """names of the two"""
    coefficient: Annotated[Number, Field(gt=-1.0, lt=1.0)]
    """coefficient of correlation [-]"""


class Variant(Spec):
    """The same design once more with another method or grid: its first runs."""

    EXAMPLES: ClassVar = {"set": {"solver.method": "mpm", "solver.dx": 2.5}}

    runs: Count | None = None
    """first runs of the design; all when missing"""
    set: dict[str, Any] = Field(default_factory=dict)
    """changes of the scene, as of `--set`"""


class Maps(Spec):
    """What is mapped over all runs."""

    cell: Positive | None = None
    """side of a cell [m]; when missing, one that suits the base scene"""
    depth: tuple[Positive, ...] = (0.5, 1.0)
    """depths whose exceedance is mapped [m]"""
    speed: tuple[Positive, ...] = (5.0, 20.0)
    """speeds [m/s]"""
    pressure: tuple[Positive, ...] = (1e3, 3e3, 10e3, 30e3)
    """pressures [Pa]"""
    quantiles: Annotated[tuple[Annotated[Number, Field(gt=0.0, lt=1.0)], ...], Field(min_length=1)] = (0.05, 0.5, 0.95)
    """of peak depth, speed and pressure"""


Word = Annotated[str, Field(strict=True, pattern=r"^[A-Za-z0-9][A-Za-z0-9_.:,=@+/-]{0,99}$")]
"""A value on a line of a job script: no spaces, quotes or new lines, so that it cannot become a line or a command."""


class Slurm(Spec):
    """What a job of SLURM asks for. No other lines can be added to the job's script: a campaign may come from anybody.
    """

    EXAMPLES: ClassVar = {
        "queue": "standard",
        "account": "snow",
        "cores": 4,
        "walltime": "02:00:00",
        "interface": "ib0",
        "qos": "normal",
        "constraint": "haswell",
        "gres": "gpu:1",
        "reservation": "winter",
    }

    queue: Word | None = None
    """partition"""
    account: Word | None = None
    """account that pays"""
    cores: Count | None = None
    """of a job; the threads of a run when missing"""
    memory: Annotated[str, Field(strict=True, pattern=r"^[0-9]{1,6} ?[KMGT]i?B$")] = "4 GiB"
    """memory of a job"""
    walltime: Annotated[str, Field(strict=True, pattern=r"^([0-9]{1,3}-)?[0-9]{1,3}(:[0-9]{2}){1,2}$")] | None = None
    """hours:minutes:seconds, or days-hours:minutes:seconds"""
    interface: Word | None = None
    """network interface of the workers"""
    qos: Word | None = None
    """quality of service"""
    constraint: Annotated[str, Field(strict=True, pattern=r"^[A-Za-z0-9_.&|,()-]{1,100}$")] | None = None
    """features of the nodes"""
    gres: Word | None = None
    """generic resources, such as gpu:1"""
    reservation: Word | None = None
    """name of a reservation"""

    @property
    def directives(self) -> list[str]:
        """Lines of the job's script that dask-jobqueue has no option for."""
        named = {name: self[name] for name in ("qos", "constraint", "gres", "reservation")}
        return [f"--{name}={value}" for name, value in named.items() if value is not None]


class Cluster(Spec):
    """Where it runs. Options of the command line replace these."""

    EXAMPLES: ClassVar = {"workers": 4}

    workers: Count | None = None
    """worker processes; as many as there are cores when missing"""
    threads: Count = 1
    """of each run"""
    backend: Literal["cpu", "cuda"] = "cpu"
    """with "cuda", workers have the Dask resource GPU = 1, and each run takes it"""
    slurm: Slurm = Slurm()


class FrontTime(Spec):
    """When the flow arrived at a place."""

    x: Number
    """easting of the place [m]"""
    y: Number
    """northing of the place [m]"""
    time: NonNegative
    """when the flow arrived [s]"""
    deviation: Positive
    """standard deviation of that [s]"""


class Measured(Spec):
    """A number that was observed, and its standard deviation."""

    value: Number
    """what was observed, in the unit of its key"""
    deviation: Positive
    """its standard deviation"""


class Outline(Spec):
    """The outline of the avalanche."""

    file: Annotated[str, Field(strict=True, min_length=1)]
    """polygon (.shp, .geojson, .gpkg), relative to the campaign's file"""
    deviation: Positive = 0.1
    """of 1 - critical success index [-]"""


class Observed(Spec):
    """What was observed of the avalanche; at least one."""

    EXAMPLES: ClassVar = {"event": "ryggfonn_2021"}

    event: Name | None = None
    """an observed avalanche (`snowmpm events`): the distance of a run is its misfit; nothing else beside it"""
    runout: Measured | None = None
    """[m], as `snowmpm maps --definitions` defines it"""
    deposit_volume: Measured | None = None
    """[m3]"""
    outline: Outline | None = None
    front_times: tuple[FrontTime, ...] = ()

    @model_validator(mode="after")
    def _any(self):
        others = self.runout or self.deposit_volume or self.outline or self.front_times
        if not (others or self.event):
            raise refuse("must hold at least one of event, runout, deposit_volume, outline, front_times")
        if others and self.event:
            raise refuse("does not go with other observations: it has its own", "event", self.event)
        return self


class Calibration(Spec):
    """Approximate Bayesian computation with these parameters as the prior (`snowmpm.campaigns.calibration`)."""

    observed: Observed
    particles: Annotated[int, Field(strict=True, ge=8, le=1_000_000)] = 60
    """samples of the posterior, and twice the runs of a generation after the first"""
    generations: Annotated[int, Field(strict=True, ge=1, le=100)] = 8
    """at most"""
    accepted: Annotated[Number, Field(gt=0.0, lt=1.0)] = 0.1
    """share of accepted runs below which it ends"""


class CampaignFile(FileSpec):
    """A campaign. Paths are relative to its file."""

    EXAMPLES: ClassVar = {"set": {"solver.dx": 10.0}}

    name: Name
    """also the name of the default output folder"""
    scene: Annotated[str, Field(strict=True, min_length=1)]
    """base scene: a library name, or a TOML file"""
    seed: Annotated[int, Field(strict=True, ge=0, lt=2**32)] = 1
    """of the design"""
    design: Literal["latin_hypercube", "sobol", "random", "saltelli", "grid", "one_at_a_time"] = "latin_hypercube"
    """how the values of the parameters are chosen; saltelli: for Sobol's sensitivities; one_at_a_time: from the
    middle"""
    runs: Count | None = None
    """number of runs; saltelli: of its base, a power of 2; not of a grid or one_at_a_time"""
    set: dict[str, Any] = Field(default_factory=dict)
    """changes of the base scene in all runs, as of `--set`: "solver.dx" = 10.0"""
    parameters: Annotated[dict[Name, AnyParameter], Field(min_length=1)]
    """one table a parameter"""
    correlated: tuple[Correlation, ...] = ()
    variants: dict[Name, Variant] = Field(default_factory=dict)
    """methods or grids to be mixed: each runs the first runs of the same design"""
    maps: Maps = Maps()
    cluster: Cluster = Cluster()
    keep: Literal["runs", "results"] = "runs"
    """what stays of a run: its folder, or only its numbers and maps"""
    calibration: Calibration | None = None

    @model_validator(mode="after")
    def _fits(self):
        counted = self.design in COUNTED
        if counted and self.runs is None:
            raise refuse(f"is missing: design = \"{self.design}\" needs a number of runs", "runs")
        if not counted and self.runs is not None:
            raise refuse(f'does not go with design = "{self.design}", whose runs follow from levels', "runs",
                         self.runs)
        if self.design == "saltelli" and self.runs & (self.runs - 1):
            raise refuse("must be a power of 2 with design = \"saltelli\"", "runs", self.runs)
        for name, parameter in self.parameters.items():
            if name in RESERVED or name in QUANTITIES:
                raise refuse("is the name of a column of results: take another", f"parameters.{name}", name)
            if isinstance(parameter, Scenarios) and self.calibration:
                raise refuse("does not go with a calibration, which searches numbers",
                             f"parameters.{name}.distribution", "scenarios")
            if isinstance(parameter, Drawn) and self.design not in (*RANDOM, "saltelli"):
                raise refuse(f"does not go with design = \"{self.design}\"", f"parameters.{name}.distribution",
                             "posterior")
        if self.correlated:
            if self.design not in RANDOM:
                raise refuse(f"needs design = {' or '.join(RANDOM)}", "correlated", [len(self.correlated)])
            self.correlations()
        return self

    def correlations(self) -> Floats:
        """Matrix (d, d) of the correlations of the parameters."""
        names = list(self.parameters)
        matrix = np.eye(len(names))
        for i, one in enumerate(self.correlated):
            for name in one.parameters:
                if name not in names or isinstance(self.parameters[name], Choices | Drawn):
                    raise refuse(f"must be two of the parameters with numbers{did_you_mean(name, names)}",
                                 f"correlated.{i}.parameters", list(one.parameters))
            j, k = (names.index(name) for name in one.parameters)
            matrix[j, k] = matrix[k, j] = one.coefficient
        if np.linalg.eigvalsh(matrix).min() <= 1e-10:
            raise refuse("contradict each other: no such distribution exists", "correlated",
                         [one.coefficient for one in self.correlated])
        return matrix


def read_campaign(path):
    """`CampaignFile` from a TOML file; InputError, which names file, key, value and what is allowed."""
    return CampaignFile.read(path, "campaign")
