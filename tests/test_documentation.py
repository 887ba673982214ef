"""Every public name says what it is, and the guides say what is true."""

import ast
import functools
import re
import shlex
import shutil
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = [path for folder in ("snowmpm", "materials", "scenes", "render")
           for path in sorted((ROOT / folder).rglob("*.py"))
           if not any(part.is_symlink() for part in (path, *path.parents))]
GUIDES = [ROOT / "README.md", *sorted(path for folder in ("docs", "scenes", "materials", "render")
                                      for path in (ROOT / folder).glob("*.md"))]


def public(node):
    return [item for item in node.body if isinstance(item, ast.FunctionDef | ast.ClassDef) and item.name[0] != "_"]


@functools.cache
def parsed():
    """Trees of all sources by path, which nothing changes: to parse them takes seconds."""
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES}


def test_every_guide_has_its_place_on_the_site():
    """CI builds the site strictly, but only with the extra `docs`; this says it without."""
    placed = set(re.findall(r"^ +- ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), re.MULTILINE))
    guides = {path.relative_to(ROOT).as_posix() for path in (ROOT / "docs").glob("*.md")}
    assert guides - placed == set()


def test_every_module_class_and_function_is_documented():
    bare = []
    for path, tree in parsed().items():
        name = path.relative_to(ROOT).as_posix()
        bare += [] if ast.get_docstring(tree) else [name]
        bare += [f"{name}: {item.name}" for item in public(tree) if not ast.get_docstring(item)]
    assert bare == []


def exported():
    """Names that the packages offer: those in the `__all__` of an __init__ file."""
    names = set()
    for path in SOURCES:
        if path.name == "__init__.py":
            for node in parsed()[path].body:
                if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__":
                    names |= {item.value for item in node.value.elts if isinstance(item, ast.Constant)}
    return names


def test_every_member_of_what_the_packages_offer_is_documented():
    """A method or property has a docstring, or its class tells of it, or a class whose contract it fulfils does."""
    classes = [item for tree in parsed().values() for item in public(tree) if isinstance(item, ast.ClassDef)]
    promised = defaultdict(bool)
    for item in classes:
        for member in public(item):
            told = re.search(rf"\b{member.name}\b", ast.get_docstring(item) or "")
            promised[member.name] |= bool(ast.get_docstring(member) or told)
    offered = exported()
    assert {"Run", "Simulation", "Scene", "CohesiveCamClay", "render_run"} <= offered
    bare = [f"{item.name}.{member.name}" for item in classes if item.name in offered for member in public(item)
            if not promised[member.name]]
    assert bare == []


def typed(text):
    """`snowmpm` command lines of a guide's code blocks, in their order."""
    for language, block in re.findall(r"```(\w*)\n(.*?)```", text, re.DOTALL):
        for line in block.replace("\\\n", " ").split("\n") if language in ("", "sh") else ():
            yield from re.findall(r"(?:^|&& )\s*(snowmpm [a-z][^#&|]*)", line)


def commands(text):
    """The same and those among the words."""
    yield from typed(text)
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    yield from re.findall(r"`(snowmpm [a-z][^`]*)`", text)


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_commands_and_options_of_a_guide_exist(guide):
    import typer

    from snowmpm.cli.app import app

    program = typer.main.get_command(app)
    for command in commands(guide.read_text(encoding="utf-8")):
        words = command.split()[1:]
        assert words[0] in program.commands, command
        place = program.commands[words[0]]
        place = getattr(place, "commands", {}).get("".join(words[1:2]), place)  # of a group, such as campaign
        known = {option for parameter in place.params for option in parameter.opts}
        for word in words[1:]:
            option = word.partition("=")[0]
            assert not option.startswith("-") or option in {*known, "--help"}, command


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_links_of_a_guide_lead_somewhere(guide):
    text = guide.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text):
        assert target.startswith("http") or (guide.parent / target).exists(), target


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_commands_of_a_guide_may_be_typed_as_they_stand(guide, tmp_path, monkeypatch, capsys):
    """From top to bottom in an empty folder: arguments are taken, `new` writes its scene, `run` and `check` know it.

    Runs themselves are not computed.
    """
    import typer

    from snowmpm.cli.app import app
    from snowmpm.cli.options import setting_values
    from snowmpm.errors import InputError
    from snowmpm.scenes import library, load_scene
    from snowmpm.scenes.library import FOLDER

    monkeypatch.chdir(tmp_path)
    shutil.copy(FOLDER / "valley.asc", "dem.asc")
    shutil.copy(FOLDER / "valley_release.geojson", "release.geojson")
    text = guide.read_text(encoding="utf-8")
    for script in re.findall(r'^python -c "\n(.*?)"$', text, re.DOTALL | re.MULTILINE):
        exec(script, {})
    if not Path("slope.stl").exists():
        shutil.copy(FOLDER / "slope.stl", "slope.stl")
    program = typer.main.get_command(app)
    for line in typed(text):
        name, *words = shlex.split(line)[1:]
        if "/path/" in line or any(word.isupper() for word in (name, *words)):
            continue  # a place for the reader's own
        command = program.commands[name]
        try:
            values = command.make_context(name, list(words)).params
        except typer.Exit as answered:  # options that answer by themselves, such as --definitions
            assert answered.exit_code == 0
            continue
        except Exception as error:
            pytest.fail(f"{line}: {error}")
        if name == "new" and words:
            try:
                app([name, *words, "--overwrite"])  # a guide shows several for one name
            except SystemExit as end:
                assert not end.code, f"{line}: {capsys.readouterr().err}"
        elif name in ("run", "check"):
            scene = values["scene"]
            assert scene in library() or Path(scene).exists() or guide.name != "TUTORIAL.md", line
            if "cohesionn" in line:  # misspelt on purpose
                with pytest.raises(InputError, match="did you mean cohesion"):
                    load_scene(scene, setting_values(values["settings"]))
            elif scene in library() or Path(scene).exists():
                load_scene(scene, setting_values(values["settings"]))


def sections(text):
    """(heading, text) of a guide, from one heading to the next of any depth, without blocks of code."""
    code = re.compile(r"```.*?```", re.DOTALL)
    parts = re.split(r"^(#+ .*)$", code.sub(lambda block: block[0].replace("#", " "), text), flags=re.MULTILINE)
    return list(zip(["", *parts[1::2]], parts[0::2], strict=True))


def tables(text):
    """(head, rows) of the tables of a guide."""
    for block in re.findall(r"(?:^\|.*\n)+", text + "\n", re.MULTILINE):
        head, _, *rows = block.splitlines()
        yield head, rows


def measured(head, rows):
    """Whether a table holds measured numbers, decimals or percentages: it is no list of keys, laws or questions, nor
    one of calls (`tests/materials/test_conventions.py` evaluates those)."""
    return (not re.search(r"\b(key|parameter|published|distribution|question|call)\b", head)
            and any(re.search(r"\d\.\d|\d %|\de-\d", row) for row in rows))


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_tables_of_figures_say_where_they_come_from(guide):
    """The section names the test that checks them, the script or the command that makes them."""
    text = guide.read_text(encoding="utf-8")
    bare = [heading for heading, part in sections(text) if any(measured(*table) for table in tables(part))
            and not re.search(r"test_\w+\.py|tests/\w+/\w+\.py|(?m:^|`)snowmpm [a-z]|not kept", part)]
    assert bare == []


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_tests_and_scripts_that_a_guide_names_exist(guide):
    names = {path.name for path in (ROOT / "tests").rglob("*.py")}
    text = guide.read_text(encoding="utf-8")
    assert {name for name in re.findall(r"\b(test_\w+\.py)\b", text)} <= names
    assert [place for place in re.findall(r"\b(tests/[\w/]+\.py)\b", text) if not (ROOT / place).exists()] == []


def test_the_first_page_is_short():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.count("\n") <= 120 and len(text.encode()) <= 9_000


def test_the_index_names_every_guide():
    text = (ROOT / "docs" / "index.md").read_text(encoding="utf-8")
    assert [path.name for path in sorted((ROOT / "docs").glob("*.md"))
            if path.name != "index.md" and f"({path.name})" not in text] == []


SMALLER = {'{"solver.dx": 0.1, "end_time": 2.0}': '{"solver.dx": 0.2, "end_time": 0.05, "initial.stress": "geostatic"}',
           "sim.time < 1.2": "sim.time < 0.02"}
"""What is changed of the guide's Python for a quick test."""


@pytest.mark.parametrize("smaller", [SMALLER, pytest.param({}, marks=pytest.mark.slow)], ids=["smaller", "as it is"])
def test_python_of_the_guide_runs_as_it_stands(smaller, tmp_path, monkeypatch, capsys):
    """From top to bottom in an empty folder; the numbers that it promises in its comments come out."""
    pytest.importorskip("xarray")
    monkeypatch.chdir(tmp_path)
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 4
    first = re.search(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)[1]
    assert set(first.split("\n")) <= set(blocks[0].split("\n"))
    for old, new in smaller.items():
        assert any(old in block for block in blocks)
        blocks = [block.replace(old, new) for block in blocks]
    names = {}
    for block in blocks:
        exec(block, names)
    printed = capsys.readouterr().out
    assert "Run slab_release_2d (2-D, complete)" in printed
    assert repr(names["sim"]).startswith("Simulation of slab_release_2d (2-D)\n  time")
    assert "ParticleFields(" in repr(names["sim"].particles) and "101 steps, p = 1.258e+05 Pa" in repr(names["path"])
    p, q = (float(word) for word in printed.split("\n")[-2].split())
    assert f"# {p / 1e3:.1f} kPa, {q / 1e3:.1f} kPa" in text


def test_keys_of_saw_tests_and_of_the_end_are_in_the_guide():
    """Those of the schema: a key that is added to it is added there."""
    from snowmpm.scenes.saw_test import SawTest, WeakLayer
    from snowmpm.scenes.stop import Stop

    guide = (ROOT / "scenes" / "README.md").read_text(encoding="utf-8")
    keys = {"initial.from", *(field for spec in (SawTest, WeakLayer, Stop) for field in spec.model_fields)}
    assert sorted(key for key in keys if not re.search(rf"`{re.escape(key)}[` ]", guide)) == []


CASES = (ROOT / "docs" / "verification.md").read_text(encoding="utf-8")


def test_cases_that_tests_cite_are_on_the_page():
    cited = {name for path in (ROOT / "tests").rglob("test_*.py")
             for name in re.findall(r"\b(?:T1\.\d|M[1-9]\d?[a-f]?|G[1-9]|S[1-7])\b", path.read_text(encoding="utf-8"))}
    assert {"M5", "M18c", "S1", "T1.9"} <= cited
    assert sorted(name for name in cited if not re.search(rf"\b{re.escape(name)}\b", CASES)) == []


def test_tests_that_the_page_of_cases_names_exist():
    present = {path.name for path in (ROOT / "tests").rglob("test_*.py")}
    assert set(re.findall(r"\btest_\w+\.py\b", CASES)) <= present


def words_of_names():
    """Every name in the sources, and every string that could be one, as words: ContactBlocks -> contact blocks."""
    names = {path.stem for path in SOURCES}
    for tree in parsed().values():
        for node in ast.walk(tree):
            names |= {getattr(node, key, None) for key in ("id", "attr", "arg", "name")}
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.isidentifier():
                names.add(node.value)
    apart = (re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name) for name in names if name)
    return "\n".join(" ".join(name.lower().strip("_").split("_")) for name in apart)


