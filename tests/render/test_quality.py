"""Preview and full pictures show the same; what a preview leaves out."""

import numpy as np
import pytest
from scipy import ndimage
from synthetic_runs import slab_2d, slab_3d

from snowmpm.errors import InputError
from snowmpm.io import Run, RunWriter
from snowmpm.render import quality as qualities
from snowmpm.render import render_run
from snowmpm.render.camera import fit_camera
from snowmpm.render.quality import QUALITIES
from snowmpm.render.run_film import view_of

PREVIEW = QUALITIES["preview"]


@pytest.fixture(scope="module", params=[2, 3])
def run(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    slab_2d(folder, frames=3) if request.param == 2 else slab_3d(folder, particles=20000, frames=3)
    return Run(folder)


def test_a_preview_is_the_picture_but_for_what_is_small(run):
    """The difference after a blur of two of the preview's pixels, in grey levels of 255; the words are as sharp."""
    size = (480, 271)  # no multiple of three
    full, quick = (view_of(run, size, quality=name).picture(1) for name in ("full", "preview"))
    assert full.shape == quick.shape == (271, 480, 3)
    words = np.s_[5:45, 15:110]
    dark = (full[words].max(axis=-1) < 60, quick[words].max(axis=-1) < 60)
    assert dark[0].sum() > 50 and (dark[0] == dark[1]).mean() > 0.99
    off = [ndimage.gaussian_filter(picture.astype(float), (6.0, 6.0, 0.0)) for picture in (full, quick)]
    assert np.abs(off[0] - off[1]).mean() < 4.0
    assert (full != quick).any(axis=-1).mean() > 0.05


def test_pixels_of_a_preview_lie_where_those_of_the_picture_do():
    camera = fit_camera(np.random.default_rng(0).normal(0.0, 1.0, (50, 3)), 0.5, 0.4, (500, 271))
    small = PREVIEW.camera(camera)
    assert small.size == (167, 91)
    points = np.random.default_rng(1).normal(0.0, 0.5, (20, 3))
    for k, side in enumerate(camera.size):
        full, drawn = camera.project(points)[k], small.project(points)[k]
        assert np.allclose(full - 0.5 * side, 3.0 * (drawn - 0.5 * small.size[k]), atol=1e-3)
    mark = np.zeros((91, 167, 3), np.uint8)
    mark[40, 100] = 255
    row, column = ndimage.center_of_mass(PREVIEW.enlarged(mark, camera.size)[..., 0].astype(float))
    assert column + 0.5 - 250.0 == pytest.approx(3.0 * (100.5 - 83.5), abs=0.1)
    assert row + 0.5 - 135.5 == pytest.approx(3.0 * (40.5 - 45.5), abs=0.1)


def test_one_particle_in_four_is_drawn_larger_and_the_same_in_every_frame(tmp_path, monkeypatch):
    monkeypatch.setattr(qualities, "ENOUGH", 500)
    rng = np.random.default_rng(0)
    points, names = rng.random((2400, 3)) * [4.0, 4.0, 1.0], np.arange(2400)
    with RunWriter(tmp_path, provenance={"particle_spacing": 0.2}, dimension=3) as writer:
        for t in range(2):
            turn = rng.permutation(2400)
            writer.frame(float(t), points[turn], {"id": names[turn]})
    view = view_of(Run(tmp_path), (96, 64), "snow", quality="preview")
    (_, first), (_, second) = view._frame(0), view._frame(1)
    for shown in (first, second):
        assert len(shown[0]) == 600 and shown[1] == pytest.approx(0.2 * 4.0 ** (1.0 / 3.0))
    assert set(first[3]) == set(second[3])


@pytest.mark.parametrize(("particles", "every"), [(5_000, 1), (119_999, 1), (120_000, 2), (350_000, 4), (10**7, 4)])
def test_small_runs_keep_their_particles(particles, every):
    assert PREVIEW.share(particles) == every
    assert QUALITIES["full"].share(particles) == 1


def test_what_goes_with_no_preview_is_said(tmp_path):
    slab_3d(tmp_path, particles=200, frames=2)
    with pytest.raises(InputError, match="quality = 'quick': must be one of full, preview"):
        render_run(tmp_path, tmp_path / "a.png", quality="quick")
    with pytest.raises(InputError, match="quality = 'preview': goes without pass"):
        render_run(tmp_path, tmp_path / "a.tif", quality="preview", layer="depth")
    assert not list(tmp_path.glob("a.*"))
