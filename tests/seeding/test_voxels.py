"""Bodies from voxel images: what is filled, from every format; and the made-up microstructure."""

import io
import struct
import time
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget
from snowmpm.scenes import Scene
from snowmpm.seeding import seed_body
from snowmpm.setup.random_microstructure import main, random_microstructure
from tests.support.voxel_files import write, write_metaimage

SIDE = 0.5  # m, of a voxel


def image(dim):
    """Voxels that no mirror image and no exchange of axes leaves as they are."""
    voxels = np.zeros((3, 5) if dim == 2 else (2, 3, 4), np.uint8)
    voxels[0, :2] = 1
    voxels[-1, -1] = 1
    voxels[..., 1] |= 2
    return voxels


def seeds(path, dim, *, dx=SIDE, phase=1, origin=None, counts=None, voxel_size=SIDE):
    spec = SimpleNamespace(kind="voxels", file=path.name, voxel_size=voxel_size, phase=phase, origin=origin,
                           counts=counts)
    return seed_body(spec, None, dim=dim, dx=dx, particles_per_cell=2**dim, sampling="regular",
                     rng=np.random.default_rng(1), base_dir=path.parent)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("ending", [".npy", ".npz", ".tif", ".mhd", ".mha", ".raw"])
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


def tiff(width, height, pages=1, circle=False):
    """Bytes of a TIFF that promises pages of bytes and holds none."""
    out = bytearray(b"II*\0" + struct.pack("<I", 8))
    for page in range(pages):
        entries = [(256, 4, width), (257, 4, height), (258, 3, 8), (259, 3, 1), (262, 3, 1), (273, 4, 8), (277, 3, 1),
                   (278, 4, height), (279, 4, 8)]
        after = len(out) + 2 + 12 * len(entries) + 4
        out += struct.pack("<H", len(entries)) + b"".join(struct.pack("<HHII", t, k, 1, v) for t, k, v in entries)
        out += struct.pack("<I", after if page < pages - 1 else 8 if circle else 0)
    return bytes(out)


def npy(shape, content=b"x" * 100, descr="|u1"):
    """Bytes of an array of NumPy's that promises a shape."""
    file = io.BytesIO()
    np.lib.format.write_array_header_1_0(file, {"descr": descr, "fortran_order": False, "shape": shape})
    return file.getvalue() + content


