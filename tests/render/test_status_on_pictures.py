"""What is not final says so on every picture: films, histories, maps, thalweg."""

import numpy as np
import pytest
from synthetic_runs import slab_2d, slab_3d

from snowmpm.io import Run, RunWriter
from snowmpm.render.history_plot import history_figure
from snowmpm.render.peak_map import map_figure
from snowmpm.render.run_film import view_of

RED = np.array([193, 18, 31])
"""Of warnings."""


def cut_short(folder):
    """The same run, as if it had been stopped."""
    RunWriter.reopen(folder).close(complete=False)
    return Run(folder)


def red(picture):
    """Places (n, 2) of the pixels in the colour of warnings, as shares of the height and the width."""
    there = np.argwhere(np.abs(picture.astype(int) - RED).max(axis=-1) < 12)
    return there / picture.shape[:2]


@pytest.mark.parametrize("made", [slab_2d, slab_3d])
def test_the_last_picture_of_a_film_says_so_in_a_corner_and_no_other(tmp_path, made):
    made(tmp_path, frames=3)
    assert len(red(view_of(Run(tmp_path), (640, 360), "snow").picture(2))) == 0
    view = view_of(cut_short(tmp_path), (640, 360), "snow")
    places = red(view.picture(2))
    assert len(red(view.picture(1))) == 0 and len(places) > 150
    assert places[:, 0].min() > 0.6 and (places[:, 1].max() < 0.35 or places[:, 1].min() > 0.65)


def test_histories_and_maps_say_so(tmp_path):
    slab_3d(tmp_path, particles=500, frames=3)
    finished = history_figure(Run(tmp_path))
    assert finished.get_supxlabel() == ""
    run = cut_short(tmp_path)
    assert history_figure(run).get_supxlabel().startswith("NOT FINAL: The run is not complete")
    texts = [text.get_text() for text in map_figure(run, "peak_depth").axes[0].texts]
    assert any(text.startswith("NOT FINAL:") and "not complete" in text for text in texts)
    assert "N" in texts  # the arrow


def test_projection_and_parameters_stand_below_a_map(tmp_path):
    slab_3d(tmp_path, particles=500, frames=1)
    with RunWriter.reopen(tmp_path) as writer:
        writer.provenance({"dx": 1.5, "scene": "[terrain]\nfriction = 0.35\n[materials.snow]\ncard = 'li_cold_dense'",
                           "crs": 'LOCAL_CS["my grid",UNIT["metre",1]]', "version": "7.1"})
    words = " ".join(map_figure(Run(tmp_path), "peak_depth").get_supxlabel().split())
    for part in ("my grid", "grid spacing 1.5 m", "map cell 2 m", "bed friction 0.35", "snow li_cold_dense",
                 "snowmpm 7.1", "synthetic slope"):
        assert part in words, words
