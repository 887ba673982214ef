"""Interactive pages and reports: whole in themselves, harmless, and with the run in them."""

import base64
import json
import re
import zlib
from html.parser import HTMLParser

import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d, weak_layer_3d

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.io.remarks import remarks
from snowmpm.render import render_page, render_report
from snowmpm.render.surface_points import surface_points

SMALL = (320, 160)
HOSTILE = """</script><script>alert(1)</script><img src=x onerror="alert('2')">"""


class Tags(HTMLParser):
    """Start tags of a page with their attributes, and whether all are closed."""

    def __init__(self, text):
        super().__init__()
        self.found, self.open = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))
        if tag not in ("meta", "img", "input", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open and self.open.pop() == tag, (tag, self.getpos())


def checked(path):
    """The text of a page, after checking that it is well formed and loads nothing."""
    text = path.read_text(encoding="utf-8")
    tags = Tags(text)
    assert tags.open == []
    for tag, attributes in tags.found:
        for name, value in attributes.items():
            assert not name.startswith("on"), (tag, name)
            if name == "href" and value.startswith("#"):
                assert any(there.get("id") == value[1:] for _, there in tags.found), value  # a place of the page
            elif name in ("src", "href", "data", "poster"):
                assert value.startswith("data:"), (tag, value[:60])
    assert "http-equiv" in text and "default-src 'none'" in text
    assert not re.search(r"(https?:)?//[a-z0-9.-]+\\.[a-z]{2,}", re.sub(r"base64,[^\"]*", "", text), re.IGNORECASE)
    assert "@import" not in text and "url(" not in text
    return text


def content(text):
    """Header and arrays of an interactive page, read as its script reads them."""
    head = json.loads(re.search(r'<script type="application/json">(.*?)</script>', text, re.DOTALL)[1])
    packed = re.search(r'class="data">(.*?)</script>', text, re.DOTALL)[1]
    data, at = zlib.decompress(base64.b64decode(packed)), 0

    def take(kind, n):
        nonlocal at
        values = np.frombuffer(data, kind, n, at)
        at += values.nbytes
        return values

    parts = {}
    if head["terrain"]:
        n, m = head["terrain"]["vertices"], head["terrain"]["facets"]
        parts["ground"], parts["colours"] = take("<u2", 3 * n).reshape(-1, 3), take("u1", 3 * n).reshape(-1, 3)
        parts["facets"] = take("<u4", 3 * m).reshape(-1, 3)
    if head["solids"]:
        take("<u4", 3 * head["solids"]["facets"])
    parts["frames"] = []
    for n in head["frames"]:
        frame = take("<u2", 3 * n).reshape(-1, 3), take("i1", 3 * n).reshape(-1, 3), take("u1", n)
        parts["frames"].append(frame)
        if head["solids"]:
            take("<u2", 3 * head["solids"]["vertices"])
    assert at == len(data)
    low, span = np.array(head["low"]), np.array(head["span"])
    return head, parts, lambda places: low + span * places / 65535.0


def test_page_holds_ground_and_snow_of_every_frame_where_they_are(tmp_path):
    slab_3d(tmp_path, particles=5000, frames=3, cell=5.0, obstacles=True)
    run = Run(tmp_path)
    text = checked(render_page(run, tmp_path / "scene.html", camera="200,35"))
    head, parts, place = content(text)
    assert head["times"] == pytest.approx(run.times.tolist())
    assert head["solids"]["facets"] == 12 + 128
    ground = place(parts["ground"])
    heights = run.terrain.vertices
    assert heights[:, 2].min() - 1.0 <= ground[:, 2].min() and ground[:, 2].max() <= heights[:, 2].max() + 1.0
    assert parts["facets"].max() < len(ground)
    for i, (points, normals, _) in enumerate(parts["frames"]):
        snow = run.frame(i).points
        assert len(points) > 100
        assert np.allclose(place(points).mean(axis=0), snow.mean(axis=0), atol=3.0)  # surface and all: not the same
        assert np.allclose(np.linalg.norm(normals / 127.0, axis=1), 1.0, atol=0.03)
    # What rests is white at the low end of the scale, what moves is not
    assert parts["frames"][0][2].mean() < 20 < parts["frames"][1][2].mean()


def test_page_of_a_section(tmp_path):
    slab_2d(tmp_path, frames=3, obstacles=True)
    text = checked(render_page(tmp_path, tmp_path / "scene.html"))
    head, parts, place = content(text)
    assert len(parts["frames"]) == 3 and head["camera"]["azimuth"] == pytest.approx(np.pi)
    assert np.ptp(place(parts["frames"][0][0])[:, 1]) < 1e-3 * head["span"][0]


def test_surface_is_what_is_seen_of_a_block():
    grid = np.stack(np.meshgrid(*[np.arange(0.05, 2.0, 0.1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    found = surface_points(grid, grid[:, 2], 0.2)
    depth = np.minimum(found.points[:, :2], 2.0 - found.points[:, :2]).min(axis=1)
    assert (np.minimum(depth, 2.0 - found.points[:, 2]) < 0.21).all()
    assert len(found.points) < 0.6 * 10**3
    top = (found.points[:, 2] > 1.85) & (depth > 0.4)
    assert top.sum() > 20 and (found.normals[top, 2] > 0.99).all()
    side = (found.points[:, 0] > 1.85) & (np.abs(found.points[:, 1:] - 1.0) < 0.5).all(axis=1)
    assert side.sum() > 5 and (found.normals[side, 0] > 0.8).all()
    assert np.allclose(found.values, found.points[:, 2], atol=1e-5)
    assert len(surface_points(np.full((4, 3), np.nan), np.zeros(4), 0.1).points) == 0


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reported")
    weak_layer_3d(folder)
    return Run(folder), checked(render_report(folder, folder / "report.html", size=SMALL))


def test_report_holds_settings_pictures_curves_and_how_to_make_it_again(reported):
    _, text = reported
    for words in ("<h1>cut</h1>", "Settings", "anticrack_cam_clay", "snowmpm run scene.toml", "Over time.",
                  "the weak layer as it fails, what lies over it cut away", 'class="viewer"', "Audit at the end"):
        assert words in text, words
    assert text.count("data:image/jpeg;base64,") >= 4 and "data:image/png;base64," in text
    assert len(text) < 12e6


def test_report_without_the_scene_to_turn_is_small(reported, tmp_path):
    run, text = reported
    still = checked(render_report(run, tmp_path / "still.html", interactive=False, size=SMALL))
    assert 'class="viewer"' not in still and "<script" not in still
    assert len(still) < len(text)


def test_what_a_scene_file_says_stays_text(tmp_path):
    record = {"scene_name": HOSTILE, "scene": f'name = "{HOSTILE}"', "version": HOSTILE, "materials": [HOSTILE],
              "device": HOSTILE, "particle_spacing": 0.2, "attribution": HOSTILE}
    with RunWriter(tmp_path, provenance=record, dimension=3) as writer:
        for t in (0.0, 1.0):
            points = np.random.default_rng(0).random((200, 3))
            writer.history(t, {"max_speed": t}, {"max_speed": HOSTILE})
            writer.frame(t, points, {"material": np.zeros(200, np.int32), "velocity": points})
    for path in (render_page(tmp_path, tmp_path / "scene.html", color="material"),
                 render_report(tmp_path, tmp_path / "report.html", size=SMALL)):
        text = checked(path)
        assert "<script>alert" not in text and "<img src=x" not in text
        assert "&lt;script&gt;alert(1)" in text


def test_warnings_say_what_is_out_of_the_ordinary(tmp_path):
    sound = {"mass": 100.0, "removed_mass": 0.0, "momentum_residual": 1e-7, "unconverged": 0, "plastic_work": 50.0,
             "contact_work": 40.0, "kinetic_energy": 10.0, "energy_remainder": 1.0, "occupied_cells": 1000,
             "emptied_cells": 2, "contact_lines": 100, "contact_spared": 1}
    cases = {None: "", "removed_mass": "10 % of the mass", "momentum_residual": "momentum", "unconverged": "3 stress",
             "energy_remainder": "20.0% of the energy", "emptied_cells": "5.0% of the cells",
             "contact_spared": "59 of 200 lines"}
    bad = {"removed_mass": 10.0, "momentum_residual": 0.1, "unconverged": 3, "energy_remainder": 20.0,
           "emptied_cells": 50, "contact_spared": 59}
    for k, (name, words) in enumerate(cases.items()):
        with RunWriter(tmp_path / str(k), provenance={}) as writer:
            row = {**sound, "contact_lines": 200, **({name: bad[name]} if name else {})}
            writer.history(0.0, sound, {})
            writer.history(1.0, row, {})
            writer.frame(0.0, np.zeros((1, 3)), {})
            writer.close(complete=True)
        found = list(remarks(Run(tmp_path / str(k))))
        assert len(found) == (1 if name else 0) and words in "".join(found)


def test_what_a_saw_or_a_removal_took_is_not_missing(tmp_path):
    """Only what has left the domain is: 1 of the 11 kg that are gone."""
    with RunWriter(tmp_path, provenance={}) as writer:
        for time, lost, taken in ((0.0, 0.0, 0.0), (1.0, 11.0, 10.0)):
            writer.history(time, {"mass": 100.0 - lost, "removed_mass": lost, "taken_mass": taken}, {})
        writer.frame(0.0, np.zeros((1, 3)), {})
        writer.close(complete=True)
    (told,) = remarks(Run(tmp_path))
    assert told.startswith("1 % of the mass left the model")


def test_a_run_at_rest_is_nothing_to_warn_of(tmp_path):
    """Whatever share of the little that moved the scheme took: it is nothing beside the energy that is stored."""
    with RunWriter(tmp_path, provenance={}) as writer:
        for time in (0.0, 1.0):
            writer.history(time, {"mass": 100.0, "removed_mass": 0.0, "elastic_energy": 10.0, "plastic_work": 0.0,
                                  "contact_work": 1e-8, "kinetic_energy": 1e-7, "energy_remainder": 1e-2 * time}, {})
        writer.frame(0.0, np.zeros((1, 3)), {})
        writer.close(complete=True)
    assert list(remarks(Run(tmp_path))) == []


def test_other_endings_are_refused(tmp_path):
    slab_3d(tmp_path, particles=500, frames=2)
    for draw in (render_page, render_report):
        with pytest.raises(InputError, match=r"must end in \.html"):
            draw(tmp_path, tmp_path / "page.doc")
