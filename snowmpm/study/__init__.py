"""Studies of the program itself: how much error costs how much time, where a scheme fails, at which order it converges.

    for path in open_study("accuracy-speed").study(folder, quick=True, say=print): ...

A study is a module of this package with a function `study(folder, *, quick, only, say)` that writes tables (CSV),
charts (PNG) and what they say (Markdown) to `folder` and returns their paths. only: names of the problems or entries to
take, all when empty; say: called with a line now and then. Its docstring begins with what `snowmpm study` lists.
"""

import importlib

from snowmpm.errors import InputError

STUDIES = {
    "accuracy-speed": "snowmpm.study.accuracy_speed",
    "convergence": "snowmpm.study.convergence",
    "scaling": "snowmpm.study.scaling",
    "presets": "snowmpm.study.presets",
    "stability": "snowmpm.study.stability",
    "models": "snowmpm.ladder.study",
}
"""Module of each study."""


def open_study(name):
    """Module of the study `name`. Raises InputError for a name that there is none of."""
    if name not in STUDIES:
        raise InputError.at("NAME", name, f"must be one of {', '.join(STUDIES)}")
    return importlib.import_module(STUDIES[name])