def test_words_of_the_glossary_are_those_of_the_code():
    table = (ROOT / "docs" / "developer.md").read_text(encoding="utf-8").partition("## Glossary")[2]
    words = [word.strip() for row in re.findall(r"^\| ([^|]+) \|", table, re.MULTILINE)[1:] for word in row.split(",")]
    names = words_of_names()
    assert len(words) > 30
    assert [word for word in words if not re.search(rf"\b{re.escape(word.lower())}(s|es)?\b", names)] == []


def figures(name):
    """Rows of a table of the benchmarks."""
    import csv

    with (ROOT / "tests" / "benchmarks" / "figures" / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_speeds_of_the_guide_are_those_of_the_tables():
    """Nanoseconds of a step by its parts, and of the stress update: rounded, or the least where that is said."""
    text = (ROOT / "docs" / "step_times.md").read_text(encoding="utf-8")
    steps = {(row["case"], row["precision"], row["basis"], row["gradient"]): row for row in figures("mpm_step.csv")
             if (row["threads"], row["transfer"]) == ("1", "apic") and 249e3 < float(row["particles"]) < 251e3}
    told = {"3-D, cohesive Cam-Clay, half yielding": ("half3", "affine"),
            "the same with gradients of the shape functions": ("half3", "shape"),
            "3-D, elastic": ("block3", "affine"),
            "2-D, cohesive Cam-Clay, half yielding": ("half2", "affine"),
            "3-D layer 1.2 cells thick on a slope, contact included": ("layer3", "affine")}
    for words, (case, gradient) in told.items():
        shown = re.search(rf"^\| {re.escape(words)} \| (.*) \|$", text, re.MULTILINE)[1].split(" | ")
        single, double = (steps[case, precision, "quadratic", gradient] for precision in ("f32", "f64"))
        parts = [single[name] for name in ("ns", "particles_to_grid", "update_grid", "grid_to_particles")]
        assert [float(number) for number in shown[:4]] == pytest.approx([float(part) for part in parts], abs=0.5), words
        assert min(abs(float(shown[4]) - float(double[name])) for name in ("ns", "least")) <= 0.5, words
    laws = {row["law"]: float(row["ns_per_update"]) for row in figures("stress_update.csv")
            if (row["dimension"], row["precision"]) == ("3", "f32")}
    for law in ("mohr_coulomb", "hypoplastic", "stomakhin_snow"):
        assert int(re.search(rf"`{law}` \(no packs[^|]*\| (\d+) \|", text)[1]) == round(laws[law])
