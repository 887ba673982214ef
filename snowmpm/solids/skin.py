"""Colours and textures of a mesh file, for pictures: OBJ with its materials and their pictures, PLY, binary glTF.

They are no part of the mechanics: a material or picture that is missing or cannot be read is left out with a warning.
"""

import io
import logging
import warnings
from pathlib import Path, PurePosixPath

import numpy as np

from snowmpm.errors import InputError
from snowmpm.reading.named_files import existing
from snowmpm.reading.skin import Skin
from snowmpm.terrain.mesh import converted, glb_header, prepared_obj

WIDEST = 2048
"""Longer side [px] of a picture that is kept; larger ones are made smaller."""

MOST_PIXELS = 64_000_000
"""Of the pictures of a mesh together, each as often as a material has it."""

MOST_BYTES = 200_000_000
"""Of a file of materials, or of a picture."""

MOST_PARTS = 64
"""Materials of a mesh that are kept."""

FORMATS = ("PNG", "JPEG", "BMP", "TGA")


def skins_of(path):
    """[`Skin`] of a mesh file, one for each of its materials; none where it has no colours."""
    import trimesh

    path = Path(path)
    suffix = path.suffix.lower()
    logging.getLogger("trimesh").setLevel(logging.CRITICAL)
    folder = _Folder(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            data = prepared_obj(path.read_bytes()) if suffix == ".obj" else path.read_bytes()
            if suffix == ".glb":
                _check_pictures(data)
            meshes = trimesh.load_scene(io.BytesIO(data), file_type=suffix[1:], process=False,
                                        resolver=folder).dump()
    except _Unwanted as reason:
        warnings.warn(f"{path}: {reason}: drawn without colours", stacklevel=2)
        return []
    except Exception:  # a parser may fail in any way; the shape itself was read before
        warnings.warn(f"{path}: its colours cannot be read: drawn without them", stacklevel=2)
        return []
    for name, why in folder.missing.items():
        warnings.warn(f"{path}: {name} {why}: drawn without it", stacklevel=2)
    if any(name.lower().endswith(".mtl") for name in folder.missing):
        return []
    found = [skin for mesh in meshes if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)
             and (skin := _skin(mesh, path, suffix))]
    if len(found) > MOST_PARTS:
        warnings.warn(f"{path}: has {len(found)} materials, at most {MOST_PARTS} are kept: drawn without colours",
                      stacklevel=2)
        return []
    return found


def _skin(mesh, path, suffix):
    """`Skin` of a `trimesh.Trimesh`, None where it has no colour."""
    from trimesh.visual.material import PBRMaterial

    kind = mesh.visual.kind
    vertices, facets = converted(np.asarray(mesh.vertices, float), path, suffix), np.asarray(mesh.faces, np.int32)
    if kind in ("vertex", "face"):
        # Each triangle on a pixel of its own: the mean of its corners
        colours = np.asarray(mesh.visual.face_colors if kind == "face" else
                             np.asarray(mesh.visual.vertex_colors)[facets].mean(axis=1))[:, :3]
        side = int(np.ceil(np.sqrt(len(facets))))
        if side > WIDEST:
            warnings.warn(f"{path}: has too many triangles for their colours: drawn without them", stacklevel=3)
            return None
        picture = np.zeros((side * side, 3), np.uint8)
        picture[: len(facets)] = np.round(colours)
        row, column = np.divmod(np.arange(len(facets)), side)
        st = np.repeat((np.column_stack([column, side - 1 - row]) + 0.5) / side, 3, axis=0)
        return Skin(vertices[facets.ravel()], np.arange(facets.size, dtype=np.int32).reshape(-1, 3), st,
                    picture.reshape(side, side, 3))
    if kind != "texture":
        return None
    material, st = mesh.visual.material, mesh.visual.uv
    image = material.baseColorTexture if isinstance(material, PBRMaterial) else material.image
    if image is None or st is None:
        colour = np.asarray(material.main_color)[:3].astype(np.uint8)
        return Skin(vertices, facets, np.zeros((len(vertices), 2)), colour.reshape(1, 1, 3))
    picture = _pixels(image)
    if picture is None or not np.isfinite(st).all():
        warnings.warn(f"{path}: a picture of it is too large or its places are no numbers: drawn without it",
                      stacklevel=3)
        return None
    return Skin(vertices, facets, np.asarray(st, float)[:, :2], picture)


