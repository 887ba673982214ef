"""Plugins from files, modules and installed packages: loaded when asked for, recorded, required to resume, and never
loaded because a file says so."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import snowmpm
from snowmpm import plugins
from snowmpm.cli.app import app
from snowmpm.errors import InputError
from snowmpm.io import checkpoint

HERE = Path(__file__).parent
SCENE = HERE / "package" / "scene.toml"

LAW = '''"""A law in a file."""

from typing import Literal

import snowmpm
from snowmpm.materials import Elastic

__version__ = "1.2"


@snowmpm.register
class Mine(Elastic):
    """An elastic law by another name."""

    kind: Literal["mine"] = "mine"
'''
BLOCK = '''name = "block"
dimension = 2
end_time = 0.02
output = { interval = 0.01 }
solver = { dx = 0.2, precision = "f64" }
domain = { min = [-1.0, -1.0], max = [2.0, 2.0] }
materials.snow = { kind = "mine", density = 300.0, youngs_modulus = 1e5, poisson_ratio = 0.2 }
bodies = [{ name = "block", material = "snow", shape = { kind = "box", min = [0.0, 0.4], max = [0.4, 0.8] } }]
'''


@pytest.fixture
def here(tmp_path, monkeypatch):
    """A folder with a law and a scene of it."""
    monkeypatch.chdir(tmp_path)
    Path("mine.py").write_text(LAW)
    Path("block.toml").write_text(BLOCK)
    return tmp_path


@pytest.fixture
def call(capsys):
    """call("run", "scene.toml") -> (exit code, out, err)."""

    def invoke(*words):
        capsys.readouterr()
        with pytest.raises(SystemExit) as end:
            app(list(map(str, words)))
        said = capsys.readouterr()
        return end.value.code or 0, said.out, said.err

    return invoke


# ---- files ----------------------------------------------------------------------------------------------------------

def test_a_run_holds_its_plugin_and_is_read_without_it(here, call):
    assert call("run", "block.toml", "-o", "out", "-q")[0] == 2
    assert not Path("out").exists()
    code, _, err = call("run", "block.toml", "-o", "out", "-q", "--plugin", "mine.py")
    assert code == 0, err
    (record,) = snowmpm.open_run("out").provenance["plugins"]
    assert record == plugins.loaded()[0].record() and (record["name"], record["version"]) == ("mine", "1.2")
    assert len(record["sha256"]) == 64 and "source" not in record
    # A process that has not loaded it
    for words in (["info", "out"], ["render", "out", "-o", "p.png", "--time", "0", "--size", "64x64"],
                  ["compare", "out", "out"]):
        done = subprocess.run([sys.executable, "-m", "snowmpm", *words], capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr


def test_a_run_is_resumed_with_the_plugin_that_it_began_with(here, call):
    more = ["run", "block.toml", "-o", "out", "-q", "--resume", "--set", "end_time=0.03"]
    assert call("run", "block.toml", "-o", "out", "-q", "--plugin", "mine.py")[0] == 0
    plugins._loaded.clear()
    code, _, err = call(*more)
    assert code == 2 and err == ("error: out: was made with the plugin mine 1.2, which is not loaded: give it with"
                                 " --plugin, or install it\n")
    plugins._loaded.clear()
    Path("mine.py").write_text(LAW.replace("1.2", "1.3"))
    code, _, err = call(*more, "--plugin", "mine.py")
    assert code == 2 and "out: was made with another plugin mine 1.2: SHA-256 " in err and "--accept-plugin" in err
    assert snowmpm.open_run("out").times[-1] == 0.02
    code, _, err = call(*more, "--plugin", "mine.py", "--accept-plugin")
    assert code == 0 and snowmpm.open_run("out").times[-1] == 0.03, err


def test_the_checkpoint_asks_for_it_too(here):
    plugins.load("mine.py")
    scene = snowmpm.load_scene("block.toml")
    snowmpm.run(scene, "out")
    kept = dict(plugins._loaded)
    plugins._loaded.clear()
    later = snowmpm.load_scene("block.toml", {"end_time": 0.03})
    with pytest.raises(InputError, match=r"was made with the plugin mine 1.2, which is not loaded"):
        snowmpm.run(later, "out", resume=True)
    plugins._loaded.update(kept)
    assert snowmpm.run(later, "out", resume=True).times[-1] == 0.03


def test_check_says_that_its_cost_is_assumed(here, call):
    code, out, err = call("check", "block.toml", "--plugin", "mine.py", "--json")
    assert code == 0, err
    assert json.loads(out)["assumed_cost"] == "not measured: mine, as elastic"


@pytest.mark.parametrize(("content", "says"), [
    (None, "no such file"), ("1 / 0", "cannot be loaded (ZeroDivisionError: division by zero)"),
    ("def", "cannot be loaded (SyntaxError: "), ("raise SystemExit(0)", "cannot be loaded (SystemExit: 0)"),
    ("import snowmpm\nsnowmpm.register(5)", "5: no law, event"),
    ("from typing import Literal\nimport snowmpm\nfrom snowmpm.scenes.events import Event\n"
     "class Boom(Event):\n    kind: Literal['boom']\nsnowmpm.register(Boom)", "ACTS is missing"),
    ("import snowmpm\nfrom snowmpm.components.contract import Component\n"
     "snowmpm.register(Component('warmth', '', 'warmth', lambda scene: (), 1, {'initial': None}))",
     "keys at 'initial': must be at "),
])
def test_a_plugin_that_cannot_be_loaded_is_refused_before_anything_is_written(here, call, content, says):
    if content is not None:
        Path("bad.py").write_text(content)
    code, _, err = call("run", "block.toml", "-o", "out", "--plugin", "bad.py")
    assert code == 2 and says in err and err.count("\n") <= 2 and not Path("out").exists()


def test_a_module_that_is_not_there(here, call):
    code, _, err = call("check", "block.toml", "--plugin", "no_such_module")
    assert (code, err) == (2, "error: --plugin no_such_module: no such module\n")


def test_two_files_of_one_name_are_told_apart(here):
    Path("other").mkdir()
    Path("other/mine.py").write_text("")
    first = plugins.load("mine.py")
    assert plugins.load("mine.py") is first
    with pytest.raises(InputError, match="another plugin of the name mine is loaded"):
        plugins.load("other/mine.py")


def test_another_digest_than_asked_for_is_not_run(here):
    Path("mine.py").write_text(LAW + "\nopen('ran', 'w').close()\n")
    with pytest.raises(InputError, match="has another SHA-256"):
        plugins.load("mine.py", "0" * 64)
    assert not Path("ran").exists()


@pytest.mark.parametrize("saved", [[{"name": "os", "version": "", "sha256": "x"}], [5], [{"name": 5}],
                                   [{"name": "a\x1b[2J", "version": "9" * 10_000, "sha256": ""}]])
def test_a_record_of_anybody_imports_nothing(saved):
    with pytest.raises(InputError) as refused:
        plugins.require(saved, "somebody's run")
    assert len(str(refused.value)) < 400 and "\x1b" not in str(refused.value)


def test_a_scene_names_no_plugin(here, call):
    Path("block.toml").write_text(f'plugin = "mine.py"\nplugins = ["mine.py"]\n{BLOCK}')
    code, _, err = call("check", "block.toml")
    assert code == 2 and "plugin" in err and "unknown key" in err and not plugins.loaded()


def test_the_example_of_the_guide(here, call):
    guide = (HERE.parents[1] / "docs" / "plugins.md").read_text(encoding="utf-8")
    Path("my_law.py").write_text(guide.partition("```python\n")[2].partition("```")[0])
    Path("block.toml").write_text(BLOCK.replace('"mine"', '"my_sand"'))
    code, _, err = call("run", "block.toml", "-o", "out", "-q", "--plugin", "my_law.py")
    assert code == 0, err
    assert snowmpm.load_scene("block.toml").materials["snow"].friction_angle == 34.0


def test_what_a_script_imports_is_the_plugin_that_the_command_line_would_load(monkeypatch):
    monkeypatch.syspath_prepend(HERE / "package")
    import snow_extras  # noqa: F401

    imported = plugins.records()
    plugins._loaded.clear()
    assert plugins.load("snow_extras").record() in imported and [one["name"] for one in imported] == ["snow_extras"]


def test_an_installed_plugin_that_cannot_be_loaded_is_named(monkeypatch, here):
    from importlib.metadata import EntryPoint

    broken = EntryPoint(name="broken", value="no_such_module", group=plugins.GROUP)
    monkeypatch.setattr(plugins.importlib.metadata, "entry_points", lambda group: [broken])
    with pytest.raises(InputError, match="the installed plugin broken: no such module; --no-plugins goes on without"):
        plugins.load_installed()


# ---- campaigns ------------------------------------------------------------------------------------------------------

def test_workers_of_a_campaign_load_it(here, call):
    pytest.importorskip("distributed")
    code, _, err = call("sweep", "block.toml", "materials.snow.density=200.0,300.0", "-o", "all", "--plugin", "mine.py",
                        "--workers", "1", "-q")
    assert code == 0, err
    records = [json.loads(path.read_text()) for path in Path("all").rglob("record.json")]
    assert [record["status"] for record in records] == ["done", "done"]
    runs = [snowmpm.open_run(path.parent) for path in Path("all").rglob("run.vtkhdf")]
    assert all(run.provenance["plugins"] == plugins.records() for run in runs) and runs


# ---- an installed package -------------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder that the example package was installed in."""
    target = tmp_path_factory.mktemp("installed")
    source = tmp_path_factory.mktemp("source") / "package"
    shutil.copytree(HERE / "package", source)
    done = subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-build-isolation",
                           "--disable-pip-version-check", "--target", str(target), str(source)],
                          capture_output=True, text=True, timeout=180)
    assert done.returncode == 0, done.stderr
    return target


