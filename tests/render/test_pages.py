"""Interactive pages and reports: whole in themselves, harmless, and with the run in them."""

import numpy as np
import pytest
from page_content import checked
from PIL import Image
from synthetic_runs import slab_3d, weak_layer_3d

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.io.remarks import remarks
from snowmpm.render import render_page, render_report, report_pdf
from snowmpm.render.document import Document, Picture, Section
from snowmpm.render.surface_points import surface_points

SMALL = (320, 160)
HOSTILE = """</script><script>alert(1)</script><img src=x onerror="alert('2')">"""


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
    for words in ("<h1>cut", "Settings", "anticrack_cam_clay", "snowmpm run scene.toml", "Over time.",
                  "the weak layer as it fails, what lies over it cut away", 'class="viewer"', "Audit at the end"):
        assert words in text, words
    assert text.count("data:image/jpeg;base64,") >= 4 and "data:image/png;base64," in text
    assert len(text) < 12e6


def test_report_without_the_scene_to_turn_is_small(reported, tmp_path):
    run, text = reported
    still = checked(render_report(run, tmp_path / "still.html", interactive=False, size=SMALL))
    assert 'class="viewer"' not in still and "<script" not in still
    assert len(still) < len(text)


def test_a_heading_of_a_pdf_stands_on_the_page_of_its_picture(tmp_path, monkeypatch):
    places = []

    def noted(original):
        def call(sheet, *args):
            original(sheet, *args)
            places.append(sheet._number)

        return call

    for name in ("heading", "picture"):
        monkeypatch.setattr(report_pdf._Sheet, name, noted(vars(report_pdf._Sheet)[name]))
    Image.new("RGB", (400, 300)).save(tmp_path / "one.png")
    sections = [Section(f"Part {k}", [Picture(tmp_path / "one.png", "a picture")]) for k in range(5)]
    report_pdf.write_pdf(Document("Report", "", sections, ""), tmp_path / "report.pdf")
    assert places[::2] == places[1::2]
    assert len(set(places)) > 2


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
             "parted_share": 0.02, "contact_lines": 100, "contact_spared": 1}
    cases = {None: "", "removed_mass": "10 % of the mass", "momentum_residual": "momentum", "unconverged": "3 stress",
             "energy_remainder": "took 28.6% of the energy", "parted_share": "15.0% of the snow",
             "contact_spared": "59 of 200 lines"}
    bad = {"removed_mass": 10.0, "momentum_residual": 0.1, "unconverged": 3, "energy_remainder": 40.0,
           "parted_share": 0.15, "contact_spared": 59}
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