def npz(size):
    """Bytes of an archive whose first array unpacks to `size` bytes of nothing."""
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive, archive.open("a.npy", "w") as member:
        member.write(npy((size,), b""))
        for _ in range(size // 2**20):
            member.write(bytes(2**20))
    return file.getvalue()


def png():
    file = io.BytesIO()
    Image.new("L", (4, 4)).save(file, "PNG")
    return file.getvalue()


HOSTILE = {
    "wide.tif": (lambda: tiff(100_000, 100_000), "cannot be read|of memory"),
    "short.tif": (lambda: tiff(5000, 5000), "cannot be read"),
    "pages.tif": (lambda: tiff(9000, 9000, 50), "cannot be read|of memory"),
    "many.tif": (lambda: tiff(2, 2, 5100), "more than 5000 pages"),
    "png.tif": (png, "cannot be read"),
    "vrt.tif": (lambda: b"<VRTDataset rasterXSize='4' rasterYSize='4'></VRTDataset>", "cannot be read"),
    "eps.tif": (lambda: b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n", "cannot be read"),
    "long.npy": (lambda: npy((10**6, 10**6)), "is too short for the 1000000 x 1000000 uint8 values"),
    "long.npz": (lambda: None, "is too short"),
    "negative.npy": (lambda: npy((3, 3)).replace(b"(3, 3)", b"(3,-3)"), "."),
    "objects.npy": (lambda: npy((1, 1), descr="|O"), "objects"),
    "complex.npy": (lambda: npy((2, 2), bytes(64), "<c16"), "must hold numbers"),
    "text.npy": (lambda: npy((2, 2), bytes(64), "<U4"), "must hold numbers"),
    "bomb.npz": (lambda: npz(2**28), "of memory, and 0.5 GiB are allowed"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_images_are_refused(name, tmp_path, monkeypatch):
    monkeypatch.setenv(read_budget.VARIABLE, "0.5")
    make, words = HOSTILE[name]
    path = tmp_path / name
    if name == "long.npz":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("a.npy", npy((100_000, 100_000)))
    else:
        path.write_bytes(make())
    start = time.process_time()
    with pytest.raises(InputError, match=words) as refused:
        seeds(path, 3 if name in ("pages.tif", "many.tif") else 2)
    assert name in str(refused.value) and time.process_time() - start < 30.0


def test_pages_in_a_circle_end(tmp_path):
    path = tmp_path / "circle.tif"
    path.write_bytes(tiff(2, 2, 3, circle=True))
    assert len(seeds(path, 3, phase=9).volumes) == 24  # one voxel of it on each of three pages, eight particles each


def test_pages_of_one_image_add_up(tmp_path, monkeypatch):
    monkeypatch.setenv(read_budget.VARIABLE, "0.001")
    pages = [Image.new("L", (200, 200)) for _ in range(20)]
    pages[0].save(tmp_path / "sample.tif", save_all=True, append_images=pages[1:])
    with pytest.raises(InputError, match="200 x 200 pixels on 9 pages need"):
        seeds(tmp_path / "sample.tif", 3, phase=0)


def test_pages_of_two_sizes_are_refused(tmp_path):
    Image.new("L", (4, 4)).save(tmp_path / "a.tif", save_all=True, append_images=[Image.new("L", (4, 5))])
    with pytest.raises(InputError, match="page 2 is 4 x 5 pixels, and the first 4 x 4"):
        seeds(tmp_path / "a.tif", 3)


def test_a_header_says_in_which_order_bytes_are(tmp_path):
    voxels = image(3)
    for order in ("<i2", ">i2"):
        made = seeds(write_metaimage(voxels.astype(order), tmp_path / "a.mhd"), 3)
        assert len(made.volumes) == 8 * (voxels == 1).sum()


@pytest.mark.parametrize("key, value, words", [
    ("DimSize", "2 3", "DimSize = 2 3: must be 3 numbers"), ("DimSize", "9 9 -9", "must be 3 numbers"),
    ("DimSize", "2 3 5", "make 30 bytes, and a_voxels.raw holds 24"), ("ElementType", "MET_OTHER", "must be one of"),
    ("CompressedData", "True", "must be False"), ("ElementNumberOfChannels", "3", "must be 1"),
    ("HeaderSize", "-1", "number of bytes"), ("ElementDataFile", "../a_voxels.raw", "beside the header"),
    ("ElementDataFile", "none.raw", "beside the header"), ("ElementDataFile", "", "beside the header"),
])
def test_a_header_with_a_bad_key_is_refused(key, value, words, tmp_path):
    with pytest.raises(InputError, match=words):
        seeds(write_metaimage(image(3), tmp_path / "a.mhd", **{key: value}), 3)


def test_a_header_that_is_none_is_refused(tmp_path):
    for content in (b"", b"no header", b"NDims = 3\n" * 9, b"x" * 10**6):
        (tmp_path / "a.mhd").write_bytes(content)
        with pytest.raises(InputError, match="no MetaImage"):
            seeds(tmp_path / "a.mhd", 3)


def test_a_header_of_terabytes_is_not_read(tmp_path):
    write_metaimage(image(3), tmp_path / "a.mhd", DimSize="10000 10000 10000")
    with open(tmp_path / "a_voxels.raw", "wb") as file:
        file.truncate(10**12 + 3)
    with pytest.raises(InputError, match="of memory, and"):
        seeds(tmp_path / "a.mhd", 3)


def test_a_raw_image_of_terabytes_is_not_read(tmp_path):
    path = tmp_path / "sample.raw"
    with open(path, "wb") as file:
        file.truncate(10**12)
    with pytest.raises(InputError, match="of memory, and"):
        seeds(path, 2, counts=(10**6, 10**6))
    with pytest.raises(InputError, match="makes 100 voxels, and the file holds 1000000000000"):
        seeds(path, 2, counts=(10, 10))


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
