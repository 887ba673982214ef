"""The end of another run as the start of this one: its particles, body by body, from its last checkpoint."""

import hashlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError, did_you_mean
from snowmpm.io import checkpoint
from snowmpm.io.archive import read_archive, write_archive
from snowmpm.materials import LAWS
from snowmpm.particles.blocks import EDGE, coordinates_of, places_of
from snowmpm.particles.store import IDENTITY

KEPT = "initial.npz"
"""File of a run folder with the state from the other run, so that the run can continue without it."""
KEY = "initial.from"
COLUMNS = ("velocity", "affine", "elastic", "stress", "state", "volume_ratio", "volume")
CARD = ("card", "began_with", "card_source")
"""Where numbers of a material come from, which changes nothing."""


@dataclass
class TakenState:
    """bodies: {name: {column: (n, ...)}} with position [m] beside `COLUMNS`; source: run, scene, time [s], program and
    sha256 of the checkpoint; differences: lines on how the materials differ from those of that run."""

    bodies: dict
    source: dict
    differences: list = field(default_factory=list)

    def write(self, folder):
        """Write the state to a run folder."""
        write_archive(Path(folder) / KEPT, {"bodies": self.bodies, "source": self.source,
                                            "differences": self.differences})

    @classmethod
    def kept(cls, folder):
        """Read what `write` wrote. Raises InputError if it is missing or damaged."""
        path = Path(folder) / KEPT
        found = read_archive(path)
        if set(found) != {"bodies", "source", "differences"}:
            raise InputError(f"{path}: damaged, or not written by this program")
        return cls(**found)


def take(scene, surface):
    """`TakenState` of the run that a scene's initial.from names: of the bodies that both have. surface: of the terrain.

    Raises InputError when there is no such run, or it has another dimension, method, spacing or terrain, none of the
    bodies, or a body of another law, density or stiffness.
    """
    where = f"{scene.source}: {KEY} = {str(scene.initial.from_run)!r}"
    try:
        return _take(scene, surface)
    except InputError as error:
        raise InputError(f"{where}: {error}") from None
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:  # intact, but not a checkpoint
        raise InputError(f"{where}: its checkpoint is not one of this program ({type(error).__name__})") from None


def _take(scene, surface):
    """`take`, with errors that do not say which scene and key they are about."""
    folder = Path(scene.base_dir) / Path(scene.initial.from_run).expanduser()
    folder = folder.parent if folder.suffix in (".vtkhdf", ".npz") else folder
    if not folder.is_dir():
        raise InputError(f"no such run folder (looked for {folder})")
    saved = checkpoint.read(folder / checkpoint.FILE)
    there, here = checkpoint.tables(saved["scene"]), checkpoint.tables(scene.to_toml())
    if "saw_test" in there or scene.saw_test:
        raise InputError("the column of a saw test starts from its own rest, and no other scene from it")
    if saved["simulation"].get("relay", {}).get("index"):
        raise InputError("handed over to another method (switch): its particles are not those that its bodies began as")
    if "zone" in there:
        raise InputError("has a zone, where its particles are not those that its bodies began as")
    _check_setting(there, here, saved, surface)
    state, bodies, differences = saved["simulation"], {}, []
    if "reals" in state["solver"] and "columns" not in state["solver"]:
        raise InputError(f"was written by snowmpm {saved['program']}, whose checkpoints do not name the numbers of"
                         " particles: run it again")
    names = [body["name"] for body in there["bodies"]]
    wanted = [body.name for body in scene.bodies if body.name in names]
    if not wanted:
        raise InputError(f"none of its bodies, {', '.join(names)}, is one of this scene"
                         f"{did_you_mean(scene.bodies[0].name, names)}")
    particles = _particles(state["solver"], there["dimension"], there["solver"])
    number = state["solver"]["labels"][:, IDENTITY]
    of_body = np.searchsorted(state["body_starts"], number, side="right") - 1
    for body in scene.bodies:
        if body.name not in wanted:
            continue
        if any(body.velocity):
            raise InputError(f"the velocity of {body.name} comes from there: leave bodies' velocity out")
        index = names.index(body.name)
        differences += _check_law(body, there["materials"][there["bodies"][index]["material"]],
                                  here["materials"][body.material])
        own = np.flatnonzero(of_body == index)
        if not len(own):
            raise InputError(f"nothing is left of {body.name} there")
        own = own[np.argsort(number[own], kind="stable")]
        bodies[body.name] = {name: column[own] for name, column in particles.items()}
    digest = hashlib.sha256(Path(saved["path"]).read_bytes()).hexdigest()
    return TakenState(bodies, {"run": str(folder), "scene": there["name"], "time": saved["time"],
                               "program": saved["program"], "sha256": digest}, differences)


