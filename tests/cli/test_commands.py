"""The commands on a scene of a few particles, and what they leave and say."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

import snowmpm
from snowmpm.errors import SimulationError
from snowmpm.running import loop
from snowmpm.scenes import load_scene


def test_run_writes_what_the_contract_says(call, block, tmp_path):
    result = call("run", block, "--backend", "cpu")
    assert result.code == 0, result.err
    folder = tmp_path / "runs" / "block"
    assert {path.name for path in folder.glob("[!.]*")} == {
        "run.vtkhdf",
        "paraview.vtkhdf",
        "scene.toml",
        "summary.json",
        "checkpoint.npz",
    }
    assert "runs/block/run.vtkhdf" in result.out.replace(os.sep, "/")
    run = snowmpm.Run(folder)
    assert run.complete
    assert len(run) == 3  # at 0, 0.01 and 0.02 s
    assert json.loads((folder / "summary.json").read_text())["complete"] is True
    assert load_scene(folder / "scene.toml").model_dump() == load_scene(block).model_dump()


def test_options_reach_the_scene(call, block):
    settings = ("--set", "solver.dx=0.2", "--set", "end_time=0.01", "--precision", "f64", "-o", "out")
    result = call("run", block, *settings)
    assert result.code == 0, result.err
    resolved = load_scene("out/scene.toml")
    assert (resolved.solver.dx, resolved.end_time, resolved.solver.precision) == (0.2, 0.01, "f64")


def test_a_run_is_replaced_only_when_told(call, block, tmp_path):
    assert call("run", block).code == 0
    file = tmp_path / "runs" / "block" / "run.vtkhdf"
    before = file.read_bytes()
    refused = call("run", block)
    assert refused.code == 2
    assert "--overwrite" in refused.err
    assert file.read_bytes() == before
    assert call("run", block, "--overwrite", "--set", "end_time=0.01").code == 0
    assert len(snowmpm.Run(file)) == 2


def test_resume_goes_on(call, block):
    assert call("run", block).code == 0
    assert call("run", block, "--resume", "--set", "end_time=0.03").code == 0
    assert list(snowmpm.Run("runs/block").times) == [0.0, 0.01, 0.02, 0.03]


def test_resume_takes_the_settings_of_the_run(call, block):
    """What was set when the run began, or in between, is not asked for again; another value, or scene, is refused."""
    assert call("run", block, "--set", "solver.dx=0.2", "--precision", "f32").code == 0
    went_on = call("run", block, "--resume", "--set", "end_time=0.03")
    assert went_on.code == 0, went_on.err
    run = snowmpm.Run("runs/block")
    assert (run.times[-1], run.scene["solver"]["dx"]) == (0.03, 0.2)
    assert run.provenance["settings"] == {"solver.dx": 0.2, "solver.precision": "f32", "end_time": 0.03}
    once_more = call("run", block, "--resume")
    assert once_more.out.startswith("nothing left to do: ")
    assert once_more.code == 0, once_more.err
    other = call("run", block, "--resume", "--set", "solver.dx=0.1")
    assert (other.code, "solver.dx = 0.1: was 0.2" in other.err) == (2, True)
    block.write_text(block.read_text().replace("300.0", "310.0"))
    edited = call("run", block, "--resume")
    assert (edited.code, "density = 310.0: was 300.0" in edited.err) == (2, True)


def test_progress_in_plain_lines(call, block):
    result = call("run", block, "--progress", "lines")
    last = result.err.strip().split("\n")[-1]
    for word in ("block: 0.020 of 0.02 s (100%)", "dt ", "particles", "m/s", "front", "particle-steps/s", "left"):
        assert word in last


def test_progress_in_json(call, block):
    """Objects on stderr, one a line, with a share that grows to 1; facts on stdout stay as they are."""
    result = call("run", block, "--progress", "json")
    told = [json.loads(line) for line in result.err.splitlines()]
    shares = [one["share"] for one in told if one["progress"] == "block"]
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert {"time", "end_time", "step", "particles", "max_speed", "seconds"} <= set(told[-1] if "time" in told[-1] else
                                                                                    told[-2])
    assert result.out.count("\n") == 1


def test_an_option_that_has_another_name_now_still_works(call, block):
    result = call("run", block, "--lines")
    assert result.code == 0 and result.err.startswith("warning: --lines is now --progress lines\nblock: ")


def test_quiet_where_nobody_watches(call, block):
    result = call("run", block)
    assert (result.code, result.err) == (0, "")
    assert result.out.count("\n") == 1
    assert call("run", block, "--overwrite", "--quiet") == type(result)(0, "", "")


def test_json_of_every_command_that_tells_facts(call, block):
    told = json.loads(call("run", block, "--json").out)
    assert (told["complete"], told["frames"], told["run"].replace(os.sep, "/")) == (True, 3, "runs/block/run.vtkhdf")
    told = json.loads(call("info", "runs/block", "--json").out)
    assert told["times"] == [0.0, 0.01, 0.02]
    assert {"velocity", "density"} <= set(told["fields"])
    assert json.loads(call("check", block, "--json").out)["dimension"] == 2
    assert "slab_release" in json.loads(call("list", "--json").out)["scenes"]


def test_info_of_a_run(call, block):
    assert call("run", block).code == 0
    result = call("info", "runs/block")
    assert result.code == 0
    for word in ("frames", "velocity [m/s]", "density [kg/m3]", "kinetic energy", "taichi", "precision"):
        assert word in result.out


def test_plot_draws_the_history(call, block, tmp_path):
    assert call("run", block).code == 0
    result = call("plot", "runs/block")
    assert result.code == 0, result.err
    assert (tmp_path / "runs" / "block" / "history.png").stat().st_size > 10_000
    assert result.out.strip().endswith("history.png")
    assert call("plot", "runs/block", "-o", "history.doc").code == 2


def test_picture_of_a_run(call, block, tmp_path):
    assert call("run", block).code == 0
    result = call("render", "runs/block", "--time", "0.01", "-o", "picture.png", "--size", "320x240")
    assert result.code == 0, result.err
    assert (tmp_path / "picture.png").stat().st_size > 1000
    late = call("render", "runs/block", "--time", "99", "-o", "late.png")
    assert late.code == 2 and late.err.count("\n") == 1 and "goes from 0 to" in late.err
    assert not (tmp_path / "late.png").exists()
    among = call("render", "runs/block", "-o", "runs/block", "--size", "320x240")
    assert among.code == 2 and "holds other files (checkpoint.npz" in among.err
    (tmp_path / "frames").mkdir()
    (tmp_path / "frames" / "frame_00999.png").touch()  # of a longer film
    assert call("render", "runs/block", "-o", "frames", "--size", "320x240").code == 0
    names = sorted(path.name for path in (tmp_path / "frames").glob("[!.]*"))
    assert names == [f"frame_{i:05d}.png" for i in range(len(names))]


def test_run_and_render(call, block, tmp_path, monkeypatch):
    # The film itself is tested where it is made; here: that it is asked for, of this run, beside it.
    asked = []

    def render_run(run, output, **choices):
        asked.append((run.path, output))
        return output

    monkeypatch.setattr("snowmpm.render.render_run", render_run)
    result = call("run", block, "--render")
    assert result.code == 0, result.err
    folder = snowmpm.Run("runs/block").path.parent
    assert [(path.parent, output) for path, output in asked] == [(folder, folder / "film.mp4")]


def test_run_and_maps(call, block):
    pytest.importorskip("rasterio", reason="needs the extra gis")
    short = ("--set", "solver.dx=20", "--set", "end_time=4", "--set", "output.interval=2")
    result = call("run", "avalanche_depth_averaged", *short, "-o", "valley", "--maps")
    assert result.code == 0, result.err
    made = {path.name for path in Path("valley/maps").iterdir()}
    assert {"peak_depth.tif", "peak_pressure.png", "avalanche.csv"} <= made
    flat = call("run", "column_collapse_2d", "-o", "flat", "--maps")
    assert flat.code == 2 and "--maps" in flat.err and not Path("flat").exists()


def test_check_says_what_will_be_modelled(call, block, tmp_path):
    result = call("check", block, "--precision", "f64")
    assert result.code == 0, result.err
    for word in ("dimension", "particles", "blocks", "memory", "dt", "run time"):
        assert word in result.out
    assert list(tmp_path.iterdir()) == [block]


def test_list(call):
    result = call("list")
    assert result.code == 0
    for word in ("Scenes", "Materials", "cohesive_cam_clay", "elastic"):
        assert word in result.out


def test_version(call):
    assert call("--version").out.strip() == f"snowmpm {snowmpm.__version__}"


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (SimulationError("particle 3 turned inside out at t = 0.1 s"), 1, "particle 3 turned inside out"),
        (ZeroDivisionError("division by zero"), 1, "unexpected ZeroDivisionError: division by zero"),
        (MemoryError(), 1, "out of memory"),
        (OSError(28, "No space left on device", "run.vtkhdf"), 1, "run.vtkhdf: No space left on device"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_errors_become_messages_and_codes(call, block, monkeypatch, error, code, said):
    def fail(*_):
        raise error

    monkeypatch.setattr(loop, "run", fail)
    result = call("run", block)
    assert result.code == code
    assert said in result.err
    assert "Traceback" not in result.err
    assert "Traceback" in call("run", block, "--debug").err


def test_termination_closes_the_run_file(call, block):
    done = threading.Event()

    def stop():
        while not os.path.exists("runs/block/run.vtkhdf"):
            time.sleep(0.01)
        time.sleep(0.3)
        if not done.is_set():
            os.kill(os.getpid(), signal.SIGTERM)

    watcher = threading.Thread(target=stop)
    watcher.start()
    try:
        result = call("run", block, "--set", "end_time=100")
    finally:
        done.set()
        watcher.join()
    assert result.code == 130
    for word in ("interrupted at t = ", "checkpoint.npz", "--resume goes on"):
        assert word in result.err
    assert result.err.splitlines()[-1] == f"snowmpm run {block} -o runs/block --resume"
    assert len(snowmpm.Run("runs/block")) >= 1
    resumed = call("run", block, "--set", "end_time=100", "--resume", "--set", "solver.dx=0.2")
    assert (resumed.code, "solver.dx = 0.2: was 0.1" in resumed.err) == (2, True)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [(["--help"], 0), (["run", "none.toml"], 2), (["run", "block.toml", "--set", "solver.dxx=1"], 2)],
)
def test_answers_at_once(block, arguments, code):
    """What takes seconds to import is not imported: 0.15 s and 0.6 s on a quiet machine; VTK would add seconds."""
    command = [sys.executable, "-X", "importtime", "-m", "snowmpm", *arguments]
    done = subprocess.run(command, capture_output=True, text=True, cwd=block.parent, timeout=60)
    assert done.returncode == code
    loaded = {line.rpartition("|")[2].strip().partition(".")[0] for line in done.stderr.splitlines()
              if line.startswith("import time:")}
    assert "typer" in loaded
    assert not loaded & {"vtkmodules", "pyvista", "matplotlib", "scipy", "trimesh", "rasterio", "shapely", "xarray"}
    assert "[Taichi]" not in done.stdout + done.stderr


def test_help_imports_nothing_heavy():
    code = (
        "import sys; from snowmpm.cli.app import app\n"
        "try: app(['run', '--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'taichi', 'pyvista', 'vtk', 'matplotlib', 'numpy', 'h5py', 'trimesh'} & set(sys.modules)\n"
        "sys.exit(f'imported: {heavy}' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


def test_two_runs_beside_each_other_pages_and_reports(call, block, tmp_path, monkeypatch):
    # What is drawn is tested where it is made; here: that it is asked for, of these runs, with these choices.
    asked = []
    for name in ("render_pair", "render_page", "render_report"):
        monkeypatch.setattr(f"snowmpm.render.{name}", lambda *a, name=name, **k: asked.append((name, a, k)) or a[-1])
    for folder in ("one", "two"):
        assert call("run", block, "-o", folder, "--quiet").code == 0
    assert call("render", "one", "two", "-o", "both.mp4", "--color", "density").code == 0
    assert call("render", "one", "two").code == 0
    assert call("render", "one", "-o", "one.html", "--camera", "side").code == 0
    assert call("report", "one", "--still").code == 0
    names, places, choices = zip(*asked, strict=True)
    assert names == ("render_pair", "render_pair", "render_page", "render_report")
    assert [str(place[-1]) for place in places] == [
        "both.mp4", str(snowmpm.Run("one").path.with_name("beside_two.mp4")), "one.html",
        str(snowmpm.Run("one").path.with_name("report.html"))]
    assert (choices[0]["color"], choices[2]["camera"], choices[3]["interactive"]) == ("density", "side", False)
    refused = call("render", "one", "two", "-o", "one.html")
    assert (refused.code, "RUN2" in refused.err) == (2, True)
