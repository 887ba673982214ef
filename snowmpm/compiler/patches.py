"""The switch of every patch: a change to Taichi's inside that saves time or memory and changes no result.

No release of Taichi promises to keep its inside. A patch that does not fit the installed one is left out with a
warning, and the program goes on, slower. The environment variable SNOWMPM_PATCHES chooses among them:

    SNOWMPM_PATCHES=none                    apply none
    SNOWMPM_PATCHES=launch,array_memory     apply these only
"""

import os
import warnings
from dataclasses import dataclass

VARIABLE = "SNOWMPM_PATCHES"

GAINS = {
    "class_bodies": "0.3 s of a start",
    "function_trees": "half of the time before the compiler's own work",
    "launch": "60 to 90 us a launch",
    "array_memory": "150 us a copy of a small table",
    "vector_arrays": "the memory of tables that are no longer used",
    "plain_compilation": "15 s of compiling a kernel that works on packs of particles",
}
"""What each patch saves."""

MISFITS = (ImportError, AttributeError, TypeError, KeyError)
"""What a patch raises where Taichi is not as it expects."""


@dataclass
class Patch:
    """One patch. reason: why it is not applied, empty where it is."""

    name: str
    reason: str = ""

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
    """Apply a patch, once, by calling `install`; -> whether it is applied."""
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


def leave_out(name, error):
    """Record that a patch does not fit this Taichi, and warn of it the first time."""
    patch = _patches.setdefault(name, Patch(name))
    if patch.applied:
        patch.reason = f"{type(error).__name__}: {str(error).splitlines()[0]}"
        warnings.warn(f"the installed Taichi is not the one that the patch {name} was made for ({patch.reason});\n"
                      f"without it the program is slower, with the same results; it saves {GAINS[name]}", stacklevel=3)


def is_applied(name):
    """Whether a patch is applied now."""
    return name in _patches and _patches[name].applied


def reasons():
    """Patches that are not applied, with the reason, by name."""
    return {name: patch.reason for name, patch in _patches.items() if not patch.applied}
