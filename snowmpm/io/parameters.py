"""Main parameters of a run in short form: for the margin of a map, the head of a report, the fields of a file."""

from snowmpm.errors import InputError
from snowmpm.methods import METHODS
from snowmpm.quantities.quantity import digits
from snowmpm.reading.toml_text import TOMLDecodeError, tables


def parameters(run):
    """Label -> text of the parameters shown with the maps of a `Run`: method, cells, particles, friction, snow."""
    made, scene = run.provenance, _scene(run)
    method = METHODS.get(_at(scene, "solver", "method"))
    found = {"scene": run.name, "method": succession(run) or (method.title if method else "")}
    if isinstance(made.get("dx"), int | float):
        found["grid spacing"] = f"{made['dx']:g} m"
    if len(run):
        found[pieces(run)] = digits(float(run.n_points(0)))
    if run.maps:
        found["map cell"] = f"{digits(next(iter(run.maps.values())).cell)} m"
    friction = _at(scene, "terrain", "friction")
    if friction is not None:
        found["bed friction"] = f"{friction:g}" if isinstance(friction, int | float) else _law(friction)
    snow = [_snow(name, law, method) for name, law in (_at(scene, "materials") or {}).items() if isinstance(law, dict)]
    found["snow"] = ", ".join(dict.fromkeys(snow))
    found["water"] = _water(_at(scene, "water"))
    told = made.get("components")
    found |= {name: text for name, text in told.items() if isinstance(text, str)} if isinstance(told, dict) else {}
    found["version"] = f"snowmpm {made.get('version', '')}".strip()
    return {name: text for name, text in found.items() if text}


def pieces(run):
    """What the particles of a `Run` are called."""
    method = METHODS.get(_at(_scene(run), "solver", "method"))
    if method and method.capabilities.plan and _at(_scene(run), "solver", "depth", "scheme") == "volumes":
        return "cells"
    return method.particles if method else "particles"


def friction_of(run):
    """In words: the calibration of the ground's friction of a `Run`: that of a card, or of nobody."""
    friction = _at(_scene(run), "terrain", "friction")
    if not isinstance(friction, dict):
        return "friction of own numbers, not calibrated"
    chosen = run.summary.get("friction_class") or friction.get("card")
    if chosen and run.summary.get("friction_doubts"):
        return f"friction of the card {chosen}, outside the range of its calibration"
    if chosen:
        return f"friction as calibrated for the card {chosen}"
    begun = f", from {friction['began_with']}" if friction.get("began_with") else ""
    return f"friction of own numbers{begun}, not calibrated"


def method_of(run, last=False):
    """The row of `METHODS` that computed a `Run`, of several the first or the last; None where the run does not say."""
    if last and methods_of(run):
        return METHODS.get(methods_of(run)[-1]["method"])
    return METHODS.get(_at(_scene(run), "solver", "method"))


def at_rest(run):
    """Whether each frame of a `Run` is a balance, on the way to which the work of the loads is lost."""
    return _at(_scene(run), "solver", "implicit", "time") == "quasi_static"


def _scene(run):
    """Tables of the resolved scene; none where the run has none that can be read."""
    try:
        return tables(run.provenance.get("scene") or "", "scene")
    except (TOMLDecodeError, InputError, TypeError):
        return {}


def methods_of(run):
    """Records of the methods that computed a `Run` one after the other (`snowmpm.running.relay`); [] of one that had
    one method all the way."""
    return run.provenance.get("methods") or []


def succession(run):
    """In words: which method took over from which, and when; "" for one method all the way."""
    records = methods_of(run)
    names = [METHODS[row["method"]].title if row["method"] in METHODS else row["method"] for row in records]
    return ", ".join([*names[:1], *(f"{name} from t = {row['time']:.4g} s on (cells of {row['dx']:g} m)"
                                    for name, row in zip(names[1:], records[1:], strict=True))])


def _snow(name, law, method):
    """A material in a word: its density, if the method reads nothing else of it."""
    if method and method.capabilities.plan and isinstance(law.get("density"), int | float):
        return f"{law['density']:g} kg/m³"
    return str(law.get("card") or _begun(law) or law.get("kind") or name)


def _begun(law):
    """In words: numbers that began with those of a card."""
    return f"own numbers, from {law['began_with']}" if law.get("began_with") else ""


def _water(table):
    """Water in the pores: how high it stands in a flow, and its excess pressure at the start."""
    if not isinstance(table, dict):
        return ""
    if not isinstance(table.get("level"), int | float):
        return "in the pores"
    return f"to {table['level']:g} of the depth, excess pressure {table.get('excess', 0.0):g}"


def _law(friction):
    """Friction of the ground by a law: its numbers, and the card that they began with."""
    if not isinstance(friction, dict):
        return "by a law"
    numbers = ", ".join(f"{name} = {value:g}" for name, value in friction.items()
                        if isinstance(value, int | float) and value)
    known = friction.get("card") or _begun(friction)
    card = f"{known}: " if known else ""
    return f"{card}{friction.get('law', 'by a law')} {numbers}".strip()


def _at(table, *keys):
    for key in keys:
        table = table.get(key) if isinstance(table, dict) else None
    return table
