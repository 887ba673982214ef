"""Runs as files of other programs: particles, surface of the snow, ground and obstacles over time."""

from pathlib import Path

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.io import Run
from snowmpm.render.export import gltf, ply, usd
from snowmpm.render.export.sequence import Sequence

WRITERS = {"usd": usd.write, "ply": ply.write, "gltf": gltf.write}
"""Functions (`Sequence`, folder) -> paths, by the name of the kind."""


def export_run(run: Run, folder: PathLike, kind: str, *, surface: bool = False, fields: list[str] | None = None,
               every: int = 1, speed: float = 1.0, fps: float = 25.0, size: tuple[int, int] = (1280, 720),
               camera: str | None = None, camera_path: PathLike | None = None) -> list[Path]:
    """Write a run for other programs into a folder; -> the paths written.

    kind      "usd": one file for all times; "ply": a binary file a frame; "gltf": a .glb file a frame
    surface   the surface of the snow as a mesh, instead of its particles
    fields    of the snow; by default all that the run holds, but none on a surface in USD
    every     takes every n-th frame
    speed     simulated seconds in a second of film;  fps: pictures a second, of USD
    size, camera, camera_path  of the film whose camera and sun go into USD, as of `render_run`
    Lengths are metres from the run's origin, z up (glTF: y up, as its standard says). Raises InputError for an unknown
    kind or field, a run without frames, and where a library is missing.
    """
    if kind not in WRITERS:
        raise InputError.not_in("--as", kind, WRITERS)
    if every < 1:
        raise InputError.at("--every", every, "must be >= 1")
    for name, value in (("--speed", speed), ("--fps", fps)):
        if not value > 0.0:
            raise InputError.at(name, value, "must be > 0")
    if kind == "usd" and surface and fields is None:
        fields = []  # A mesh is lit, not coloured by numbers, which would be more than its shape
    sequence = Sequence(run, surface=surface, fields=fields, every=every, speed=speed, fps=fps,
                        film={"size": size, "camera": camera, "camera_path": camera_path})
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    return WRITERS[kind](sequence, folder)
