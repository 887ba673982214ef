"""Fields of the particles, and every number with a name: history, maps, results."""

from snowmpm.cli.reference.markdown import code, plain, table

INTRODUCTION = """# Fields and numbers

What a run file, its history, its maps and its tables hold, with units and definitions. The unit of what has none is 1.

## Fields of the particles

Frames hold the position and the fields of `output.fields`; `run.frame(i).fields[NAME]`, `snowmpm render --color NAME`.
"""

OF_LAWS = {
    "damage": "share of the bonds or of the cohesion that is lost: 0 intact, 1 none left",
    "crack_opening": "opening of the widest crack of the particle",
    "cracks": "how many cracks the particle has",
    "p0": "isotropic yield pressure",
    "stiffness_factor": "stiffness over that at the start",
    "collisional_pressure": "part of p that collisions carry",
    "collisional_q": "part of q that collisions carry",
}
"""What laws report that is no variable of their state."""


def page():
    """All fields and numbers as Markdown."""
    from snowmpm.materials import LAWS
    from snowmpm.particles.fields import of_laws
    from snowmpm.quantities import table as quantities
    from snowmpm.registry import FIELDS

    states = {one.name: one.description for law in LAWS.values() for one in law.STATE}
    lines = [INTRODUCTION]
    lines += table(("field", "unit", "what it is"),
                   [(code(name), code(field.unit), plain(field.description)) for name, field in FIELDS.items()])
    lines += ["Reported by laws of their own state, 0 for other laws:", ""]
    lines += table(("field", "unit", "what it is", "laws"),
                   [(code(name), code(unit), plain(OF_LAWS.get(name) or states.get(name, "")),
                     ", ".join(code(kind) for kind, law in sorted(LAWS.items()) if name in law.OUTPUTS))
                    for name, unit in of_laws().items()])
    for title, group, where in (
        ("History", quantities.HISTORY, "Rows of `run.history` and `snowmpm plot`, one a written step."),
        ("Maps", quantities.RASTERS, "`snowmpm maps`: GeoTIFF, and `run.to_xarray(\"maps\")`."),
        ("Maps over time", quantities.OVER_TIME, "The same at each frame, where they are written."),
        ("Numbers of an avalanche", quantities.NUMBERS, "`snowmpm maps`, `summary.json`, `compare`, campaigns."),
        ("Powder layer", quantities.POWDER_LAYER, "An experiment: rows of `run.history`, and maps."),
        ("Gauges", (*quantities.GAUGES, *quantities.PASSED), "`snowmpm maps --gauges`; the rasters: `run.passed`."),
        ("Along a path", quantities.PATH, "`snowmpm maps`, along the thalweg or `--path`."),
        ("Loads on obstacles", quantities.IMPACT,
         "`snowmpm info`, `plot` and `report`; loads over time: `run.to_pandas(\"loads\")`."),
        ("Saw tests", quantities.SAW_TEST, "`snowmpm compare`, `summary.json`; `saw_NAME` in campaigns."),
    ):
        lines += [f"## {title}", "", where, ""]
        lines += table(("name", "unit", "what it is"),
                       [(code(one.name), code(one.unit), plain(f"{one.label}: {one.definition}")) for one in group])
    return "\n".join(lines)
