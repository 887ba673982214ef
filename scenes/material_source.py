"""One material by itself, for a test at a single point: from a file, from a scene, or from numbers alone."""

from pathlib import Path

from pydantic import RootModel, ValidationError
from pydantic_core import PydanticCustomError

from snowmpm.errors import InputError, did_you_mean
from snowmpm.materials import LAWS, Material
from snowmpm.scenes.cards import cards_near, expanded_material, material_cards
from snowmpm.scenes.library import library
from snowmpm.scenes.loader import find_scene, override
from snowmpm.scenes.messages import describe, shown
from snowmpm.scenes.space import surroundings
from snowmpm.scenes.toml import parse


class Named(RootModel[dict[str, Material]]):
    """Materials by name."""


def load_material(source, overrides=None):
    """(name, law) of a material.

    source: a material card; "kind=KIND" (its numbers then come from `overrides`); "FILE.toml", with a table [material]
    or one material under [materials]; "FILE.toml:NAME" or "SCENE:NAME", a material of a scene.
    overrides: key of the material -> value. Raises InputError, which names file, key, value and what is allowed.
    """
    if source.startswith("kind="):
        name = source.removeprefix("kind=")
        if name not in LAWS:
            kinds = ", ".join(shown(kind) for kind in sorted(LAWS))
            raise InputError(f"--material {source}: must be one of {kinds}{did_you_mean(name, LAWS)}")
        file, data = f"--material {source}", {"kind": name}
    elif source in material_cards():
        file, name, data = f"--material {source}", source, {"card": source}
    else:
        file, name, data = _from_file(source)
    data = dict(data)
    for key, value in (overrides or {}).items():
        override(data, key, value, file)
    try:
        with surroundings(base_dir=Path(file).resolve().parent if isinstance(file, Path) else None):
            data = expanded_material(name, data)
        return name, Named.model_validate({name: data}).root[name]
    except PydanticCustomError as error:
        raise InputError(f"{file}: {name}.card = {shown(data['card'])}: {error.context['allowed']}") from None
    except ValidationError as error:
        raise InputError(describe(error, {name: data}, Named, file)) from None


def _from_file(source):
    """File, name of the material, and its table."""
    place, colon, name = source.rpartition(":")
    if not colon or name.endswith(".toml"):
        place, name = source, None
    if not place.endswith(".toml") and place not in library():
        near = cards_near(source)
        forms = "a material card, kind=KIND, FILE.toml, FILE.toml:NAME or SCENE:NAME, such as slab_release:slab"
        hint = f"; did you mean {near}?" if near else ""
        raise InputError(f"--material {source}: must be {forms}{hint}")
    path = find_scene(place)
    tables = parse(path)
    materials = tables.get("materials", {})
    if name is None and "material" in tables:
        name, materials = Path(path).stem, {Path(path).stem: tables["material"]}
    if not isinstance(materials, dict) or not materials:
        raise InputError(f"{path}: has no table [material], and no [materials.NAME]")
    if name is None:
        name = next(iter(materials))
        if len(materials) > 1:
            raise InputError(f"{path}: which material? add :NAME, one of {', '.join(materials)}")
    if name not in materials:
        known = ", ".join(materials)
        raise InputError(f"{path}: no material {shown(name)}: one of {known}{did_you_mean(name, materials)}")
    if not isinstance(materials[name], dict):
        raise InputError(f"{path}: material {name} = {shown(materials[name])}: must be a table")
    return path, name, materials[name]
