"""`snowmpm grains`: a material card from tests of a cell of bonded grains."""

import json
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Backend, Json, Quiet
from snowmpm.cli.table import print_facts, print_json
from snowmpm.draft import write_table, write_text
from snowmpm.errors import InputError

MOST_GRAINS = 20_000


class FittedKind(str, Enum):
    """Laws that can be fitted."""

    anticrack_cam_clay = "anticrack_cam_clay"
    cohesive_cam_clay = "cohesive_cam_clay"


def grains(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the card.")] = "grains",
    count: Annotated[int, typer.Option(min=20, max=MOST_GRAINS, metavar="N", help="Number of grains.")] = 200,
    radius: Annotated[float, typer.Option(metavar="M", help="Mean radius of the grains, in m.")] = 5e-4,
    density: Annotated[float, typer.Option(metavar="KG/M3", help="Density of the snow.")] = 110.0,
    solid: Annotated[float, typer.Option(metavar="X", help="Share of the volume that the grains take.")] = 0.38,
    modulus: Annotated[
        float, typer.Option(metavar="PA", help="Stiffness of a contact over the diameter of a grain.")
    ] = 8e6,
    strength: Annotated[float, typer.Option(metavar="PA", help="Strength of a bond, in tension and shear.")] = 2.72e4,
    friction: Annotated[float, typer.Option(metavar="X", help="Friction between grains.")] = 0.2,
    rolling: Annotated[float, typer.Option(metavar="X", help="Rolling resistance between grains.")] = 0.0,
    closing: Annotated[float, typer.Option(metavar="X", help="Largest compaction of the oedometer.")] = 0.2,
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Of the random places of the grains.")] = 2,
    law: Annotated[FittedKind, typer.Option(help="Law whose numbers are wanted.")] = FittedKind.anticrack_cam_clay,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; runs/grains_NAME by default.")
    ] = None,
    quiet: Quiet = False,
    as_json: Json = False,
):
    """Material card of a sample of bonded grains.

    Makes a periodic cell of bonded spheres, tests it (oedometer with an unloading, closing with shear, shear at
    constant volume, opening, compression on all sides, triaxial), and fits a law to all tests by least squares.

    Writes DIR/NAME.toml, a card that a scene takes by `card = "NAME.toml"`, DIR/grains.json (numbers, intervals,
    errors), DIR/curves.csv and DIR/curves.png.
    """
    from snowmpm.cli.run import start_taichi
    from snowmpm.micro.grains.bonded import bonded_cell
    from snowmpm.micro.grains.card import card_of
    from snowmpm.micro.grains.contact import ContactLaw
    from snowmpm.micro.grains.curves import driven_tests
    from snowmpm.micro.grains.fitting import fitted_law
    from snowmpm.scenes.toml import table_text
    from snowmpm.stages import stage

    _check(name, radius=(radius, 0.0, 1.0), density=(density, 0.0, 917.0), solid=(solid, 0.1, 0.6),
           modulus=(modulus, 0.0, 1e12), strength=(strength, 0.0, 1e12), friction=(friction, 0.0, 10.0),
           rolling=(rolling, 0.0, 10.0), closing=(closing, 0.0, 0.5))
    folder = output or Path("runs") / f"grains_{name}"
    overwriting.guard_in(folder, (f"{name}.toml", "grains.json", "curves.csv", "curves.png"))
    stiffness = modulus * 2.0 * radius
    contact = ContactLaw(stiffness, 0.5 * stiffness, friction=friction, rolling=rolling, strength=strength,
                         shear_strength=strength)
    start_taichi(Backend.cpu, 1)  # a cell is too small for more threads
    with stage(f"making {count} grains"):
        sample = bonded_cell(count, radius, contact, solid, seed, density=density / solid)
    if sample.bonds < 1.2 * count:
        raise InputError(f"--solid {solid:g}: {sample.bonds} bonds of {count} grains hold nothing together: must be"
                         " larger")
    with stage("testing them"):
        curves = driven_tests(sample, closing)
    with stage(f"fitting {law.value}"):
        fitted = fitted_law(curves, law.value, density)
    made = {"grains": count, "radius [m]": radius, "solid fraction": solid, "modulus [Pa]": modulus,
            "strength [Pa]": strength, "friction": friction, "rolling": rolling, "seed": seed}
    record = {"grains": made, "bonds": sample.bonds, "law": fitted.law.model_dump(exclude_none=True),
              "intervals": fitted.intervals, "errors": fitted.errors, "largest_stress_over_grains": fitted.peaks}
    card = write_text(folder / f"{name}.toml", table_text(card_of(fitted, curves, sample, made)))
    write_text(folder / "grains.json", json.dumps(record, indent=1))
    picture = _curves(curves, fitted, folder, name)
    if as_json:
        print_json(record)
    elif not quiet:
        print_facts(f"{name}: {law.value}", _told(fitted))
        print(card)
        print(picture)


def _check(name, **values):
    """Refuse numbers that are not inside their limits, and a name that is no file's."""
    if not name or not name.replace("_", "").replace("-", "").isalnum():
        raise InputError.at("NAME", name, "must consist of letters, digits, - and _")
    for option, (value, low, high) in values.items():
        least = 0.0 if option in ("friction", "rolling") else None
        if not (low < value <= high or value == least):
            raise InputError.at(f"--{option}", value, f"must be above {low:g} and at most {high:g}" if least is None
                                else f"must be between {low:g} and {high:g}")


def _curves(curves, fitted, folder, name):
    """Table and picture of the tests; -> path of the picture."""
    import numpy as np

    from snowmpm.micro.grains.fitting import predictions
    from snowmpm.render.grains_plot import GrainsCurve, render_grains

    shown, rows = [], []
    parts = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xz": (0, 2)}
    for curve, stress in zip(curves, predictions(fitted.law, curves), strict=True):
        F = curve.deformation
        strain = np.linalg.norm(F - np.eye(3), axis=(1, 2))
        drawn = {"compression zz": (-1.0, (2, 2)), "compression xx": (-1.0, (0, 0)), "shear xz": (1.0, (0, 2))}
        shown.append(GrainsCurve(f"{curve.name} ({100.0 * fitted.errors[curve.name]:.0f} %)", strain,
                                 *({key: sign * of[:, i, j] for key, (sign, (i, j)) in drawn.items()}
                                   for of in (curve.stress, stress))))
        rows += [[curve.name, *(F[k][part] for part in ((0, 0), (1, 1), (2, 2), (0, 2))),
                  *(curve.stress[k][part] for part in parts.values()), *(stress[k][part] for part in parts.values()),
                  curve.bonds[k]] for k in range(len(F))]
    names = ["test", "F_xx", "F_yy", "F_zz", "F_xz", *(f"stress_{part} [Pa]" for part in parts),
             *(f"law_{part} [Pa]" for part in parts), "bonds"]
    write_table(folder / "curves.csv", names, ([row[0], *(f"{float(value):.7g}" for value in row[1:])] for row in rows))
    return render_grains(shown, folder / "curves.png", f"{name}: grains and {fitted.law.kind}; difference over the"
                                                       " largest stress")


def _told(fitted):
    units = {"youngs_modulus": " Pa", "p0": " Pa"}
    facts = {key: f"{fitted.law[key]:.4g}{units.get(key, '')} ({low:.4g} to {high:.4g})"
             for key, (low, high) in fitted.intervals.items()}
    facts["difference over the largest stress"] = {key: f"{100.0 * error:.1f} %"
                                                   for key, error in fitted.errors.items()}
    return facts
