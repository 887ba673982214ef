"""The short form of a campaign: a grid of values of some keys of a scene."""

from pathlib import Path

from snowmpm.campaigns.spec import RESERVED, CampaignFile
from snowmpm.errors import InputError
from snowmpm.quantities.table import QUANTITIES
from snowmpm.reading.toml_text import TOMLDecodeError, tables


def sweep_file(scene, settings, changes=None):
    """`CampaignFile` of a grid. settings: texts KEY=a,b,c; changes: of the scene in all runs. Raises InputError."""
    values = dict(_key_and_values(setting) for setting in settings)
    if len(values) < len(settings):
        raise InputError("KEY=a,b,c: the same key twice; give all its values at once")
    path = Path(scene)
    in_file = path.suffix == ".toml"
    names = _names(values)
    data = {"name": f"sweep_{path.stem}", "scene": path.name if in_file else str(scene), "design": "grid",
            "set": changes or {}, "parameters": {
                names[key]: {"key": key, "distribution": "choices", "values": list(given)}
                for key, given in values.items()}}
    return CampaignFile.checked(data, "sweep", path.resolve().parent if in_file else Path.cwd())


def _key_and_values(setting):
    key, equals, text = setting.partition("=")
    if not equals or not key.strip() or not text.strip():
        raise InputError(f"{setting}: must be KEY=a,b,c, such as terrain.friction.mu=0.2,0.3")
    try:
        found = tables(f"values = [{text}]", f"{key} = {text}")["values"]
    except TOMLDecodeError:  # words without quotes
        found = [part.strip() for part in text.split(",")]
    if len({float(value) if type(value) in (int, float) else repr(value) for value in found}) < len(found):
        raise InputError(f"{setting}: the same value twice")
    return key.strip(), found


def _names(values):
    """Short names of keys: their last part, or all of it where that is taken."""
    last = [key.rpartition(".")[2] for key in values]
    taken = {name for name in last if last.count(name) > 1 or name in RESERVED or name in QUANTITIES}
    return {key: key if name in taken or name.isdigit() else name for key, name in zip(values, last, strict=True)}
