"""`snowmpm element`: a material at a single point, in the tests of a laboratory."""

import os
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli import completion
from snowmpm.cli.options import Backend, Precision, setting_values
from snowmpm.cli.run import start_taichi
from snowmpm.cli.table import print_facts
from snowmpm.draft import write_table, write_text
from snowmpm.errors import InputError, did_you_mean
from snowmpm.stages import stage

MATERIAL = (
    "A material card (`snowmpm list`), kind=KIND with --set for its numbers, FILE.toml, FILE.toml:NAME, or SCENE:NAME"
    " such as slab_release:slab."
)
MOST_STEPS = 1_000_000
FILES = {"table": "table.csv", "plot": "plot.png", "material": "material.toml"}
TestName = Annotated[
    str,
    typer.Argument(
        metavar="TEST",
        help="A test (`snowmpm list` names them), or a path to follow: a .csv file.",
        autocompletion=completion.tests,
    ),
]
MaterialSource = Annotated[
    str, typer.Option("--material", "-m", metavar="MATERIAL", help=MATERIAL, autocompletion=completion.cards)
]
MaterialSettings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Change one number of the material, e.g. --set p0=2e4; repeatable."
    ),
]


def element(
    test: TestName,
    material: MaterialSource,
    settings: MaterialSettings = None,
    strain: Annotated[
        float | None, typer.Option(metavar="X", help="Amount of the prescribed strain; the test's own by default.")
    ] = None,
    pressure: Annotated[float, typer.Option(metavar="PA", help="Isotropic pressure at the start, in Pa.")] = 0.0,
    steps: Annotated[
        int | None,
        typer.Option(
            min=1, max=MOST_STEPS, metavar="N", help="Steps of the test; of a path, from each row to the next."
        ),
    ] = None,
    rate: Annotated[
        float | None, typer.Option(metavar="R", help="Strain rate in 1/s, for rate-dependent laws; 1 by default.")
    ] = None,
    precision: Annotated[Precision, typer.Option(help="Precision of the stress update.")] = Precision.f64,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Output folder; runs/<test>_<material> by default."),
    ] = None,
):
    """Test a material at a single point.

    Writes DIR/table.csv (one row a step, units in the header), DIR/plot.png and DIR/material.toml, in place of an
    earlier test there, and prints yield, peak, end and critical state.

    A path is a table: its first line names columns among strain_xx ... strain_xz (logarithmic stretches, amounts of
    shear), stress_xx ... stress_xz (Cauchy, Pa, tension positive) and duration (s), or F_xx ... F_zz and duration; each
    line below is a target, reached in turn. A component with neither strain nor stress keeps its strain.
    """
    from snowmpm.scenes.material_source import load_material

    name, law = load_material(material, setting_values(settings))
    named = Path(test).stem if Path(test).suffix == ".csv" else test.replace("-", "_")
    folder = output or Path("runs") / f"{named}_{name}"
    if Path(test).suffix == ".csv":
        overwriting.reads(test)
    overwriting.guard_in(folder, FILES.values())
    with stage(f"measuring {test} (compiles the law)"):
        measured = _measure(test, law, strain, pressure, steps, rate, precision.value)
    written = _write(folder, name, law, measured)
    print_facts(_title(measured, name, law), _facts(measured))
    print_facts("written", written)


