"""The oldest versions that pyproject.toml allows, as constraints for pip.

    python .ci/oldest.py gis dev > oldest.txt
    pip install -c oldest.txt -e ".[gis,dev]"

A line for each requirement with a lower bound, of the project and of the extras that are named: `numpy>=1.26` ->
`numpy==1.26`. Requirements without a bound, and those of another Python or system than this, are left out.
"""

import sys
from pathlib import Path

from packaging.requirements import Requirement
from packaging.version import Version

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

PROJECT = Path(__file__).parents[1] / "pyproject.toml"


def constraints(project, extras=()):
    """Constraints of the [project] table of a pyproject.toml, sorted; a name that occurs twice takes the higher bound.

    Raises KeyError for an extra that is not there.
    """
    lowest = {}
    lines = [*project["dependencies"], *(line for extra in extras for line in project["optional-dependencies"][extra])]
    for requirement in map(Requirement, lines):
        if requirement.marker and not requirement.marker.evaluate():
            continue
        bounds = [Version(part.version) for part in requirement.specifier if part.operator in (">=", "==", "~=")]
        if bounds:
            lowest[requirement.name] = max(*bounds, lowest.get(requirement.name, bounds[0]))
    return [f"{name}=={version}" for name, version in sorted(lowest.items())]


if __name__ == "__main__":
    print("\n".join(constraints(tomllib.loads(PROJECT.read_text(encoding="utf-8"))["project"], sys.argv[1:])))