def test_all_of_a_package_through_the_command_line(installed, tmp_path):
    """Law, law of friction, event, field, shape, component and command of a package that is installed."""
    surroundings = {**os.environ, "PYTHONPATH": os.pathsep.join([str(installed), os.environ.get("PYTHONPATH", "")])}

    def snowmpm_(*words, code=0):
        done = subprocess.run([sys.executable, "-m", "snowmpm", *map(str, words)], cwd=tmp_path, env=surroundings,
                              capture_output=True, text=True, timeout=180)
        assert done.returncode == code, done.stderr + done.stdout
        return done

    said = snowmpm_("check", SCENE).stdout
    assert "ageing, as elastic" in said and "drag of the air" in said
    snowmpm_("run", SCENE, "-o", "out", "-q")
    run = snowmpm.open_run(tmp_path / "out")
    (record,) = run.provenance["plugins"]
    assert (record["name"], record["version"]) == ("snow_extras", "0.3")
    last = run.frame(-1)
    assert last.fields["age"] == pytest.approx(0.4, rel=1e-6)
    assert last.fields["speed"] == pytest.approx(abs(last.fields["velocity"]).max(axis=1), rel=0.5)
    assert run.units["age"] == "s" and run.units["speed"] == run.units["blown"] == "m/s"
    assert last.fields["blown"].min() > 0.0 > run.history["air_work"][-1] and run.units["air_work"] == "J"
    assert run.history["momentum_residual"].max() < 1e-9
    assert run.history["max_speed"][1] > 0.5  # the kick
    assert float(run.history["mass"][0]) == pytest.approx(300.0 * 0.25, rel=1e-6)  # half of the rectangle
    assert float(snowmpm_("fastest", "out").stdout.split()[0]) == pytest.approx(max(run.history["max_speed"]), abs=1e-3)
    snowmpm_("render", "out", "-o", "p.png", "--time", "0.2", "--color", "speed", "--size", "160x96")
    assert "linear_drag" in snowmpm_("list").stdout
    said = snowmpm_("run", SCENE, "-o", "other", "--no-plugins", code=2).stderr
    assert 'output.fields.1 = "speed": must be ' in said
    snowmpm_("run", SCENE, "-o", "out", "-q", "--resume", "--set", "end_time=0.5")
    said = snowmpm_("run", SCENE, "-o", "out", "--resume", "--set", "end_time=0.6", "--no-plugins", code=2).stderr
    assert "was made with the plugin snow_extras 0.3, which is not loaded" in said
    assert snowmpm.open_run(tmp_path / "out").times[-1] == 0.5


