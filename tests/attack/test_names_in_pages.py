"""Names of every field that are markup, formulas or escape sequences: pages, pictures and tables show them as text."""

import json
import re
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser

import h5py
import numpy as np
import pytest
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from snowmpm.cli import gallery_page as gallery
from snowmpm.errors import InputError
from snowmpm.io import RunWriter

HOSTILE = {
    "script": "</script><script>alert(1)</script>", "image": '<img src=x onerror="alert(2)">',
    "attribute": '" onmouseover="alert(3)" x="', "single": "' onclick='alert(4)", "comment": "--><!--<script>",
    "style": "</style><style>*{display:none}", "title": "</title><script>alert(5)</script>", "entity": "&lt;b&gt;&#60;",
    "formula": r"$\frac{$ and $x_{", "formula_whole": r"$\notacommand{x}$", "braces": "{0} {name} %s %(x)s",
    "markdown": "](javascript:alert(6)) | a | b |", "rich": "[bold red]x[/] [link=http://x]y[/link] [/nothing]",
    "csv": "=cmd|' /C calc'!A0", "null_script": "<scr\u200bipt>", "template": "${alert(7)} {{7*7}} <%= 1 %>",
    "separator": "a\u2028b\u2029c", "long": "<b>" * 30_000,
}


def run_named(folder, text, obstacle="wall"):
    """A run that says this wherever it can say something. (Names of tables have no slash, and are
    printable.)"""
    key = "".join(c for c in text.replace("/", "\u2215") if c.isprintable())[:150]
    record = {"scene_name": text, "scene": f"name = {json.dumps(text)}\n# {text}", "version": text, "taichi": text,
              "numpy": text, "materials": [text, text], "bodies": [text], "device": text, "backend": text,
              "precision": text, "attribution": text, "crs": text, "dx": 0.2, "particle_spacing": 0.2, "seed": text,
              text: text}
    rng = np.random.default_rng(0)
    square = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 1], [0, 4, 1]]), np.array([[0, 1, 2], [0, 2, 3]])
    with RunWriter(folder, provenance=record, terrain=square, obstacles={key: square}, dimension=3,
                   units={"velocity": text}, durable=False) as writer:
        for i in range(3):
            points = rng.random((200, 3)) * 3.0
            writer.history(0.1 * i, {"max_speed": 1.0 * i, key: 1.0 * i, f"steps_{key}": 2.0 * i},
                           {"max_speed": text, key: text})
            loads = {"time": np.array([0.1 * i]), "force": np.ones((1, 3)), "moment": np.ones((1, 3)),
                     "impulse": np.ones((1, 3)) * i, "work": np.ones(1)}
            writer.frame(0.1 * i, points, {"velocity": points, "material": np.arange(200, dtype=np.int32) % 2,
                                           key: points[:, 0]}, loads={key: loads})
        writer.map(key, rng.random((10, 10)), 0.0, 0.0, 0.4, text)
        writer.hazard({"numbers": {text: 1.0}})
    (folder / "summary.json").write_text(json.dumps({"scene": text, "wall_time": 1.0, "dt_causes": {text: 3},
                                                     "wall_time_of": {text: 1.0}, "last": {text: 1.0}, text: text}))
    return key