def _measure(test, law, strain, pressure, steps, rate, precision):
    from snowmpm.materials import EXPERIMENTS, LoadingError, measure, measure_path, read_loading

    path = test if Path(test).suffix == ".csv" else None
    known = test.replace("-", "_")
    if path is None and known not in EXPERIMENTS:
        raise InputError(f"no test {test}: one of {', '.join(EXPERIMENTS)}, or a path in a .csv file"
                         f"{did_you_mean(known, EXPERIMENTS)}")
    if path is not None and (strain is not None or rate is not None):
        raise InputError(f"{path}: strains and times of a path are in its file: no --strain, no --rate")
    try:
        loading = read_loading(path) if path else None
        if loading is not None and len(loading.durations) * (steps or 1) > MOST_STEPS:
            raise InputError(f"{path}: {len(loading.durations)} rows of {steps or 1} steps: {MOST_STEPS} steps at most")
        start_taichi(Backend.cpu, 1)  # one point: more threads would only wait
        if loading is not None:
            return measure_path(law, loading, pressure=pressure, steps=steps or 1, precision=precision)
        return measure(
            law,
            known,
            strain=strain,
            pressure=pressure,
            steps=steps,
            rate=1.0 if rate is None else rate,
            precision=precision,
        )
    except LoadingError as error:
        raise InputError(f"{test}: {error}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _write(folder, name, law, measured):
    """Table, plot and material; their paths by name."""
    from snowmpm.render import render_element
    from snowmpm.scenes.toml import table_text

    _check_folder(folder)
    paths = {kind: folder / name for kind, name in FILES.items()}
    columns = measured.table()
    write_table(paths["table"], [f"{column} [{unit}]" if unit else column for column, (unit, _) in columns.items()],
                zip(*(_cells(values) for _, values in columns.values()), strict=True))
    write_text(paths["material"], table_text({"material": law.model_dump(exclude_none=True)}))
    render_element(_curves(name, law, measured, columns), paths["plot"])
    return {kind: str(path) for kind, path in paths.items()}


def _check_folder(folder):
    there = next(parent for parent in (folder, *folder.resolve().parents) if parent.exists())
    if not there.is_dir() or not os.access(there, os.W_OK):
        raise InputError(f"-o {folder}: {there} must be a folder that can be written to")


def _cells(values):
    """A number to the last digit; empty for nan."""
    return [repr(value) if value == value else "" for value in values.tolist()]


def _curves(name, law, measured, columns):
    from snowmpm.render import ElementCurves

    found = measured.characteristics()
    section = measured.yield_section()
    p, q = measured.cauchy_invariants
    plastic = columns.get("plastic_volumetric_strain")
    described = next(iter(law.OUTPUTS), None) or "dissipation"
    return ElementCurves(
        title=_title(measured, name, law).replace("_", " "),
        strain_label=measured.driven.label,
        strain=measured.driven_strain,
        p=p,
        q=q,
        volumetric=columns["volumetric_strain"][1],
        plastic=None if plastic is None else plastic[1] - plastic[1][0],
        hardening=(described, *columns[described]),
        yield_row=found.yield_row - 1 if found.drops else found.yield_row,
        peak_row=found.peak_row,
        section=None if section is None else (section.name, section.p, section.q, section.initial, section.final),
    )


def _title(measured, name, law):
    return f"{measured.name}: {name}" + (f" ({law.kind})" if name != law.kind else "")


def _facts(measured):
    found = measured.characteristics()
    column, sign = measured.driven.column, measured.driven.sign
    strain = sign * measured.driven_strain

    def state(row):
        return f"step {row}: {column} = {strain[row]:.4g}, {_stresses(measured, row)}"

    facts = {"start": _stresses(measured, 0)}
    if found.drops:
        facts["bears"] = f"{state(found.yield_row - 1)}, before it yields"
        facts["yields and drops"] = f"{state(found.yield_row)}, after it; more --steps follow it closer"
    elif found.yield_row is not None:
        facts["yield"] = state(found.yield_row)
    elif not measured.path.iterations.any():
        facts["yield"] = "none"
    if found.peak_row is not None:
        facts["peak_q"] = state(found.peak_row)
    facts["end"] = state(len(strain) - 1)
    if found.critical:
        facts["critical_state"] = f"q/p = {found.steady_ratio:.5g}"
    elif found.steady_ratio is not None:
        facts["failure"] = f"q/p = {found.steady_ratio:.5g}, while the volume changes"
    elif found.peak_row is not None:
        facts["critical_state"] = "not reached"
    facts["p and q"] = "of the Cauchy stress; p0 is a Kirchhoff stress, J times as large (kirchhoff_p in the table)"
    facts["dissipation"] = f"{measured.path.dissipation[-1]:.4g} J/m3"
    facts["corrections"] = f"{sum(row.corrections for row in measured.rows)} of free strains"
    return facts


def _stresses(measured, row):
    p, q = measured.cauchy_invariants
    round_off = 1e-9 * max(abs(p).max(), q.max())
    p, q = (0.0 if abs(x[row]) < round_off else x[row] for x in (p, q))
    return f"p = {p:.5g} Pa, q = {q:.5g} Pa" + (f", q/p = {q / p:.4g}" if p and q else "")
