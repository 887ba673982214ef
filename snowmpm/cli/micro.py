"""`snowmpm micro`: numbers of a sample of snow from its voxel image."""

import json
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Backend, BackendOption, Json, Quiet, Threads
from snowmpm.cli.table import print_facts, print_json
from snowmpm.draft import write_text
from snowmpm.errors import InputError

SampleFile = Annotated[Path, typer.Argument(metavar="SAMPLE", help="Voxel image: .npy, .npz, .tif (pages are levels of"
                                                                   " z), .mhd or .mha (raw with a header) or .raw"
                                                                   " (bytes, with --counts).")]
VoxelSize = Annotated[float, typer.Option("--voxel-size", metavar="M", help="Side of a voxel, in metres.")]


def micro(sample: SampleFile, voxel_size: VoxelSize,
          phase: Annotated[int, typer.Option(metavar="N", help="Value of ice in the image.")] = 1,
          counts: Annotated[str | None, typer.Option(metavar="NX,NY,NZ", help="Voxels of a .raw file.")] = None,
          axes: Annotated[str, typer.Option(metavar="AXES", help="Axes of the flow: xyz, or some of them.")] = "xyz",
          walls: Annotated[bool, typer.Option("--walls", help="No-slip walls at the sides along the flow; all sides are"
                                                              " periodic by default.")] = False,
          stiffness: Annotated[bool, typer.Option("--stiffness", help="The elastic tensor of the ice too, which takes"
                                                                      " minutes.")] = False,
          output: Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR",
                                                      help="Folder; runs/micro_SAMPLE by default.")] = None,
          backend: BackendOption = Backend.auto, threads: Threads = None, as_json: Json = False,
          quiet: Quiet = False):
    """Porosity, surface, permeability and stiffness of a sample of snow from its voxel image.

    The permeability is that of slow flow through the pores that lead from side to side (lattice Boltzmann, two
    relaxation times). It comes with the fit of Calonne et al. (2012) for snow of the same density and grain size.
    Writes micro.json, with units and sources, and a picture of the flow.
    """
    from snowmpm import __version__
    from snowmpm.cli.run import start_taichi
    from snowmpm.micro.elasticity import ICE_SOURCE
    from snowmpm.micro.permeability import CALONNE
    from snowmpm.micro.sample import Sample
    from snowmpm.micro.study import UNITS, anisotropy_remark, examine
    from snowmpm.render.flow_plot import render_flow

    chosen = _axes(axes)
    folder = output or Path("runs") / f"micro_{sample.stem}"
    overwriting.reads(sample)
    overwriting.guard_in(folder, ("micro.json", "flow.png"))
    one = Sample.read(sample, voxel_size, phase, _counts(counts))
    start_taichi(backend, threads)
    record, found = examine(one, chosen, walls, stiffness=stiffness)
    remark = anisotropy_remark(record)
    folder.mkdir(parents=True, exist_ok=True)
    program = f"snowmpm {__version__}"
    about = {"sample": str(sample), "program": program, "voxel_size": voxel_size}
    notes = {"remarks": [remark] if remark else [], "units": {"voxel_size": "m", **UNITS},
             "sources": {"permeability_calonne": CALONNE, **({"stiffness": ICE_SOURCE} if stiffness else {})}}
    write_text(folder / "micro.json", json.dumps({**about, **record, **notes}, indent=1, default=str))
    picture = render_flow(one.ice, found.speeds, voxel_size, folder / "flow.png", one.name,
                          f"{_in_short(record, chosen)}. {program}")
    if as_json:
        print_json(record)
    elif not quiet:
        print_facts(one.name, _told(record, chosen))
        if remark:
            print(f"  remark: {remark}")
        print(picture)


def _axes(text):
    if not text or set(text) - set("xyz") or len(set(text)) != len(text):
        raise InputError.at("--axes", text, "must be some of x, y and z")
    return tuple(sorted("xyz".index(name) for name in text))


def _counts(text):
    if text is None:
        return None
    parts = text.split(",")
    if len(parts) != 3 or not all(part.strip().isdigit() and int(part) > 0 for part in parts):
        raise InputError.at("--counts", text, "must be three numbers > 0, such as 400,400,300")
    return tuple(int(part) for part in parts)


def _in_short(record, axes):
    """One line for the picture."""
    from snowmpm.micro.permeability import CALONNE

    along = ", ".join(f"k_{'xyz'[a]} = {record['permeability'][a][a]:.3g} m²" for a in axes)
    return (f"density {record['density']:.0f} kg/m³, equivalent radius {1e3 * record['equivalent_radius']:.3g} mm;"
            f" {along}; fit: {record['permeability_calonne']:.3g} m², samples scatter by a factor of"
            f" {record['permeability_calonne_scatter']:g} ({CALONNE})")


def _told(record, axes):
    """The record as facts with units."""
    from snowmpm.micro.permeability import CALONNE

    names = "xyz"
    facts = {"voxels": " x ".join(map(str, record["voxels"])),
             "density": f"{record['density']:.4g} kg/m³", "porosity": f"{record['porosity']:.4g}",
             "connected porosity": {names[a]: f"{record['connected_porosity'][a]:.4g}" for a in axes},
             "specific surface": f"{record['surface_per_mass']:.4g} m²/kg of ice;"
                                 f" {record['surface_per_volume']:.4g} m²/m³ of snow",
             "equivalent sphere radius": f"{1e3 * record['equivalent_radius']:.4g} mm",
             "permeability": {names[b]: "  ".join(f"{row[b]:.3e}" for row in record["permeability"]) + " m²"
                              for b in axes},
             "mean of the diagonal": f"{record['permeability_mean']:.3e} m²",
             "fit for snow": f"{record['permeability_calonne']:.3e} m² ({CALONNE}), whose samples scatter by a"
                             f" factor of {record['permeability_calonne_scatter']:g}; this one has"
                             f" {record['permeability_over_calonne']:.3g} times that",
             "tortuosity": {names[a]: f"{record['tortuosity'][a]:.4g}" for a in axes}}
    if "asymmetry" in record:
        facts["asymmetry of the tensor"] = f"{100.0 * record['asymmetry']:.2g} %"
    if "stiffness" in record:
        facts["confined moduli"] = {names[a]: f"{1e-6 * record['confined_modulus'][a]:.4g} MPa" for a in range(3)}
        facts["nearest isotropic"] = (f"E = {1e-6 * record['youngs_modulus']:.4g} MPa, Poisson's ratio"
                                      f" {record['poisson_ratio']:.3g}")
    return facts
