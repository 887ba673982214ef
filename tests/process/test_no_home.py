"""Without a home folder, or with one that cannot be written to: under cron, in containers, in batch jobs."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from filelock import FileLock

from snowmpm import cores
from snowmpm.compiler import cache_folder as cache

SCENE = str(Path(__file__).parents[1] / "cli" / "block.toml")
HOMES = {"none": None, "unwritable": "/proc/none"}


def command(home, folder, *words):
    given = {name: value for name, value in os.environ.items()
             if name not in ("HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR", cache.VARIABLE)}
    given |= {"TMPDIR": str(folder)} | ({"HOME": home} if home else {})
    return subprocess.run([sys.executable, "-m", "snowmpm", *words], env=given, cwd=folder, capture_output=True,
                          text=True, timeout=300)


@pytest.mark.parametrize("home", HOMES.values(), ids=HOMES)
def test_runs_and_draws(home, tmp_path):
    ran = command(home, tmp_path, "run", SCENE, "-q", "--threads", "1", "-o", "run", "--set", "end_time=0.002")
    assert ran.returncode == 0, ran.stderr
    drawn = command(home, tmp_path, "plot", "run", "-o", "history.png")
    assert drawn.returncode == 0 and (tmp_path / "history.png").stat().st_size > 1000, drawn.stderr
    assert "Traceback" not in drawn.stderr and "mkdir" not in drawn.stderr
    if home:
        assert "compiled kernels cannot be kept there; they are kept in" in ran.stderr


def test_a_cache_that_cannot_be_written(tmp_path, monkeypatch):
    monkeypatch.delenv(cache.VARIABLE, raising=False)
    assert cache.cache_folder(tmp_path / "ticache") == str(tmp_path / "snowmpm")
    with pytest.warns(UserWarning, match="cannot be kept there"):
        found = cache.cache_folder("/proc/none/cache")
    assert os.access(os.path.dirname(found), os.W_OK)
    monkeypatch.setenv(cache.VARIABLE, str(tmp_path / "asked"))
    assert cache.cache_folder("/proc/none/cache") == str(tmp_path / "asked")


OTHER_PROGRAM = """import taichi as ti
ti.init(arch=ti.cpu, offline_cache_max_size_of_files=1)

@ti.kernel
def nothing(a: ti.types.ndarray()):
    for i in range(a.shape[0]):
        a[i] = 0.0

nothing(ti.ndarray(ti.f32, 8))
"""


def test_another_program_with_taichi_leaves_the_kernels(tmp_path):
    ran = command(str(tmp_path), tmp_path, "run", SCENE, "-q", "--threads", "1", "-o", "run", "--set", "end_time=0.002")
    assert ran.returncode == 0, ran.stderr
    kernels = sorted((tmp_path / ".cache" / "taichi" / "snowmpm").glob("*.tic"))
    (tmp_path / "other.py").write_text(OTHER_PROGRAM)
    around = {name: value for name, value in os.environ.items() if name not in ("XDG_CACHE_HOME", cache.VARIABLE)}
    subprocess.run([sys.executable, "other.py"], cwd=tmp_path, env={**around, "HOME": str(tmp_path)}, check=True)
    assert len(kernels) > 3 and all(path.exists() for path in kernels)


def test_a_program_that_ends_waits_for_one_that_writes_its_kernels(tmp_path):
    text = "import snowmpm; snowmpm.start('cpu', threads=1); print('ready', flush=True)"
    environment = {**os.environ, cache.VARIABLE: str(tmp_path)}
    with FileLock(tmp_path / "snowmpm.lock"):
        program = subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, text=True, env=environment)
        assert any("ready" in line for line in program.stdout), "ended before"
        time.sleep(2.0)
        assert program.poll() is None and not list(tmp_path.glob("*.tic"))
    program.communicate(timeout=60)
    assert program.returncode == 0
    assert list(tmp_path.glob("*.tic"))


@pytest.mark.parametrize(("files", "quota"), [
    ({"cpu.max": "150000 100000\n"}, 1.5), ({"cpu.max": "max 100000\n"}, float("inf")),
    ({"cpu/job/cpu.cfs_quota_us": "400000\n", "cpu/job/cpu.cfs_period_us": "100000\n"}, 4.0),
    ({"cpu/cpu.cfs_quota_us": "-1\n", "cpu/cpu.cfs_period_us": "100000\n"}, float("inf")), ({}, float("inf")),
    ({"pod/cpu.max": "50000 100000", "cpu.max": "800000 100000"}, 0.5),
])
def test_a_container_s_share_of_the_cores(files, quota, tmp_path, monkeypatch):
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    own = tmp_path / "own"
    own.write_text("4:cpu:/job\n3:memory:/other\n0::/pod/container\n")
    found = cores._groups(tmp_path, own)
    monkeypatch.setattr(cores, "_groups", lambda: found)
    assert cores._quota() == quota
    monkeypatch.setattr(cores.os, "sched_getaffinity", lambda process: range(8), raising=False)
    assert cores.available_cores() == (8 if quota == float("inf") else max(1, -int(-quota // 1)))