def _check_setting(there, here, saved, surface):
    """Raise InputError where dimension, method, spacing or terrain of two runs differ.

    there, here: tables of the two scenes; saved: checkpoint of the run there; surface: terrain of the scene here.
    """
    for key in ("dimension", "solver.method", "solver.dx"):
        was, now = ((t["solver"][key[7:]] if "." in key else t[key]) for t in (there, here))
        if was != now:
            raise InputError(f"has {key} = {was}, and this scene {now}: particles are not made anew")
    was, now = (_terrain(t) for t in (there, here))
    if was != now or ("file" in (was or {}) and saved["terrain"] != checkpoint.terrain_digest(surface)):
        raise InputError("has another terrain, or another part of it, than this scene")


def _terrain(tables):
    """Entries of a scene's terrain table that determine its shape; None without terrain.

    A file is reduced to its name: the same terrain may lie in another folder.
    """
    table = tables.get("terrain")
    if table is None:
        return None
    shape = {key: value for key, value in table.items() if key not in ("contact", "friction", "attribution")}
    return {**shape, "file": Path(shape["file"]).name} if "file" in shape else shape


def _check_law(body, was, now):
    """Lines on how the material table of a body differs, between `was` (the other run) and `now` (this scene).

    Raises InputError where the law, the density or an elastic modulus differs: particles depend on them.
    """
    if was["kind"] != now["kind"]:
        raise InputError(f"{body.name} has the law {was['kind']} there, and {now['kind']} in this scene")
    laws = [LAWS[table["kind"]].model_validate({k: v for k, v in table.items() if k not in CARD})
            for table in (was, now)]
    for name in ("density", "bulk_modulus", "shear_modulus"):
        before, after = (law[name] for law in laws)
        if not np.isclose(before, after, rtol=1e-9):
            raise InputError(f"{body.name} has {name} = {before:.6g} there, and {after:.6g} in this scene; only"
                             " strength may differ")
    return [f"materials.{body.material}.{key}: {was.get(key)} there, {now.get(key)} here"
            for key in dict.fromkeys([*was, *now]) if key not in CARD and was.get(key) != now.get(key)]


def _particles(solver, dim, options):
    """{column: (n, size)} of the particles of a solver's `state()`, in its order, with "position" [m, scene].

    dim: dimension; options: solver table of the scene there. Columns are `COLUMNS`, in float64.
    """
    reals, sizes = solver["reals"].astype(np.float64), solver["columns"]
    ends = dict(zip(sizes, np.cumsum(list(sizes.values())), strict=True))
    if sum(sizes.values()) != reals.shape[1]:
        raise ValueError("columns do not fit the particles")

    def column(name):
        return reals[:, ends[name] - sizes[name] : ends[name]]

    owner_block = np.repeat(coordinates_of(places_of(solver["keys"], dim), dim), np.diff(solver["start"]), axis=0)
    cells = EDGE[dim] * owner_block + column("position")
    return {**{name: column(name) for name in COLUMNS}, "position": solver["frame"][0] + options["dx"] * cells}
