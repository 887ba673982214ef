"""Running a campaign: plan, forecast, runs, answers."""

import json
import os
import tempfile
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from snowmpm import notebook, overwriting
from snowmpm.annotations import PathLike
from snowmpm.campaigns import answers, cluster, forecast, table, untrusted
from snowmpm.campaigns.campaign import FILE, Campaign
from snowmpm.campaigns.conduct import PATIENCE, Conductor
from snowmpm.campaigns.members import ONLY, PLAN, Plan, Staged, base_file, runs_of
from snowmpm.campaigns.spec import CampaignFile, read_campaign
from snowmpm.campaigns.stack import STORE
from snowmpm.campaigns.work import RECORD, job_of, work
from snowmpm.draft import write_text
from snowmpm.errors import InputError, SimulationError, shown_line
from snowmpm.io import FolderLock
from snowmpm.reading.named_files import noting
from snowmpm.scenes import load_scene
from snowmpm.scenes.toml import table_text
from snowmpm.stages import stage


def silent(text: str) -> None:
    """Says nothing."""


def campaign(scene: PathLike, parameters: Mapping[str, Mapping[str, Any]], folder: PathLike, *,
             scheduler: str | None = None, workers: int | None = None, resume: bool = False,
             **options: Any) -> Campaign:
    """Run a campaign; -> `Campaign`.

    scene: library name or TOML file; parameters: {name: {"key": dotted key, "distribution": ..., ...}}; folder: of the
    campaign; scheduler: address of a Dask scheduler, "slurm", or None for processes of this machine; workers: their
    number; resume: complete a campaign in the folder; options: other keys of a campaign's file (runs, design, seed,
    set, maps, variants, ...). A program that calls this is imported by its workers: guard it with
    `if __name__ == "__main__":`. Raises InputError.
    """
    path = Path(scene)
    base = path.resolve().parent if path.suffix == ".toml" else Path.cwd()
    data = {"name": Path(folder).name, "scene": path.name if path.suffix == ".toml" else str(scene),
            "parameters": {name: dict(one) for name, one in parameters.items()}, **options}
    file = CampaignFile.checked(data, "campaign", base)
    with notebook.bar(file.name) if notebook.in_notebook() else nullcontext():
        return run_campaign(file, folder, scheduler=scheduler, workers=workers, resume=resume)


def prepare(file: CampaignFile, folder: PathLike, workers: int | None = None, resume: bool = False,
            lock: FolderLock | None = None, retry: bool = False):
    """(`Plan`, `Forecast`) of a campaign, whose files are written to its folder once all is checked. Raises InputError
    for bad input, a folder that holds another campaign or files of somebody else, and more than the disk holds; then
    nothing is written."""
    folder = Path(folder).resolve()
    cluster.require_cluster()
    untrusted.require_no_links(folder)
    if (folder / PLAN).exists() and not resume:
        raise InputError(f"{folder} already holds a campaign: --resume completes it; or choose another folder with -o")
    if not os.access(next(parent for parent in (folder, *folder.parents) if parent.exists()), os.W_OK):
        raise InputError(f"-o {folder}: must be a folder that can be written to")
    overwriting.guard_in(folder, [name for name in names_of(file) if name != FILE or not has_own_file(folder, file)])
    if resume:
        refuse_another(file, folder)
    read: dict[Path, str] = {}
    with tempfile.TemporaryDirectory() as staging, noting(read):
        staged = Staged(file, staging)
        with staged.messages(), stage("looking at the scene", len(staged.bases), "variants") as now:
            surveys = {}
            for variant, base in staged.bases.items():
                surveys[variant] = forecast.survey(load_scene(base), file.cluster.threads)
                now.done += 1
        cells = [one.cell for one in surveys.values() if one.cell]
        number = cluster.worker_count(file.cluster, workers, max(one.memory for one in surveys.values()))
        # Before every scene is checked: too large a campaign would take long for that too
        forecast.forecast(file, folder, surveys, runs_of(file), number).check(file.source)
        staged.place(max(cells) if cells else None)
        members = staged.members()
        with staged.messages():
            for member in staged.with_other_files(members):
                forecast.survey(load_scene(staged.bases[member.variant], member.changes), file.cluster.threads)
        if resume:
            refuse_another_scene(staged, folder)
        if lock:
            lock.make()
        staged.commit(folder, read)
    plan = Plan(file, folder, members)
    if retry:
        forget_failed(plan)
    done = done_of(plan)
    left = {variant: sum(member.variant == variant and member.hash not in done for member in plan.members)
            for variant in plan.variants}
    return plan, forecast.forecast(file, folder, surveys, left, number)


def names_of(file: CampaignFile) -> list[str]:
    """Names of the files that a campaign keeps in its folder, beside those of its runs."""
    tables = (answers.SENSITIVITY, answers.CONVERGENCE, "report.html")
    variants = [f"{variant}_{name}" for variant in file.variants for name in tables]
    bases = [base_file("", variant).name for variant in file.variants or (ONLY,)]
    return [FILE, PLAN, *bases, *table.FILES, *tables, *variants, STORE]


FREE = ("runs", "cluster", "maps", "keep")
"""Keys of a campaign's file that may change when it is resumed, beside the runs of its variants."""


def refuse_another(file: CampaignFile, folder: Path) -> None:
    """Raise InputError where the folder holds a campaign that differs in more than its number of runs."""
    if not (folder / FILE).exists():
        return
    with overwriting.looking():
        own = read_campaign(folder / FILE)
    before, now = _compared(own), _compared(file)
    for key in dict.fromkeys([*before, *now]):
        if before.get(key) != now.get(key):
            raise InputError(f"{file.source}: {key}: is not that of the campaign in {folder}, which --resume"
                             " completes:\nchoose another folder with -o")