SLOPE = """
name = "slope"
dimension = 3
end_time = 0.4
output = { interval = 0.02, fields = ["velocity", "blown"] }
domain = { min = [0.0, 0.0, -2.0], max = [4.0, 1.0, 3.0] }
solver = { dx = 0.1 }
terrain = { kind = "plane", angle = 20.0, contact = "slip", friction = { law = "linear_drag", mu = 0.3, drag = 0.5 } }
materials.snow = { kind = "ageing", density = 300.0, youngs_modulus = 1e5, poisson_ratio = 0.2 }
air = { drag = 0.05, wind = [-2.0, 0.0, 0.0] }
[[bodies]]
name = "slab"
material = "snow"
shape = { kind = "layer", bottom = 0.0, top = 0.4, region = { x = [0.4, 1.2], y = [0.2, 0.8] } }
"""


def test_a_run_that_is_killed_goes_on_to_the_same_bits(installed, tmp_path):
    """With the column, the hooks and the state of a component of the package; then its maps."""
    surroundings = {**os.environ, "PYTHONPATH": os.pathsep.join([str(installed), os.environ.get("PYTHONPATH", "")])}
    (tmp_path / "slope.toml").write_text(SLOPE)
    words = [sys.executable, "-m", "snowmpm"]

    def snowmpm_(*more):
        done = subprocess.run([*words, *map(str, more)], cwd=tmp_path, env=surroundings, capture_output=True, text=True,
                              timeout=180)
        assert done.returncode == 0, done.stderr

    going = subprocess.Popen([*words, "run", "slope.toml", "-o", "killed", "-q"], cwd=tmp_path, env=surroundings)
    saved = tmp_path / "killed" / checkpoint.FILE
    deadline = time.monotonic() + 120.0
    while not saved.exists() and going.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    going.kill()
    assert going.wait() == -signal.SIGKILL
    snowmpm_("run", "slope.toml", "-o", "killed", "-q", "--resume")
    snowmpm_("run", "slope.toml", "-o", "whole", "-q")
    killed, whole = (snowmpm.open_run(tmp_path / name) for name in ("killed", "whole"))
    for name in ("velocity", "blown"):
        assert (killed.frame(-1).fields[name] == whole.frame(-1).fields[name]).all()
    assert killed.history["air_work"][-1] == whole.history["air_work"][-1] < 0.0
    snowmpm_("maps", "whole", "-o", "maps")
    assert any((tmp_path / "maps").iterdir())