class Page(HTMLParser):
    """What a browser would make of a page: elements, their attributes, and the texts of scripts."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.scripts, self._open = [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in ("meta", "img", "input", "br"):
            self._open.append(tag)
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag):
        assert self._open and self._open.pop() == tag, (tag, self.getpos())

    def handle_data(self, data):
        if self._open and self._open[-1] == "script":
            self.scripts[-1] += data

    def handle_comment(self, data):
        raise AssertionError(f"a comment: {data[:50]}")


def skeleton(path):
    """Elements and names of attributes of a page; what could run or load is checked on the way."""
    page = Page(path.read_text(encoding="utf-8"))
    assert page._open == []
    for tag, attributes in page.elements:
        assert tag not in ("iframe", "object", "embed", "link", "base", "form", "svg", "math"), tag
        assert not any(name.startswith("on") for name in attributes), attributes
        for name in ("src", "href", "action", "data", "poster"):
            assert attributes.get(name, "data:").startswith(("data:", "#")), attributes
    for text in page.scripts:
        assert "alert(" not in text
        if text.lstrip().startswith("{"):
            json.loads(text)
    return [(tag, sorted(attributes)) for tag, attributes in page.elements]


PAGES = {"page.html": ("render", "run", "-o", "page.html"), "report.html": ("report", "run", "-o", "report.html")}


@pytest.fixture(scope="session")
def plain(program, tmp_path_factory):
    """plain("page.html", name) -> the skeleton of that page of a run with this harmless name."""
    found = {}

    def invoke(page, name):
        if (page, name) not in found:
            folder = tmp_path_factory.mktemp("plain")
            run_named(folder / "run", name)
            ended = program.run(folder, *PAGES[page])
            assert ended.code == 0, ended.err
            found[page, name] = skeleton(folder / page)
        return found[page, name]

    return invoke


USUAL = ("script", "formula")
NAMES = [name if name in USUAL else pytest.param(name, marks=pytest.mark.slow) for name in HOSTILE]


@pytest.mark.parametrize("page", ["page.html", pytest.param("report.html", marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ["script", *(name for name in NAMES if name != "script")])
def test_pages(withstood, tmp_path, plain, page, name):
    """The elements of a page are those of the same page with harmless names, in the same order."""
    key = run_named(tmp_path / "run", HOSTILE[name])
    withstood(*PAGES[page], code=0)
    # Rows of a table are in the order of their names
    assert skeleton(tmp_path / page) == plain(page, "plain" if key > "max_speed" else "a plain one")


@pytest.mark.parametrize("name", NAMES)
def test_drawn_text(withstood, tmp_path, name):
    """Vector graphics are well-formed, and hold nothing that runs or loads."""
    key = run_named(tmp_path / "run", HOSTILE[name])
    withstood("plot", "run", "-o", "history.svg", code=0)
    for element in ElementTree.parse(tmp_path / "history.svg").iter():
        assert element.tag.rsplit("}", 1)[-1] not in ("script", "foreignObject", "iframe", "a")
        for attribute, value in element.attrib.items():
            assert not attribute.lower().startswith("on")
            assert "href" not in attribute or value.startswith(("#", "data:"))
    withstood("render", "run", "--time", "0.1", "--size", "96x64", "-o", "p.png", "--color", "material", code=0)
    withstood("maps", "run", "--files", "pictures", "-o", "maps", code=0)
    assert [path.suffix for path in (tmp_path / "maps").glob("[!.]*")] == [".png"]
    assert not key.startswith("/")


@pytest.mark.parametrize("name", HOSTILE)
def test_printed_text(withstood, tmp_path, name):
    run_named(tmp_path / "run", HOSTILE[name])
    assert withstood("info", "run", code=0).out.count("\n") < 120
    json.loads(withstood("info", "run", "--json", code=0).out)


def test_escape_sequences(withstood, tmp_path):
    """What would move a terminal's cursor or name its window is shown by its numbers."""
    run_named(tmp_path / "run", "plain")
    text = "\x1b[2J\x1b]0;owned\x07\x9b31m\u202ereversed\r\nforged: line"
    with h5py.File(tmp_path / "run" / "run.vtkhdf", "r+") as h5:
        record = json.loads(h5["provenance/record"][()])
        del h5["provenance/record"]
        h5["provenance/record"] = json.dumps({**record, "scene_name": text, "device": text, "materials": [text],
                                              "bodies": [text], "seed": text})
    for arguments in (("info", "run"), ("info", "run", "--json"), ("plot", "run")):
        ended = withstood(*arguments, code=0)
        assert "\nforged" not in ended.out
    (tmp_path / "run").rename(tmp_path / "\x1b[2Jrun")
    for arguments in (("info",), ("plot",), ("maps", "--files", "pictures")):
        withstood(arguments[0], "\x1b[2Jrun", *arguments[1:], code=0)
    withstood("info", "\x1b[2Jnone", code=2)


def picture_noted(folder, **notes):
    text = PngInfo()
    for name, value in notes.items():
        text.add_itxt(name, value)
    folder.mkdir(exist_ok=True)
    Image.new("RGB", (8, 8)).save(folder / "elastic_beam.png", pnginfo=text)


GOOD_NOTES = {"wall_time": "1.0", "device": "a processor", "particles": "10", "dx": "0.1", "time": "1.0", "steps": "10"}


@pytest.mark.parametrize("name", HOSTILE)
def test_gallery(tmp_path, name):
    from snowmpm.cli.gallery import _in_words

    picture_noted(tmp_path, **{**GOOD_NOTES, "device": HOSTILE[name], "settings": HOSTILE[name]})
    page, _ = gallery.write_page(tmp_path, _in_words)
    lines = [line for line in page.read_text(encoding="utf-8").splitlines() if line.startswith("10 particles")]
    assert len(lines) == 1
    assert not re.search(r"(?<!\\)[<>|`\[\]]", lines[0]), lines[0]


@pytest.mark.parametrize("notes", [{}, {**GOOD_NOTES, "dx": "wide"}, {**GOOD_NOTES, "steps": "9" * 5000},
                                   {**GOOD_NOTES, "particles": "nan"}, {"device": "only"}], ids=str)
def test_gallery_of_other_pictures(tmp_path, notes):
    from snowmpm.cli.gallery import _in_words

    picture_noted(tmp_path, **notes)
    if notes:
        with pytest.raises(InputError, match=r"elastic_beam\.png"):
            gallery.write_page(tmp_path, _in_words)
    else:
        gallery.write_page(tmp_path, _in_words)


def test_gallery_of_no_picture(tmp_path):
    (tmp_path / "elastic_beam.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"\xff" * 100)
    with pytest.raises(InputError, match="not a readable picture"):
        gallery.write_page(tmp_path, lambda notes: "")
