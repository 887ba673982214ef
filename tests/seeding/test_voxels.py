"""Bodies from voxel images: what is filled, from every format; and the made-up microstructure."""

from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from snowmpm.errors import InputError
from snowmpm.random_microstructure import main, random_microstructure
from snowmpm.scenes import Scene
from snowmpm.seeding import seed_body

SIDE = 0.5  # m, of a voxel


def image(dim):
    """Voxels that no mirror image and no exchange of axes leaves as they are."""
    voxels = np.zeros((3, 5) if dim == 2 else (2, 3, 4), np.uint8)
    voxels[0, :2] = 1
    voxels[-1, -1] = 1
    voxels[..., 1] |= 2
    return voxels


def write(voxels, path):
    """The same image in the format that the ending names."""
    if path.suffix == ".npy":
        np.save(path, voxels)
    elif path.suffix == ".npz":
        np.savez_compressed(path, phase=voxels)
    elif path.suffix == ".raw":
        path.write_bytes(voxels.tobytes(order="F"))
    elif voxels.ndim == 2:
        Image.fromarray(voxels.T[::-1]).save(path)
    else:
        pages = [Image.fromarray(page) for page in voxels.T]
        pages[0].save(path, save_all=True, append_images=pages[1:])
    return path


def seeds(path, dim, *, dx=SIDE, phase=1, origin=None, counts=None, voxel_size=SIDE):
    spec = SimpleNamespace(kind="voxels", file=path.name, voxel_size=voxel_size, phase=phase, origin=origin,
                           counts=counts)
    return seed_body(spec, None, dim=dim, dx=dx, particles_per_cell=2**dim, sampling="regular",
                     rng=np.random.default_rng(1), base_dir=path.parent)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("ending", [".npy", ".npz", ".tif", ".raw"])
@pytest.mark.parametrize("phase", [1, 2])
def test_every_format_fills_the_voxels_of_the_phase(dim, ending, phase, tmp_path):
    voxels = image(dim)
    path = write(voxels, tmp_path / f"sample{ending}")
    origin = (1.0, -2.0, 3.0)[:dim]
    made = seeds(path, dim, phase=phase, origin=origin, counts=voxels.shape)
    at = np.floor((made.positions - origin) / SIDE).astype(int)
    found = np.zeros(voxels.shape, int)
    np.add.at(found, tuple(at.T), 1)
    np.testing.assert_array_equal(found, 2**dim * (voxels == phase))
    assert made.volumes.sum() == pytest.approx((voxels == phase).sum() * SIDE**dim, rel=1e-12)


def test_a_coarse_grid_keeps_the_mass(tmp_path):
    voxels = random_microstructure((64, 64), 0.65, 4.0, seed=2)
    path = write(voxels, tmp_path / "sample.npz")
    for dx in (1.0, 2.0, 3.3):
        assert seeds(path, 2, dx=dx).volumes.sum() == pytest.approx(voxels.sum() * SIDE**2, rel=1e-12)


def test_what_is_wrong_is_named(tmp_path):
    path = write(image(2), tmp_path / "sample.npy")
    raw = write(image(2), tmp_path / "sample.raw")
    text = tmp_path / "sample.txt"
    text.write_text("no image")
    broken = tmp_path / "broken.tif"
    broken.write_text("no image")
    for call, words in ((lambda: seeds(path, 3), "3 axes"), (lambda: seeds(path, 2, phase=7), "no value"),
                        (lambda: seeds(raw, 2), "counts is missing"),
                        (lambda: seeds(raw, 2, counts=(4, 4)), "holds 15"),
                        (lambda: seeds(text, 2), "must end in"), (lambda: seeds(broken, 2), "cannot be read")):
        with pytest.raises(InputError, match=words):
            call()


def test_a_scene_takes_a_voxel_body():
    shape = {"kind": "voxels", "file": "sample.npy", "voxel_size": 1e-5}
    scene = Scene.model_validate({
        "name": "sample", "dimension": 2, "end_time": 1.0, "solver": {"dx": 1e-5},
        "materials": {"ice": {"kind": "elastic", "density": 917.0, "youngs_modulus": 9e9, "poisson_ratio": 0.3}},
        "bodies": [{"name": "ice", "material": "ice", "shape": shape}]})
    assert scene.bodies[0].shape.phase == 1


@pytest.mark.parametrize(("size", "fraction"), [((120, 120), 0.65), ((40, 40, 40), 0.3)])
def test_made_up_ice_has_the_fraction_and_hangs_together(size, fraction):
    voxels = random_microstructure(size, fraction, 3.0, seed=5)
    assert voxels.shape == size and set(np.unique(voxels)) == {0, 1}
    assert voxels.mean() == pytest.approx(fraction, rel=0.05)
    assert ndimage.label(voxels)[1] == 1 and voxels[..., 0].any() and voxels[..., -1].any()
    np.testing.assert_array_equal(voxels, random_microstructure(size, fraction, 3.0, seed=5))
    assert (voxels != random_microstructure(size, fraction, 3.0, seed=6)).any()


def test_specific_surface_of_a_level_cut():
    """Half ice: S / V = (2/π) √(−C''(0)) with C = exp(−r²/(4 s²)), that is (2/π)/(√2 s), Teubner (1991); faces of
    voxels are 3/2 of an isotropic surface."""
    s = 5.0
    voxels = random_microstructure((90, 90, 90), 0.5, s, seed=1).astype(int)
    faces = sum(np.abs(np.diff(voxels, axis=axis)).sum() for axis in range(3))
    assert faces / 1.5 / voxels.size == pytest.approx(2.0 / np.pi / (np.sqrt(2.0) * s), rel=0.06)


def test_ice_that_cannot_hang_together_is_refused():
    with pytest.raises(InputError, match="no connected ice"):
        random_microstructure((60, 60), 0.2, 2.0, seed=2)


def test_command_writes_an_image(tmp_path, capsys):
    main([str(tmp_path / "made.npz"), "--size", "50", "50", "--fraction", "0.7", "--correlation", "3"])
    assert "50 x 50 voxels, ice 0.7" in capsys.readouterr().out
    with np.load(tmp_path / "made.npz") as archive:
        assert archive["phase"].shape == (50, 50)
