"""What `snowmpm check` advises, `check` accepts: each setting that a caution names is applied to its scene."""

import re
from pathlib import Path

import pytest

from snowmpm.advice.cautions import RULES
from snowmpm.advice.report import advise
from snowmpm.errors import InputError
from snowmpm.reading.toml_text import tables
from snowmpm.scenes import load_scene
from snowmpm.scenes.library import library
from snowmpm.scenes.loader import with_overrides

DOCS = Path(__file__).parents[2] / "docs"
LARGE = {"avalanche_on_raster", "column_collapse_3d", "crown_and_flanks", "impact_mast", "mast", "microstructure",
         "pst", "remote_trigger", "slab_release", "slab_release_interface", "slab_release_resolved", "slope_release",
         "snow_cover"}
COARSER = {"remote_trigger", "slab_release", "slab_release_interface", "slope_release", "snow_cover"}
"""Large ones that are tried on coarser cells too."""
SETTING = re.compile(r'((?:[A-Za-z_]\w*)(?:\.\w+)+) = ("[^"]*"|\[[^\]]*\]|[-+\w.]*\w)')
CHANGES = {
    "as it is": lambda scene: {},
    "coarser": lambda scene: {"solver.dx": 2.0 * scene.solver.dx},
    "much coarser": lambda scene: {"solver.dx": 4.0 * scene.solver.dx},
}


def ways(caution):
    """The settings {key: value} of each way out that a caution names."""
    for way in re.split(r" or (?!less|more|fewer)|; ", caution.cure):
        found = {key: tables(f"value = {text}", key)["value"] for key, text in SETTING.findall(way)}
        if found:
            yield found


def cautions_of(name, change):
    try:
        scene = load_scene(name)
        scene = with_overrides(scene, CHANGES[change](scene))
        return scene, advise(scene).cautions
    except InputError:  # a scene that cannot be on that grid
        return None, ()


def cases():
    names = [*sorted(library()), *(str(path) for path in sorted(DOCS.glob("*.toml")))]
    return [pytest.param(name, change, marks=[pytest.mark.slow] if scene in LARGE or change == "much coarser" else [],
                         id=f"{scene}-{change}")
            for name in names for scene in (Path(name).stem,) for change in CHANGES
            if change == "as it is" or scene not in LARGE - COARSER]


@pytest.mark.parametrize(("name", "change"), cases())
def test_what_is_advised_is_accepted(name, change):
    scene, cautions = cautions_of(name, change)
    for caution in cautions:
        for way in ways(caution):
            accepted = with_overrides(scene, way)
            left = [one for one in advise(accepted).cautions if (one.entry, one.key) == (caution.entry, caution.key)]
            assert len(left) <= 1, f"{caution} -> {way}"


def test_the_ways_of_a_caution_are_found():
    scene, cautions = cautions_of("slab_release_2d", "coarser")
    found = [way for caution in cautions for way in ways(caution)]
    assert scene and any("solver.dx" in way for way in found)
    assert not any(key.endswith(".interface") for way in found for key in way)  # old snow lies below its weak layer
    assert set(RULES) and all(RULES.values())
