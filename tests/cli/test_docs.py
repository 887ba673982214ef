"""`snowmpm docs`: the guides come with the program, and messages name them."""

import ast
import re
import webbrowser
from pathlib import Path

import pytest

from snowmpm.cli.docs import guides
from snowmpm.cli.reference import PAGES

ROOT = Path(__file__).parents[2]


def test_every_guide_is_listed_with_what_it_is_about(call):
    result = call("docs")
    assert result.code == 0
    own = {path.stem for path in (ROOT / "docs").glob("*.md")}
    lines = [line for line in result.out.splitlines() if line and "--" not in line]
    listed = {line.split()[0]: line.split(maxsplit=1)[1] for line in lines}
    assert own | {"scenes", "tutorial", "materials", "conventions"} | set(PAGES) == set(listed)
    assert all(len(about) > 3 for about in listed.values())


@pytest.mark.parametrize("name", sorted(guides()))
def test_every_guide_can_be_shown(call, name):
    result = call("docs", name)
    assert result.code == 0 and len(result.out) > 1000
    assert "![" not in result.out


def test_a_guide_in_the_browser(call, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    result = call("docs", "depth_averaged", "--browser")
    assert result.code == 0 and opened and opened[0].startswith("file://")
    page = Path(result.out.strip())
    text = page.read_text(encoding="utf-8")
    assert "<table>" in text and "<script" not in text
    for one in page.parent.glob("*.html"):
        for address, place in re.findall(r'<a href="([^"#]*)(?:#([^"]*))?"', one.read_text(encoding="utf-8")):
            target = (page.parent / address if address else one)
            assert address.startswith("http") or target.exists(), (one.name, address)
            assert not place or f'id="{place}"' in target.read_text(encoding="utf-8"), (one.name, address, place)


def test_words_are_found(call):
    result = call("docs", "--find", "PARTICLES_PER_CELL")
    assert result.code == 0 and any(line.startswith("keys: ") for line in result.out.splitlines())
    assert "no guide contains" in call("docs", "--find", "no such words").out
    only = call("docs", "cards", "--find", "sand").out.splitlines()
    assert only and all(line.startswith("cards: ") for line in only)


def test_a_wrong_name(call):
    result = call("docs", "interfaces")
    assert result.code == 2 and "did you mean interface?" in result.err


def test_messages_and_scenes_name_guides_that_are_there():
    """By the command that shows them: a file of the repository is not there for who installed a wheel."""
    named = set()
    for path in [*(ROOT / "snowmpm").rglob("*.py"), *(ROOT / "render").rglob("*.py"), *(ROOT / "scenes").rglob("*.py")]:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        told = {id(node.body[0].value) for node in ast.walk(tree)
                if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and node.body
                and isinstance(node.body[0], ast.Expr)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
                named |= set(re.findall(r"snowmpm docs (\w+)", node.value))
                assert not re.search(r"[(;:,] ?docs/\w+\.md\)?", node.value), f"{path}: {node.value[:80]}"
    for path in (ROOT / "scenes").rglob("*.toml"):
        text = path.read_text(encoding="utf-8")
        named |= set(re.findall(r"snowmpm docs (\w+)", text))
        assert "docs/" not in text, path
    assert len(named) > 3 and named - {"NAME"} <= set(guides())
