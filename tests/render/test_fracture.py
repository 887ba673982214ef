"""The weak layer: found in the scene, coloured by its damage, seen where the slab is cut away."""

from types import SimpleNamespace

import numpy as np
import pytest
from synthetic_runs import slab_3d, weak_layer_3d

from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render import light
from snowmpm.render.camera import fit_camera
from snowmpm.render.fracture import Cutaway, WeakLayer
from snowmpm.render.run_film import view_of

SIZE = (320, 200)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("weak")
    weak_layer_3d(folder)
    return Run(folder)


@pytest.fixture(scope="module")
def cut(run):
    return view_of(run, SIZE, camera="150,40", cutaway=True)


@pytest.fixture(scope="module")
def whole(run):
    return view_of(run, SIZE, "fracture", camera="150,40")


def redness(picture):
    return (picture[..., 0].astype(int) - picture[..., 2] > 60) & (picture[..., 1] < 120)


def test_weak_layer_is_the_body_that_is_cut(run):
    assert WeakLayer.of(run) == WeakLayer(weak=1, over=(0,))


def test_only_the_slab_on_the_side_of_the_camera_is_left_out(run, cut):
    view = cut
    frame = view.fields_of(0)
    shown = Cutaway.of(run, WeakLayer.of(run), view.camera).shown(frame)
    near = np.sign(view.camera.eye[1]) * frame.points[:, 1] > 0.1
    slab = frame.fields["material"] == 0
    assert not shown[slab & near].any()
    assert shown[~slab].all() and shown[slab & (np.sign(view.camera.eye[1]) * frame.points[:, 1] < -0.1)].all()


def test_on_the_flat_the_cut_runs_along_the_slab():
    """A saw test's column, 3 m by 0.4 m: half of its width goes, not half of its length."""
    x, y = np.meshgrid(np.arange(0.0, 3.0, 0.1), np.arange(0.0, 0.4, 0.1), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 0.2)]).astype(np.float32)
    frame = SimpleNamespace(points=points, fields={"material": np.ones(len(points))})
    flat = SimpleNamespace(frame=lambda i, names: frame, path="run")
    camera = fit_camera(points, np.radians(150.0), np.radians(30.0), (320, 180))  # from the south-east
    shown = Cutaway.of(flat, WeakLayer(0, (1,)), camera).shown(frame)
    assert shown.sum() == len(points) // 2
    assert (shown == (points[:, 1] > 0.15)).all()


def test_the_crack_is_seen_only_through_the_cut(cut, whole):
    middle = np.array([[10.0, np.sign(cut.camera.eye[1]) * 3.0, 1.0 - 10.0 * np.tan(np.radians(30.0))]])
    column, row = (int(v[0]) for v in cut.camera.project(middle)[:2])
    around = np.s_[row - 3 : row + 4, column - 3 : column + 4]
    assert redness(cut.picture(2))[around].mean() > 0.9
    assert not redness(cut.picture(0))[:155].any()  # nothing is broken at first; below is the scale
    assert not redness(whole.picture(2))[around].any()
    assert redness(cut.picture(2))[:155].sum() > 1.5 * redness(cut.picture(1))[:155].sum() > 0


def test_all_but_the_weak_layer_stays_snow(whole):
    view = whole
    frame = view.fields_of(2)
    colours = view.layer.colours(frame, view.table, np.float32([0.5, 0.6, 0.7]))
    slab = frame.fields["material"] == 0
    assert np.allclose(colours[slab], [0.5, 0.6, 0.7])
    assert np.allclose(colours[~slab & (frame.fields["damage"] == 1.0)], light.decode(view.scale.table()[-1]))


def test_runs_without_a_weak_layer_are_refused(tmp_path):
    slab_3d(tmp_path, particles=2000, frames=2)
    with pytest.raises(InputError, match="no weak layer"):
        view_of(Run(tmp_path), SIZE, "fracture")
