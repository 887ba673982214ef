"""The structures of a scene that another program computes, and how it is met."""

from pathlib import Path

from snowmpm.components.precice.exchange import Exchange, library
from snowmpm.components.precice.external import External
from snowmpm.components.precice.precice_file import PreciceFile
from snowmpm.components.precice.tables import External as ExternalSpec
from snowmpm.components.structures.from_scene import in_space
from snowmpm.errors import InputError

SAME = 1e-9
"""Relative difference of two times that are meant to be one."""


def externals(scene):
    """[(number, spec)] of the structures of a scene that another program computes."""
    return [(i, spec) for i, spec in enumerate(scene.structures) if isinstance(spec, ExternalSpec)]


def windows(scene):
    """`.precice_file.Windows` of a scene; None where it computes all structures itself.

    InputError: the configuration does not fit the scene.
    """
    found = externals(scene)
    if not found:
        return None
    for i, spec in found:
        _check(scene, i, spec)
    i, spec = found[0]
    own = _file(scene, f"structures.{i}.precice", spec.precice).windows(spec.precice.participant)
    _fits(scene, i, own)
    return own


def path_of(scene):
    """Path of the configuration of preCICE."""
    return Path(scene.base_dir, Path(externals(scene)[0][1].precice.file).expanduser())


def exchange(model):
    """`.exchange.Exchange` of a `Model`; None where it computes all structures itself.

    InputError: the library is not installed.
    """
    own, scene = windows(model.scene), model.scene
    if own is None:
        return None
    i = externals(scene)[0][0]
    module = library(f"structures.{i}.precice", scene.source)
    made = model.made["structures"]
    return Exchange(module, own, [(made[i], spec.precice) for i, spec in externals(scene)], scene.dimension)


def polyline(scene, i):
    """`External` of structure i of a scene."""
    spec = scene.structures[i]
    return External([in_space(point) for point in spec.points], spec.segments)


def _file(scene, table, names):
    return PreciceFile(Path(scene.base_dir, Path(names.file).expanduser()), table, scene.source)


def _check(scene, number, spec):
    """Refuse names that the configuration does not have, and a second participant: a program is one."""
    first_number, first = externals(scene)[0]
    table, names = f"structures.{number}.precice", spec.precice
    read = {"displacement": names.displacement, **({"velocity": names.velocity} if names.velocity else {})}
    _file(scene, table, names).check(names.participant, names.mesh, scene.dimension, {"force": names.force}, read)
    for key in ("file", "participant"):
        if names[key] != first.precice[key]:
            raise InputError.at(f"{table}.{key}", names[key], f"must be that of structures.{first_number},"
                                f" {first.precice[key]}: snowmpm is one participant", scene.source)
    for other, before in externals(scene):
        if other < number and before.precice.mesh == names.mesh:
            raise InputError.at(f"{table}.mesh", names.mesh, f"is the mesh of structures.{other} too", scene.source)


def _fits(scene, number, own):
    """Refuse time windows that do not fit the times of the scene."""
    key, name = f"structures.{number}.precice.file", externals(scene)[0][1].precice.file
    if abs(own.end - scene.end_time) > SAME * scene.end_time:
        raise InputError.at("end_time", scene.end_time, f"must be {own.end:g} s, where the coupling in {name} ends",
                            scene.source)
    if scene.stop.at_rest:
        raise InputError.at("stop.at_rest", True, "does not go with another program, which goes on to end_time",
                            scene.source)
    if not own.implicit:
        return
    if own.size is None:
        raise InputError.at(key, name, f"has no time-window-size for its {own.scheme} scheme", scene.source)
    frames = scene.output.interval / own.size
    if abs(frames - round(frames)) > SAME * frames or round(frames) < 1:
        raise InputError.at("output.interval", scene.output.interval, f"must be a multiple of time-window-size,"
                            f" {own.size:g} s, where windows are repeated ({own.scheme})", scene.source)
