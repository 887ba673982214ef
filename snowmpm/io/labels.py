"""Names in a run file in words: `long_name` of tables and data sets."""

from snowmpm.quantities.table import QUANTITIES

LONG_NAMES = {
    "time": "simulated time",
    "position": "position, map coordinates",
    "stress": "Cauchy stress, tension positive",
    "p": "pressure, compression positive", "q": "von Mises stress",
    "J": "volume ratio det F",
    "p0": "preconsolidation pressure",
    "material": "number of the material in the scene",
    "body": "number of the body in the scene",
    "id": "number of the particle, given at seeding",
    "saw": "length of the cut", "tip": "tip of the crack, from the saw's end",
    "arrival": "time at which the weak layer broke by itself",
    "x": "x", "y": "y", "z": "height",
    "s": "distance along the thalweg, in plan",
}
"""Labels of names that are not in the table of quantities and do not explain themselves."""


def long_name(name):
    """In words: "kinetic_energy" is kinetic energy."""
    known = QUANTITIES.get(name)
    return known.label if known else LONG_NAMES.get(name) or name.replace("_", " ")


def attributes(name, unit):
    """`long_name` and, where there is one, `units`, as CF and xarray have them; a pure number has units "1"."""
    return {"long_name": long_name(name), **({"units": unit} if unit else {})}
