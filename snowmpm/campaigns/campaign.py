"""A campaign in its folder: what was planned, what is done, and the answers."""

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from snowmpm.annotations import Floats, PathLike
from snowmpm.campaigns import answers, untrusted
from snowmpm.campaigns.members import ONLY, Member, Plan, read_plan
from snowmpm.campaigns.spec import CampaignFile, read_campaign
from snowmpm.campaigns.stack import open_stack
from snowmpm.campaigns.table import records_of
from snowmpm.errors import InputError
from snowmpm.glance import Glance
from snowmpm.io import Run
from snowmpm.reading.toml_text import tables

if TYPE_CHECKING:  # of extras
    import pandas
    import xarray

FILE = "campaign.toml"


class Campaign(Glance):
    """A campaign, from its folder, also while it goes on.

    folder, file (`CampaignFile`), plan (members and their folders)
    table           a row a run: parameters, status, every number (pandas)
    maps            probabilities with intervals, quantiles, agreement, over y and x (xarray), or None
    stack           the maps of each run, over run, y and x (xarray), or None
    sensitivities   shares of variance and rank correlations, a row by number and parameter (pandas)
    convergence     how the maps change with the number of runs (pandas)
    failures        {name of a run: reason}
    run(i)          `snowmpm.io.Run` of run i, where it was kept

    With variants, `variant` chooses one; the first by default. Raises InputError where there is no campaign.
    """

    folder: Path
    file: CampaignFile
    plan: Plan
    variant: str

    def __init__(self, folder: PathLike, variant: str | None = None) -> None:
        self.folder = Path(folder)
        untrusted.require_no_links(self.folder)
        if not (self.folder / FILE).is_file():
            raise InputError(f"{folder}: no campaign here ({FILE} is missing)")
        self.file = read_campaign(self.folder / FILE)
        self.plan = read_plan(self.folder, self.file)
        self.variant = variant or self.plan.variants[0]
        if self.variant not in self.plan.variants:
            raise InputError.not_in("variant", self.variant, self.plan.variants, file=self.folder / FILE)

    @cached_property
    def records(self) -> dict[str, dict[str, Any]]:
        """What is known of each run that is done, by its hash."""
        return records_of(self.plan)

    @property
    def members(self) -> list[Member]:
        """Runs of the variant, in the order of the design."""
        return [member for member in self.plan.members if member.variant == self.variant]

    @cached_property
    def table(self) -> "pandas.DataFrame":
        whole = answers.table(self.plan, self.records)
        return whole if self.plan.variants == [ONLY] else whole[whole.variant == self.variant].reset_index(drop=True)

    @property
    def maps(self) -> "xarray.Dataset | None":
        return open_stack(self.folder, self.variant, "maps")

    @property
    def stack(self) -> "xarray.Dataset | None":
        return open_stack(self.folder, self.variant)

    @cached_property
    def sensitivities(self) -> "pandas.DataFrame":
        return answers.written(self.plan, self.variant, answers.SENSITIVITY)

    @cached_property
    def convergence(self) -> "pandas.DataFrame":
        return answers.written(self.plan, self.variant, answers.CONVERGENCE)

    @property
    def failures(self) -> dict[str, str]:
        found = {member.name: self.records.get(member.hash, {}) for member in self.members}
        return {name: record["reason"] for name, record in found.items() if record.get("status") == "failed"}

    @property
    def done(self) -> int:
        """Number of runs of the variant that are done."""
        return sum(self.records.get(member.hash, {}).get("status") == "done" for member in self.members)

    def run(self, i: int) -> Run:
        member = next((member for member in self.members if member.run == i), None)
        if member is None:
            raise InputError(f"{self.folder}: no run {i}; there are {len(self.members)}")
        return Run(self.plan.run(member))

    @cached_property
    def example(self) -> Run | None:
        """The first run whose folder was kept: for terrain and projection."""
        for member in self.members:
            if self.records.get(member.hash, {}).get("status") == "done" and self.plan.run(member).is_dir():
                return Run(self.plan.run(member))
        return None

    @cached_property
    def dimension(self) -> int:
        """Axes of the scene: in 2-D amounts are per metre of width."""
        path = self.plan.base(self.variant)
        try:
            return 2 if tables(untrusted.text_of(path), path).get("dimension") == 2 else 3
        except (OSError, ValueError) as error:  # of what is no text, no TOML
            raise untrusted.damaged(path, error) from None

    def values(self, name: str) -> Floats:
        """Values (runs,) of a column of the table; NaN of failed runs."""
        if name not in self.table:
            raise InputError.not_in("number", name, list(self.table), file=self.folder)
        return np.asarray(self.table[name].to_numpy(float, na_value=np.nan))

    def _glance(self) -> tuple[str, dict[str, Any]]:
        n = len(self.members)
        facts = {"folder": self.folder, "runs": f"{self.done} of {n} done" + (
            f", {len(self.failures)} failed" if self.failures else ""),
            "design": f"{self.file.design}, seed {self.file.seed}", "scene": self.file.scene,
            "parameters": ", ".join(self.file.parameters), "variants": ", ".join(self.file.variants)}
        return f"Campaign {self.file.name}", {name: text for name, text in facts.items() if text}
