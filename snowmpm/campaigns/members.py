"""The runs of a campaign: their values, their scenes, and the folders named by the hash of each scene."""

import contextlib
import hashlib
import json
import math
import tempfile
import warnings
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from snowmpm import __version__, plugins
from snowmpm.annotations import PathLike
from snowmpm.campaigns import design, untrusted
from snowmpm.campaigns.distributions import Drawn
from snowmpm.campaigns.inputs import Inputs
from snowmpm.campaigns.posterior import rows_of
from snowmpm.campaigns.spec import CampaignFile
from snowmpm.draft import write_text
from snowmpm.errors import InputError
from snowmpm.scenes.loader import find_scene, load_scene, override
from snowmpm.scenes.schema import Scene
from snowmpm.scenes.toml import parse, table_text
from snowmpm.stages import counted

PLAN = "plan.json"
ONLY = "base"
"""Name of the only variant of a campaign without variants."""


@dataclass(frozen=True)
class Member:
    """One run: number `run` of `variant`; values: by parameter; changes: of the base scene, by key; hash: of the whole
    scene, the content of its files, the program's version and the plugins."""

    variant: str
    run: int
    values: dict[str, Any]
    changes: dict[str, Any]
    hash: str = ""

    @property
    def name(self) -> str:
        """In words, for messages."""
        values = ", ".join(f"{name} = {_shown(value)}" for name, value in self.values.items())
        where = "" if self.variant == ONLY else f"{self.variant}, "
        return f"{where}run {self.run} ({values})"


def _shown(value):
    return f"{value:g}" if isinstance(value, float) else str(value)


def samples(file):
    """Values of the parameters of a `CampaignFile`: a list of dicts, one a row of its design."""
    names, drawn = list(file.parameters), {}
    columns = []  # of the design, by parameter: rows of one posterior file share a column
    for name in names:
        parameter = file.parameters[name]
        key = ("file", parameter.file) if isinstance(parameter, Drawn) else ("name", name)
        if key not in columns:
            columns.append(key)
        drawn[name] = columns.index(key)
    levels = [file.parameters[key[1]].shares() for key in columns if key[0] == "name"] if file.runs is None else ()
    u = design.shares(file.design, file.runs, len(columns), file.seed, levels)
    if file.correlated:
        if len(columns) != len(names):
            raise InputError(f"{file.source}: correlated: does not go with a posterior, whose rows are correlated")
        u = design.correlated(u, file.correlations())
    quantile = {}
    for name in names:
        parameter = file.parameters[name]
        where = f"{file.source}: parameters.{name}"
        quantile[name] = (rows_of(file.base_dir / parameter.file, parameter.column or name, where)
                          if isinstance(parameter, Drawn) else parameter.quantile)
    return [{name: quantile[name](float(row[drawn[name]])) for name in names} for row in u]


class Plan:
    """The runs of a campaign in its folder. members: list of `Member`; file: its `CampaignFile`."""

    file: CampaignFile
    folder: Path
    members: list[Member]

    def __init__(self, file: CampaignFile, folder: PathLike, members: list[Member]) -> None:
        self.file, self.folder, self.members = file, Path(folder).resolve(), members

    @property
    def variants(self) -> list[str]:
        """Names of its variants, in the order of its file."""
        return list(self.file.variants) or [ONLY]

    def base(self, variant: str) -> Path:
        """File of the base scene of a variant."""
        return base_file(self.folder, variant)

    def results(self, member: Member) -> Path:
        """Folder of the numbers and maps of a run."""
        return self.folder / "results" / member.hash

    def run(self, member: Member) -> Path:
        """Folder of the run itself."""
        return self.folder / "runs" / member.hash

    def scene(self, member: Member) -> Scene:
        """The scene of a run."""
        return load_scene(self.base(member.variant), member.changes)

    def write(self) -> None:
        """Write the plan."""
        write_text(self.folder / PLAN, json.dumps([asdict(member) for member in self.members], indent=0))


def base_file(folder, variant):
    """File of the base scene of a variant."""
    return Path(folder) / (f"{ONLY}.toml" if variant == ONLY else f"{ONLY}_{variant}.toml")


