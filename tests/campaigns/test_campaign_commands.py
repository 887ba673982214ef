"""The commands: a campaign from file to page, its short form, and what they say of bad input."""

import json
import re
import sys

import pytest

from snowmpm.cli.app import app
from snowmpm.scenes import load_scene

pytest.importorskip("distributed")
GOOD = {"name": '"small"', "scene": '"avalanche_depth_averaged"', "runs": "4", "extra": "", "low": "0.2", "high": "0.3",
        "key": '"terrain.friction.mu"', "kind": '"uniform"'}


def written(folder, **changes):
    """A campaign's file with some of its lines changed."""
    now = {**GOOD, **changes}
    text = f"""name = {now['name']}
scene = {now['scene']}
runs = {now['runs']}
{now['extra']}
[set]
"solver.dx" = 20.0
"end_time" = 24.0
"output.interval" = 8.0
[parameters.mu]
key = {now['key']}
distribution = {now['kind']}
low = {now['low']}
high = {now['high']}
"""
    file = folder / "small.toml"
    file.write_text(text)
    return file


def called(capsys, *words):
    """(exit code, stdout, lines on stderr) of a command."""
    capsys.readouterr()
    try:
        app([str(word) for word in words])
        code = 0
    except SystemExit as end:
        code = end.code or 0
    said = capsys.readouterr()
    return code, said.out, [line for line in said.err.splitlines() if "cells without data" not in line]


@pytest.mark.parametrize(("changes", "words"), [
    ({"extra": "rums = 3"}, "rums = 3: unknown key; did you mean runs?"),
    ({"extra": 'design = "saltelli"', "runs": "5"}, "runs = 5: must be a power of 2"),
    ({"extra": 'design = "grid"'}, 'runs = 4: does not go with design = "grid"'),
    ({"low": "0.3", "high": "0.2"}, "parameters.mu.high = 0.2: must be above low = 0.3"),
    ({"low": "-0.2"}, "terrain.friction.mu = -0.1"),
    ({"key": '"terrain.fraction.mu"'}, "terrain.fraction = {mu = 0.2"),
    ({"kind": '"unifrom"'}, '"choices", "scenarios", "posterior"; did you mean'),
    ({"scene": '"avalanche_on_rastr"'}, "did you mean avalanche_on_raster?"),
    ({"runs": "2000000"}, "runs would take"),
    ({"extra": 'keep = "runs"\n[maps]\nquantiles = [1.5]'}, "maps.quantiles.0 = 1.5: must be < 1"),
    ({"extra": '[[correlated]]\nparameters = ["mu", "xi"]\ncoefficient = 0.5'}, "must be two of the parameters"),
])
def test_bad_input_is_refused_in_two_lines(tmp_path, capsys, changes, words):
    code, out, lines = called(capsys, "campaign", "run", written(tmp_path, **changes), "-o", tmp_path / "out")
    assert code == 2 and out == ""
    assert 1 <= len(lines) <= 2 and words in "\n".join(lines), lines
    assert not list(tmp_path.glob("out/runs/*"))


@pytest.mark.parametrize(("words", "said"), [
    (("run", "valley_frction"), "did you mean valley_friction?"), (("run", "none.toml"), "none.toml: no such file"),
    (("status", "."), "no campaign here"), (("maps", "."), "no campaign here"), (("plot", "."), "no campaign here"),
    (("calibrate", "valley_friction"), "calibration is missing")])
