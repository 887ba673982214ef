"""`snowmpm export`: a run for other programs."""

import sys
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Quiet, RunPath


class Kind(str, Enum):
    """Of files."""

    usd = "usd"
    ply = "ply"
    gltf = "gltf"


As = Annotated[Kind, typer.Option("--as", help="usd: one file for all times (extra `export`); ply: a file a frame, with"
                                               " all fields; gltf: a .glb file a frame.")]
Folder = Annotated[Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder; RUN/export by default.")]
Fields = Annotated[str | None, typer.Option(metavar="A,B", help="Fields of the snow; all that the run holds by"
                                                                " default.")]


def export(run: RunPath, output: Folder = None, kind: As = Kind.ply,
           surface: Annotated[bool, typer.Option("--surface", help="The surface of the snow as a mesh, instead of its"
                                                                   " particles (extra `export`).")] = False,
           fields: Fields = None,
           every: Annotated[int, typer.Option(metavar="N", help="Every n-th frame only.")] = 1,
           speed: Annotated[float, typer.Option(metavar="X", help="Simulated seconds in a second of film.")] = 1.0,
           fps: Annotated[float, typer.Option(metavar="N", help="Pictures in a second of film.")] = 25.0,
           quiet: Quiet = False):
    """Write a run for Blender, Houdini and other programs.

    Snow as particles, or as the mesh of its surface, with velocities and all fields; ground and obstacles. Lengths are
    metres from the run's origin, which the files name.
    """
    from snowmpm.io import Run
    from snowmpm.render.export import export_run

    opened = Run(run)
    folder = output or opened.path.with_name("export")
    written = (one.name for one in folder.glob("*")
               if one.suffix in (".ply", ".glb", ".usdc") or one.name == "sequence.json")
    overwriting.guard_in(folder, written)
    names = [name.strip() for name in fields.split(",") if name.strip()] if fields is not None else None
    written = export_run(opened, folder, kind.value, surface=surface, fields=names, every=every, speed=speed, fps=fps)
    if not surface and "id" not in opened.field_names:
        held = kind.value == "usd"
        what = "USD holds each frame until the next" if held else "their order changes from frame to frame"
        print(f'note: the run did not record "id" (output.fields), so that nothing tells particles apart: {what}',
              file=sys.stderr)
    if not quiet:
        print(written[0] if len(written) == 1 else f"{folder}: {len(written)} files, {written[0].name} first")
