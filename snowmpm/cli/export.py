"""`snowmpm export`: a run for other programs."""

import sys
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from snowmpm import overwriting
from snowmpm.cli.options import Quiet, RunPath
from snowmpm.cli.render import Camera, CameraFile, Size, pixels
from snowmpm.errors import InputError

BLENDER = 24.0
"""Pictures a second of a new file of Blender, which does not read the rate of a USD file."""


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
                                                                   " particles.")] = False,
           fields: Fields = None,
           every: Annotated[int, typer.Option(metavar="N", help="Every n-th frame only.")] = 1,
           speed: Annotated[float, typer.Option(metavar="X", help="Simulated seconds in a second of film.")] = 1.0,
           fps: Annotated[float, typer.Option(metavar="N", help="Pictures in a second of film.")] = 25.0,
           camera: Camera = None, camera_path: CameraFile = None, size: Size = "1280x720",
           quiet: Quiet = False):
    """Write a run for Blender, Houdini and other programs.

    Snow as particles, or as the mesh of its surface, with velocities; ground and obstacles; in USD also materials and
    the camera and sun of the film, for which --camera, --camera-path and --size are. Lengths are metres from the run's
    origin, which the files name.
    """
    shape = pixels(size)
    if kind is not Kind.usd and (given := [name for name, value in (
            ("--camera", camera), ("--camera-path", camera_path)) if value is not None]):
        raise InputError(f"{', '.join(given)}: goes with --as usd, which alone holds a camera")
    from snowmpm.io import Run
    from snowmpm.render.export import export_run

    opened = Run(run)
    folder = output or opened.path.with_name("export")
    written = (one.name for one in folder.glob("*")
               if one.suffix in (".ply", ".glb", ".usdc") or one.name in ("sequence.json", "ground.png"))
    overwriting.guard_in(folder, written)
    names = [name.strip() for name in fields.split(",") if name.strip()] if fields is not None else None
    written = export_run(opened, folder, kind.value, surface=surface, fields=names, every=every, speed=speed, fps=fps,
                         camera=camera, camera_path=camera_path, size=shape)
    for note in notes(opened, kind, surface, every, speed, fps):
        print(f"note: {note}", file=sys.stderr)
    if not quiet:
        print(written[0] if len(written) == 1 else f"{folder}: {len(written)} files, {written[0].name} first")


def notes(run, kind, surface, every, speed, fps):
    """What the files lack that a film may need."""
    held = surface or "id" not in run.field_names
    if not surface and held:
        what = "USD holds each frame until the next" if kind is Kind.usd else "their order changes from frame to frame"
        yield f'the run did not record "id" (output.fields), so that nothing tells particles apart: {what}'
    if kind is not Kind.usd or len(run) < 2:
        return
    apart, picture = every * float(run.times[1] - run.times[0]), speed / fps
    if held and apart > 1.01 * picture:
        yield (f"the frames are {apart:.3g} s apart and the pictures of the film {picture:.3g} s: each frame stands for"
               f" {apart / picture:.3g} pictures; run with output.interval = {picture:.3g}"
               + (", or leave out --every" if every > 1 else ""))
    if fps != BLENDER:
        yield f"Blender plays {BLENDER:g} pictures a second whatever the file says: set its frame rate to {fps:g}"