def test_nothing_there(tmp_path, capsys, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    code, _, lines = called(capsys, "campaign", *words)
    assert code == 2 and len(lines) <= 2 and said in "\n".join(lines)


@pytest.mark.parametrize(("value", "said"), [("terrain.friction.mu", "must be KEY=a,b,c"),
                                             ("terrain.friction.mu=0.2,0.2", "the same value twice"),
                                             ("terrain.friction.mu=0.2,-1", "must be >= 0")])
def test_bad_values_of_a_sweep(tmp_path, capsys, value, said):
    code, _, lines = called(capsys, "sweep", "avalanche_depth_averaged", value, "-o", tmp_path / "out")
    assert code == 2 and len(lines) <= 2 and said in "\n".join(lines)


def test_a_campaign_from_file_to_page(tmp_path, capsys, site):
    """With the workers of all tests: table, page with pictures, status, GeoTIFFs; and the run of a member by itself."""
    out, file = tmp_path / "out", written(tmp_path)
    code, told, lines = called(capsys, "campaign", "run", file, "-o", out, "--scheduler", site.client.scheduler.address)
    assert code == 0, lines
    assert "4 of 4 runs done" in told and "median of the 4 runs, too few for quantiles" in told
    assert any("4 runs, about" in one for one in lines)
    page = (out / "report.html").read_text()
    assert page.count("<img") >= 10 and "How to make it again" in page and "http" not in page.replace("http-equiv", "")
    code, told, _ = called(capsys, "campaign", "status", out, "--json")
    assert code == 0 and json.loads(told)["done"] == 4
    code, told, lines = called(capsys, "campaign", "run", file, "-o", out)
    assert code == 2 and "already holds a campaign: --resume" in lines[0]
    row = json.loads((out / "plan.json").read_text())[2]
    assert load_scene(out / "base.toml", row["changes"]).terrain.friction.mu == row["values"]["mu"]


def test_a_sweep(tmp_path, capsys, site):
    code, told, lines = called(
        capsys, "sweep", "avalanche_depth_averaged", "terrain.friction.mu=0.2,0.3", "bodies.0.shape.top=1.0,1.5",
        "--set", "solver.dx=20.0", "--set", "end_time=16.0", "--set", "output.interval=4.0",
        "-o", tmp_path / "out", "--scheduler", site.client.scheduler.address)
    assert code == 0, lines
    assert "4 of 4 runs done" in told
    pictures = [path.name for path in (tmp_path / "out" / "pictures").iterdir()]
    assert "scatter.png" in pictures and not any("probability" in name for name in pictures)
    rows = re.findall(r"^ +(0\.\d) +(1(?:\.5)?) ", told, re.MULTILINE)
    assert sorted(rows) == [("0.2", "1"), ("0.2", "1.5"), ("0.3", "1"), ("0.3", "1.5")]


def test_without_the_extra_one_line_says_what_to_install(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "zarr", None)
    code, out, lines = called(capsys, "campaign", "run", written(tmp_path), "-o", tmp_path / "out")
    assert code == 2 and out == "" and not (tmp_path / "out").exists()
    assert lines == ["error: campaigns need the cluster extra (zarr is missing): pip install 'snowmpm[cluster]'"]


def test_slurm_script_has_what_a_run_needs():
    pytest.importorskip("dask_jobqueue")
    from dask_jobqueue import SLURMCluster

    from snowmpm.campaigns.cluster import slurm_options
    from snowmpm.campaigns.spec import Cluster

    options = Cluster(threads=4, backend="cuda", slurm={"queue": "gpu", "walltime": "02:00:00", "memory": "16 GiB"})
    script = SLURMCluster(**slurm_options(options)).job_script()
    assert "#SBATCH -p gpu" in script and "--cpus-per-task=4" in script and "02:00:00" in script
    assert "--resources GPU=1" in script and "--nthreads 1" in script


def test_workers_are_not_sampled(site):
    """Dask's profiler hung a worker for good (CPython issue 106883): off on ours, and stopped on those of others."""
    import dask
    import distributed

    from snowmpm.campaigns import work

    def sampler(dask_worker):
        return dask_worker.periodic_callbacks.get("profile")

    assert not any(site.client.run(sampler).values())
    with dask.config.set({"distributed.worker.profile.enabled": True}), distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as other, \
            distributed.Client(other) as client:
        worker = next(iter(other.workers.values()))
        assert worker.periodic_callbacks["profile"].is_running()
        client.submit(work.stop_sampling).result(timeout=30)
        assert not worker.periodic_callbacks["profile"].is_running()
