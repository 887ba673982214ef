"""The switch of every patch: a change to Taichi's inside that saves time or memory and changes no result.

No release of Taichi promises to keep its inside. A patch that does not fit the installed one is undone with a warning,
and the program goes on, slower. `snowmpm.compiler.probe` tries each of them when Taichi starts. The environment
variable SNOWMPM_PATCHES chooses among them:

    SNOWMPM_PATCHES=none                    apply none
    SNOWMPM_PATCHES=launch,array_memory     apply these only
"""

import os
import warnings
from dataclasses import dataclass, field

VARIABLE = "SNOWMPM_PATCHES"

GAINS = {
    "class_bodies": "0.3 s of a start",
    "function_trees": "half of the time before the compiler's own work",
    "front_end": "most of that time where the kernels are on disk",
    "launch": "60 to 90 us a launch",
    "relaunch": "25 to 50 us a launch of the same kernel again",
    "array_memory": "150 us a copy of a small table",
    "array_lifetime": "the memory of tables that are no longer used",
}
"""What each patch saves."""


class Misfit(Exception):
    """A patch that is in place in the installed Taichi and does not do what it is for."""


MISFITS = (ImportError, AttributeError, TypeError, KeyError, Misfit)
"""What a patch raises where Taichi is not as it expects."""

_NOTHING = object()


@dataclass
class Patch:
    """One patch. reason: why it is not applied, empty where it is; replaced: owners, names and values before it."""

    name: str
    reason: str = ""
    replaced: list = field(default_factory=list)

    @property
    def applied(self):
        return not self.reason


_patches = {}


def wanted(name):
    """Whether the environment asks for a patch. Raises ValueError for a name that is none."""
    choice = os.environ.get(VARIABLE, "all").strip()
    if choice in ("all", "none", ""):
        return choice != "none"
    names = {part.strip() for part in choice.split(",")}
    if unknown := sorted(names - set(GAINS)):
        raise ValueError(f"{VARIABLE}={choice}: {unknown[0]} is no patch; there are {', '.join(GAINS)}, all and none")
    return name in names


def apply(name, install):
    """Apply the patch `name`, a key of GAINS, and return whether it is applied.

    The first call of a name calls `install()`, unless SNOWMPM_PATCHES switches the patch off. If `install` raises one
    of MISFITS, the patch is undone with a warning. Later calls only report.
    """
    if name not in _patches:
        patch = _patches[name] = Patch(name)
        if not wanted(name):
            patch.reason = "switched off"
        else:
            try:
                install()
            except MISFITS as error:
                leave_out(name, error)
    return _patches[name].applied


def replace(name, owner, attribute, value, new=False):
    """Put a value of the patch `name` in place of an attribute of a module or class of Taichi.

    new: whether Taichi itself need not have it there. Raises AttributeError where it must and has not.
    """
    before = vars(owner).get(attribute, _NOTHING)
    if before is _NOTHING and not new:
        raise AttributeError(f"{owner.__name__} has no {attribute}")
    _patches[name].replaced.append((owner, attribute, before))
    setattr(owner, attribute, value)


def leave_out(name, error):
    """Undo the patch `name`, which does not fit this Taichi, and warn the first time with `error` as the reason."""
    patch = _patches.setdefault(name, Patch(name))
    while patch.replaced:
        owner, attribute, before = patch.replaced.pop()
        if before is _NOTHING:
            delattr(owner, attribute)
        else:
            setattr(owner, attribute, before)
    if patch.applied:
        said = str(error).strip().splitlines() or ["no reason"]
        patch.reason = f"{type(error).__name__}: {said[0]}"
        warnings.warn(f"the installed Taichi is not the one that the patch {name} was made for ({patch.reason});\n"
                      f"without it the program is slower, with the same results; it saves {GAINS[name]}", stacklevel=3)


def is_applied(name):
    """Whether a patch is applied now."""
    return name in _patches and _patches[name].applied


def reasons():
    """{name: reason} of the patches that were tried or switched off and are not applied."""
    return {name: patch.reason for name, patch in _patches.items() if not patch.applied}
