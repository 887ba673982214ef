"""What the guides say of a key that is left out is what a scene without it gets."""

import importlib.util
import re
from pathlib import Path

import pytest

import snowmpm
from snowmpm.campaigns.cluster import DEATHS
from snowmpm.cli import watch
from snowmpm.components.face_loads.from_scene import PENALTY, SOLVED_PENALTY
from snowmpm.components.flow_water.declare import FlowingWater
from snowmpm.components.forest_and_deposition.declare import Deposition, Forest
from snowmpm.components.rigid_bodies.impulses import SWEEPS
from snowmpm.components.two_velocities.declare import MovingWater
from snowmpm.implicit.linear import MOST_DIRECT
from snowmpm.running.rest import rested
from snowmpm.scenes import load_scene
from snowmpm.scenes.dams import Dam
from snowmpm.scenes.numerics import Depth, Implicit, Sph
from snowmpm.scenes.switch import SHARES, Switch

ROOT = Path(__file__).parents[2]
AT_REST = ROOT / "tests" / "resume" / "at_rest.toml"
NUMBERS = {"ten": 10.0, "six": 6.0}


def fresh(module, name):
    """A constant as the file has it, whatever the tests have set."""
    spec = importlib.util.spec_from_file_location("fresh", module.__file__)
    spec.loader.exec_module(again := importlib.util.module_from_spec(spec))
    return getattr(again, name)


def of(model, key):
    return model.model_fields[key].default


SAID = {
    "docs/unattended.md": [(r"a line to stderr every (ten)\s+seconds", lambda: fresh(watch, "LINE_INTERVAL"))],
    "docs/depth_averaged.md": [
        (r"`solver.depth.damping` .*\| ([\d.]+) \|", lambda: of(Depth, "damping")),
        (r"`solver.depth.mixing` .*\| ([\d.]+) \|", lambda: of(Depth, "mixing")),
        (r"`slope` of the sides \[degrees, (\d+)\]", lambda: of(Dam, "slope")),
        (r"`\[terrain.deposition\]` with `time` T \[s, (\d+)\]", lambda: of(Deposition, "time")),
        (r"\| `drag` .*\| ([\d.]+) in AvaFrame", lambda: of(Forest, "drag")),
        (r"`share` \(([\d.]+)\), `speed`", lambda: SHARES["flowing"]),
        (r"`speed` \(([\d.]+) m/s\)", lambda: of(Switch, "speed")),
        (r"has lost them \| `share` \(([\d.]+)\)", lambda: SHARES["broken"])],
    "docs/water.md": [
        (r"`grain_density` .*\| ([\d.]+) kg/m³ \|", lambda: of(MovingWater, "grain_density")),
        (r"`layers` .*\| (\d+): ", lambda: of(FlowingWater, "layers"))],
    "docs/implicit.md": [
        (r"for newmark (ten) cells a wave", lambda: of(Implicit, "courant")),
        (r"directly up to ([\d,]+) unknowns in 2-D", lambda: MOST_DIRECT[2]),
        (r"unknowns in 2-D and ([\d,]+) in 3-D", lambda: MOST_DIRECT[3])],
    "docs/surface_loads.md": [
        (r"penalty = ([\d.]+) +#", lambda: PENALTY),
        (r"# (\d+) with implicit steps, when missing", lambda: SOLVED_PENALTY)],
    "docs/structures.md": [
        (r"end after (\d+) at the latest", lambda: SWEEPS)],
    "docs/sph.md": [(r"A fixed power of (\d+), the default", lambda: of(Sph, "artificial_stress_power"))],
    "docs/campaigns.md": [(r"after (six) deaths at one run", lambda: DEATHS + 1)]}


@pytest.mark.parametrize(("page", "sentence", "value"), [
    pytest.param(page, sentence, value, id=f"{page} {sentence[:30]}")
    for page, rows in SAID.items() for sentence, value in rows])
def test_the_guide_says_what_is_done(page, sentence, value):
    said = re.search(sentence, (ROOT / page).read_text(encoding="utf-8"))
    assert said, sentence
    assert value() == NUMBERS.get(said[1]) or value() == float(said[1].replace(",", ""))


def test_rest_lasts_a_twentieth_of_the_end_time(tmp_path):
    scene = load_scene(AT_REST)
    run = snowmpm.run(scene.model_copy(update={"stop": scene.stop.model_copy(update={"hold": None})}), tmp_path)
    since = float(run.summary["ended"].split()[-2])
    assert rested(run)
    assert run.times[-1] == pytest.approx(since + scene.end_time / 20.0, abs=0.11)