class Staged:
    """Base scenes of a `CampaignFile` and the files that they name, in a folder of their own until all is checked.

    cell: side of the map cells [m], where the file has none. Raises InputError for a base scene that cannot be.
    """

    def __init__(self, file, staging, cell=None):
        self.file, self.folder = file, Path(staging).resolve()
        self.inputs = Inputs(self.folder)
        self.bases = {variant: base_file(self.folder, variant) for variant, _, _ in _variants(file, 0)}
        self.place(cell)

    def place(self, cell):
        """Write the base scenes, with map cells of this side."""
        for variant, changes, _ in _variants(self.file, 0):
            _write_base(self.file, self.folder, variant, changes, self.inputs, cell)

    def members(self, values=None):
        """List of `Member`: every scene is checked. values: of the parameters by run, in place of those of the design.
        Raises InputError, which names the run, for a scene that cannot be."""
        values = samples(self.file) if values is None else values
        members = [Member(variant, i, values[i], _changes(self.file, values[i], self.inputs))
                   for variant, _, n in _variants(self.file, len(values)) for i in range(n)]
        return [_hashed(member, self.file, self.folder) for member in counted(members, "checking scenes", "scenes")]

    @contextlib.contextmanager
    def messages(self):
        """Context in which errors and warnings name the user's files, not those that stand for them."""
        try:
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                yield
        except InputError as error:
            raise InputError(self._told(str(error))) from None
        for text in dict.fromkeys(str(warning.message) for warning in said):
            warnings.warn(self._told(text), stacklevel=2)

    def _told(self, text):
        for base in self.bases.values():
            text = text.replace(str(base), self.file.source)
        return self.inputs.told(text)

    def with_other_files(self, members):
        """Members that name files which no member before them names, so that each file is read once."""
        seen = set()
        for member in members:
            named = self.inputs.among(member.changes) - seen
            if named:
                seen |= named
                yield member

    def commit(self, folder, read):
        """Copy the files that the scenes name, and the base scenes, to the folder of the campaign. read: paths of files
        that were read."""
        self.inputs.copy(folder, read)
        for base in self.bases.values():
            write_text(Path(folder) / base.name, base.read_text(encoding="utf-8"))


def make_plan(file, folder, cell=None, values=None):
    """`Plan` of a `CampaignFile`, whose base scenes and files are written to the folder once every scene is checked;
    the files of base scenes and runs are not opened for it. Otherwise as `Staged`."""
    folder = Path(folder).resolve()
    with tempfile.TemporaryDirectory() as staging:
        staged = Staged(file, staging, cell)
        members = staged.members(values)
        staged.commit(folder, staged.inputs.known)
    return Plan(file, folder, members)


def runs_of(file):
    """Number of runs of a `CampaignFile`, by variant."""
    if file.design == "saltelli":
        total = file.runs * (_columns(file) + 2)
    elif file.runs is not None:
        total = file.runs
    else:
        levels = [len(one.shares()) for one in file.parameters.values()]
        total = math.prod(levels) if file.design == "grid" else 1 + sum(levels)
    return {variant: n for variant, _, n in _variants(file, total)}


def _columns(file):
    """Columns of the design: rows of one posterior file share one."""
    return len({("file", one.file) if isinstance(one, Drawn) else ("name", name)
                for name, one in file.parameters.items()})


def _variants(file, n):
    if not file.variants:
        return [(ONLY, {}, n)]
    return [(name, one.set, min(n, one.runs or n)) for name, one in file.variants.items()]


def _write_base(file, folder, variant, changes, inputs, cell):
    path = find_scene(_scene_name(file))
    data = parse(path)
    own = path.resolve().parent
    for key, value in {**file.set, **changes}.items():
        override(data, key, inputs.named(key, value, file.base_dir, own), file.source)
    data = inputs.of(data, own)
    wanted = file.maps.cell or cell
    if wanted:
        data.setdefault("output", {})["map_cell"] = wanted
    try:
        write_text(base_file(folder, variant), table_text(data))
        load_scene(base_file(folder, variant))
    except InputError as error:
        raise _with_source(error, file, base_file(folder, variant)) from None


def _scene_name(file):
    """The scene as `find_scene` takes it: files are relative to that of the campaign."""
    beside = file.base_dir / file.scene
    return str(beside) if beside.suffix == ".toml" else file.scene


def _changes(file, values, inputs):
    changes = {}
    for name, value in values.items():
        for key, own in file.parameters[name].changes(value).items():
            changes[key] = inputs.named(key, own, file.base_dir, _scene_folder(file))
    return changes


def _scene_folder(file):
    return find_scene(_scene_name(file)).resolve().parent


def _hashed(member, file, folder):
    base = base_file(folder, member.variant)
    try:
        scene = load_scene(base, member.changes)
    except InputError as error:
        raise _with_source(error, file, base, member) from None
    made_with = json.dumps(loaded) if (loaded := plugins.records()) else ""
    text = f"{__version__}{made_with}\n{scene.to_toml().replace(str(folder), '')}"
    return Member(**{**asdict(member), "hash": hashlib.sha256(text.encode()).hexdigest()[:16]})


def _with_source(error, file, base, member=None):
    first, *rest = str(error).replace(f"{base}: ", "").split("\n")
    where = f"{member.name}: " if member else "base scene: "
    return InputError("\n".join([f"{file.source}: {where}{first}", *rest[:1]]))


def read_plan(folder, file):
    """The `Plan` that was written to a folder."""
    path = Path(folder) / PLAN
    rows = untrusted.plan_rows(path)
    if rows is None:
        raise InputError(f"{folder}: no campaign here ({PLAN} is missing)")
    members, variants = [Member(**row) for row in rows], list(file.variants) or [ONLY]
    allowed = {name: one.test() for name, one in file.parameters.items()}
    for member in members:
        if member.variant not in variants or set(member.values) != set(file.parameters):
            raise InputError(f"{path}: run {member.run} of {member.variant}: not of this campaign, which has"
                             f" {', '.join(file.parameters)}")
        for name, value in member.values.items():
            if not allowed[name](value):
                raise untrusted.damaged(path, f"run {member.run}: {name} = {value!r}: not a value of this campaign")
    return Plan(file, folder, members)

