"""Switches of the patches to Taichi's inside, and what happens to one that does not fit."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from snowmpm.compiler import patches


@pytest.fixture
def none_applied(monkeypatch):
    """As in a process that has applied no patch yet."""
    monkeypatch.setattr(patches, "_patches", {})
    monkeypatch.delenv(patches.VARIABLE, raising=False)


@pytest.mark.parametrize(("choice", "wanted"), [
    ("", {*patches.GAINS}), ("all", {*patches.GAINS}), ("none", set()),
    ("launch, array_memory", {"launch", "array_memory"})])
def test_the_environment_chooses(monkeypatch, choice, wanted):
    monkeypatch.setenv(patches.VARIABLE, choice)
    assert {name for name in patches.GAINS if patches.wanted(name)} == wanted


def test_a_name_that_is_no_patch_is_refused(monkeypatch):
    monkeypatch.setenv(patches.VARIABLE, "lunch")
    with pytest.raises(ValueError, match="lunch is no patch; there are class_bodies"):
        patches.wanted("launch")


def test_a_patch_that_is_switched_off_changes_nothing(none_applied, monkeypatch):
    monkeypatch.setenv(patches.VARIABLE, "none")
    assert not patches.apply("launch", pytest.fail)
    assert patches.reasons() == {"launch": "switched off"}


def test_a_patch_that_finds_less_than_it_wants_is_undone(none_applied):
    inside = SimpleNamespace(__name__="inside", first=1)

    def install():
        patches.replace("launch", inside, "first", 2)
        patches.replace("launch", inside, "own", 3, new=True)
        assert (inside.first, inside.own) == (2, 3)
        patches.replace("launch", inside, "second", 4)

    with pytest.warns(UserWarning, match="patch launch was made for .*inside has no second") as warned:
        assert not patches.apply("launch", install)
        patches.leave_out("launch", KeyError("again"))
    assert len(warned) == 1
    assert vars(inside) == {"__name__": "inside", "first": 1}
    assert not patches.apply("launch", pytest.fail)


def test_every_patch_is_in_the_guide():
    guide = Path(__file__).parents[2].joinpath("docs", "compiler.md").read_text(encoding="utf-8")
    assert [name for name in patches.GAINS if f"| `{name}` |" not in guide] == []