def refuse_another_scene(staged, folder):
    """Raise InputError where a base scene, or a file that it names, is not what it was when the campaign began."""
    for base in staged.bases.values():
        there = Path(folder) / base.name
        if there.exists() and there.read_bytes() != base.read_bytes():
            raise InputError(f"{staged.file.source}: scene: {staged.file.scene}, or a file that it names, has changed"
                             f" since the campaign in {folder} began:\nchoose another folder with -o")


def _compared(file):
    """{key: value} of a campaign's file that a resumed one must share."""
    data = own_data(file)
    for variant in data.get("variants", {}).values():
        variant.pop("runs", None)
    return {key: value for key, value in data.items() if key not in FREE}


def done_of(plan):
    """Hashes of the runs of a plan that have a record."""
    return {member.hash for member in plan.members if (plan.results(member) / RECORD).exists()}


def run_campaign(file: CampaignFile, folder: PathLike, *, scheduler: str | None = None, workers: int | None = None,
                 resume: bool = False, retry: bool = False, say: Callable[[str], None] = silent,
                 patience: float = PATIENCE) -> Campaign:
    """Run a campaign from its file; -> `Campaign`. retry: runs that failed are done once more; say: called with lines
    of text, what is told while it runs; patience: seconds to wait for a scheduler that is gone. Otherwise as
    `campaign`."""
    with FolderLock(folder) as lock, overwriting.keeping():
        plan, expected = prepare(file, folder, workers, resume, lock, retry)
        say(expected.words)
        write_own_file(plan.folder, file)
        overwriting.note_changing(plan.folder / STORE)
        plan.write()
        if expected.runs:
            with cluster.site(file.cluster, scheduler, workers, expected.memory) as site:
                say(f"dashboard: {site.dashboard}")
                conduct_runs(plan, site, say, patience)
        with stage("putting results together"):
            answers.write_answers(plan, table.records_of(plan))
    return Campaign(plan.folder)


def conduct_runs(plan, site, say=silent, patience=PATIENCE):
    """Do the runs of a plan that have no record yet on a `Site`; -> their number. A failing run is told."""
    conductor = Conductor(site, say, patience, plan.file.cluster.backend == "cuda")
    jobs, names, begun = {}, {}, set()
    for member in plan.members:
        if member.hash not in jobs:
            names[member.hash] = member
            # Of each variant one run is kept in any case: for terrain and projection
            jobs[member.hash] = job_of(plan, member, example=member.variant not in begun)
            begun.add(member.variant)
    done = done_of(plan)
    todo = [job for name, job in jobs.items() if name not in done]
    failed = 0
    with stage("running", len(todo), "runs") as now:
        for job, outcome in conductor.results(work, todo):
            record = outcome if isinstance(outcome, dict) else _given_up(plan, names[job.hash], outcome)
            if record["status"] == "failed":
                failed += 1
                now.detail = f"{failed} failed"
                say(f"{names[job.hash].name} failed: {record['reason']}")
            now.done += 1
    if todo and failed == len(todo):
        say("every run failed")
    return len(todo)


def _given_up(plan, member, error):
    """Record of a run whose workers died, or could not begin it."""
    died = type(error).__name__ == "KilledWorker"
    reason = (f"its worker died {cluster.DEATHS + 1} times" if died
              else f"{type(error).__name__}: {shown_line(str(error), 300)}")
    record = {"status": "failed", "reason": reason, "numbers": {}, "work": {}}
    write_text(plan.results(member) / RECORD, json.dumps(record, indent=1))
    return record


def write_own_file(folder, file):
    """Write a campaign's file to its folder, unless it is there."""
    if not has_own_file(folder, file):
        write_text(Path(folder) / FILE, table_text(own_data(file)))


def has_own_file(folder, file):
    """Whether the folder holds this very file."""
    path = Path(folder) / FILE
    return path.is_file() and path.read_bytes() == table_text(own_data(file)).encode()


def own_data(file):
    """Tables of a campaign's file as it stands in its folder: with the files that it names absolute."""
    data = file.model_dump(exclude_none=True, exclude_unset=True)
    for one in data["parameters"].values():
        if one.get("distribution") == "posterior":
            one["file"] = str(Path(file.base_dir, one["file"]).resolve())
    base = file.base_dir / file.scene
    if base.suffix == ".toml":
        data["scene"] = str(base.resolve())
    observed = (data.get("calibration") or {}).get("observed", {})
    if "outline" in observed:
        observed["outline"]["file"] = str(Path(file.base_dir, observed["outline"]["file"]).resolve())
    return data


def forget_failed(plan: Plan) -> int:
    """Forget the runs that failed, so that they are done once more; -> their number."""
    failed = {name for name, record in table.records_of(plan).items() if record["status"] == "failed"}
    for member in plan.members:
        if member.hash in failed:
            (plan.results(member) / RECORD).unlink(missing_ok=True)
    return len(failed)


def raise_if_all_failed(found: Campaign) -> None:
    """Raise SimulationError for a campaign without a single run that is done."""
    if not any(record["status"] == "done" for record in found.records.values()):
        reason = next((record["reason"] for record in found.records.values()), "none was begun")
        raise SimulationError(f"{found.folder}: every run failed; the first: {reason}")
