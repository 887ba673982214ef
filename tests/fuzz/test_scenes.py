"""Library scenes with some values, keys or characters changed: `snowmpm check` accepts them or says why not."""

import copy
import shutil
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, seed, settings
from hypothesis import strategies as st

from snowmpm.scenes import library
from snowmpm.scenes.library import FOLDER
from snowmpm.scenes.numerics import Sph
from snowmpm.scenes.toml import parse, table_text

COARSE = {"avalanche_on_raster": 3.0, "flow_cold_dense": 0.4, "flow_sliding_slab": 0.4, "flow_warm_plug": 0.4,
          "flow_warm_shear": 0.4, "impact_mast": 0.5, "microstructure": 1.6e-4, "microstructure_2d": 2e-4,
          "natural_release": 0.2, "pst": 0.1, "pst_2d": 0.1, "remote_trigger_2d": 0.2, "skier_trigger": 0.2,
          "slab_release": 0.5, "slab_release_2d": 0.2, "whumpf_2d": 0.2}
"""dx [m] of scenes that are large, with one particle a cell: what is wrong with a scene seldom depends on it."""

SPH = {name: field.default for name, field in Sph.model_fields.items() if field.default_factory is None}
"""Every key of [solver.sph] that has one value for all scenes."""

NUMBERS = st.one_of(
    st.sampled_from([0, -1, 1, 2, 3, 10**30, -(2**63), 1e-300, 1e300, -1e300, 5e-324, float("nan"), float("inf"), 0.5]),
    st.floats(), st.integers(), st.floats(-100.0, 100.0))
WORDS = st.one_of(st.sampled_from(["", "..", "/", "/dev/zero", "/dev/full", "~", "slope.stl", "snow_2d.npz", "plane",
                                   "elastic", "box", "layer", "open", "periodic", "settle", "none", "x", "\u0000"]),
                  st.text(max_size=20))
SCALES = st.one_of(st.floats(0.5, 2.0), st.sampled_from([-1.0, 0.0, 1e-6, 1e-3, 0.1, 10.0, 1e3, 1e6]))
VALUES = st.recursive(st.one_of(NUMBERS, WORDS, st.booleans()), lambda inner: st.one_of(
    st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=5), inner, max_size=3)), max_leaves=6)


def places(data, path=()):
    """Paths of everything in a scene."""
    if path:
        yield path
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        yield from places(value, (*path, key))


def value_at(data, path):
    for key in path:
        data = data[key]
    return data


@st.composite
def mutants(draw):
    """Text of a library scene with one to three changes."""
    name = draw(st.sampled_from(sorted(library())))
    data = copy.deepcopy(parse(FOLDER / f"{name}.toml"))
    if name in COARSE:
        data["solver"]["dx"] = COARSE[name]
    if draw(st.integers(0, 3)) == 0:
        data["solver"] = {"method": "sph", "dx": data["solver"]["dx"], "sph": dict(SPH)}
    elif name in COARSE:
        data["solver"]["particles_per_cell"] = 1
    for _ in range(draw(st.integers(1, 3))):
        paths = list(places(data))
        path = paths[draw(st.integers(0, len(paths) - 1))]
        table = value_at(data, path[:-1])
        change, key = draw(st.sampled_from(["value", "number", *["scaled"] * 6, "gone", "renamed", "moved"])), path[-1]
        if change == "value":
            table[key] = draw(VALUES)
        elif change in ("number", "scaled"):
            numbers = [path for path in paths if isinstance(value_at(data, path), float)]
            if not numbers:
                continue
            *path, key = numbers[draw(st.integers(0, len(numbers) - 1))]
            table = value_at(data, path)
            table[key] = draw(NUMBERS) if change == "number" else table[key] * draw(SCALES)
        elif change == "gone":
            del table[key]
        elif change == "moved":
            table[key] = copy.deepcopy(data[draw(st.sampled_from(sorted(data)))]) if data else 0
        elif isinstance(table, dict):
            table[draw(st.text(max_size=8))] = table.pop(key)
        if not data:
            break
    text = table_text(data)
    if draw(st.integers(0, 4)) == 0 and text:
        at = draw(st.integers(0, len(text) - 1))
        text = text[:at] + draw(st.text(max_size=3)) + text[at + draw(st.integers(0, 9)):]
    return text


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with the files that library scenes name."""
    folder = tmp_path_factory.mktemp("scenes")
    for path in FOLDER.iterdir():
        if path.is_file() and path.suffix != ".toml":
            shutil.copy(path, folder)
    return folder


@pytest.mark.parametrize(("count", "dice"), [
    (60, 0), *(pytest.param(500, number, marks=pytest.mark.slow) for number in range(1, 21))])
def test_mutated_scenes(ended_well, folder, count, dice):
    codes = {0: 0, 2: 0}

    @seed(dice)
    @settings(max_examples=count, deadline=None, database=None, print_blob=False,
              suppress_health_check=list(HealthCheck))
    @given(mutants())
    def check(text):
        path = folder / "scene.toml"
        path.write_bytes(text.encode("utf-8", "surrogatepass"))
        codes[ended_well("check", path)] += 1

    check()
    print(f"{codes[0]} accepted, {codes[2]} refused")
    assert min(codes.values()) > 0.05 * count


def test_the_scenes_themselves_are_accepted(ended_well, folder):
    """What is refused above is refused for what was changed."""
    data = parse(FOLDER / "slab_release_2d.toml")
    path = Path(folder / "scene.toml")
    path.write_text(table_text(data))
    assert ended_well("check", path) == 0