def _pixels(image):
    """(rows, columns, 3) uint8 of a picture, at most WIDEST; None where it is too large."""
    if image.width * image.height > MOST_PIXELS:
        return None
    image = image.convert("RGB")
    image.thumbnail((WIDEST, WIDEST))
    return np.asarray(image)


class _Unwanted(Exception):
    """Pictures that are not read."""


def _check_pictures(data):
    """Raises _Unwanted for pictures in a binary glTF file that are too large together, or of other FORMATS."""
    from PIL import Image

    header = glb_header(data)
    if len(header.get("materials", [])) > MOST_PARTS or len(header.get("images", [])) > MOST_PARTS:
        raise _Unwanted(f"has more than {MOST_PARTS} materials or pictures")
    start = 28 + int.from_bytes(data[12:16], "little")
    sizes = []
    for one in header.get("images", []):
        if "bufferView" not in one:
            raise _Unwanted("has a picture that is not among its binary data")
        view = header["bufferViews"][one["bufferView"]]
        first = start + int(view.get("byteOffset", 0))
        try:
            with Image.open(io.BytesIO(data[first : first + int(view["byteLength"])]), formats=FORMATS) as image:
                sizes.append(image.width * image.height)
        except Exception:
            raise _Unwanted(f"has a picture that is none ({', '.join(FORMATS)})") from None
    # Each material may unpack its picture for itself
    pixels = sum(sizes) + max(sizes, default=0) * max(0, len(header.get("materials", [])) - len(sizes))
    if pixels > MOST_PIXELS:
        raise _Unwanted(f"has pictures of {pixels / 1e6:.0f} million pixels, at most {MOST_PIXELS / 1e6:.0f} are read")


class _Folder:
    """Materials and pictures beside a mesh file or below its folder, and no other files: what `trimesh` asks for."""

    def __init__(self, path):
        self._folder, self.missing, self._pixels = path.parent.resolve(), {}, 0

    def __getitem__(self, name):
        return self.get(name)

    def get(self, name):
        """Bytes of a file; KeyError where it is not to be had, with the reason in `missing`."""
        name = str(name).strip()
        try:
            return self._read(name)
        except (OSError, ValueError, RuntimeError):  # a link in circles, a name that no file can have
            raise self._no(name[:100], "cannot be read") from None

    def _read(self, name):
        from PIL import Image

        place = PurePosixPath(name.replace("\\", "/"))
        path = self._folder / place
        if place.is_absolute() or ":" in name or not path.resolve().is_relative_to(self._folder):
            raise self._no(name, "lies outside its folder")
        try:
            path = existing(path, self._folder, "file")
            size = path.stat().st_size
        except InputError:
            raise self._no(name, "is not there") from None
        if size > MOST_BYTES:
            raise self._no(name, f"has {size / 1e6:.0f} MB, at most {MOST_BYTES / 1e6:.0f} are read")
        data = path.read_bytes()
        if path.suffix.lower() != ".mtl":
            try:
                with Image.open(io.BytesIO(data), formats=FORMATS) as image:
                    self._pixels += image.width * image.height
            except Exception:
                raise self._no(name, f"is no picture ({', '.join(FORMATS)})") from None
            if self._pixels > MOST_PIXELS:
                raise self._no(name, f"makes {self._pixels / 1e6:.0f} million pixels with those before it, at most"
                                     f" {MOST_PIXELS / 1e6:.0f} are read")
        return data

    def _no(self, name, why):
        self.missing[name] = why
        return KeyError(name)
