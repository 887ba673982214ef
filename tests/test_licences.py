"""What README's two commands install may be used by everybody, and the table of licences is right."""

import re
from importlib.metadata import PackageNotFoundError, distribution

import pytest
from packaging.requirements import Requirement

from tests.support.project import PROJECT, ROOT

PAGE = (ROOT / "docs" / "install.md").read_text(encoding="utf-8")
README = (ROOT / "README.md").read_text(encoding="utf-8")
EXTRAS = sorted(set(",".join(re.findall(r'pip install (?:-e )?"\.\[([\w,]+)\]"', README)).split(",")))
REFUSED = re.compile(r"proprietary|non-?commercial|CC[- ]BY-NC|AGPL|(?<!L)GPL-?[23]|GNU General Public|EUPL",
                     re.IGNORECASE)

WORDS = {"Apache-2.0": "apache", "BSD": "bsd", "MIT": "mit", "PSF": "psf|python software", "MIT-CMU": "mit-cmu|hpnd",
         "MPL-2.0": "mpl|mozilla", "TOST-1.0": "tost"}
"""How distributions write a licence of the table."""


def name_of(requirement):
    return requirement.name.lower().replace("_", "-")


def licence(one):
    """What a distribution says of its licence, in all the places where it may."""
    data = one.metadata
    said = [data.get("License-Expression"), *(data.get_all("Classifier") or []), (data.get("License") or "")[:80]]
    return "; ".join(text for text in said if text and (text.startswith("License") or "::" not in text))


def installed(extras):
    """{name: distribution} of all that the program and some extras of it need, however deep."""
    project = PROJECT["project"]
    waiting = [Requirement(text) for text in project["dependencies"]]
    waiting += [Requirement(text) for extra in extras for text in project["optional-dependencies"][extra]]
    found = {}
    while waiting:
        wanted = waiting.pop()
        name = name_of(wanted)
        if name in found or not (wanted.marker is None or wanted.marker.evaluate({"extra": ""})):
            continue
        try:
            found[name] = distribution(wanted.name)
        except PackageNotFoundError:
            continue
        for text in found[name].requires or ():
            below = Requirement(text)
            if below.marker is None or any(below.marker.evaluate({"extra": extra}) for extra in ("", *wanted.extras)):
                below.marker = None
                waiting.append(below)
    return found


def test_readme_names_extras_that_there_are():
    assert {"gis", "dev"} <= set(EXTRAS) <= set(PROJECT["project"]["optional-dependencies"]) and "peers" not in EXTRAS


def test_nothing_that_the_readme_installs_is_for_some_only():
    found = installed(EXTRAS)
    assert len(found) > 30
    assert {name: licence(one) for name, one in found.items() if REFUSED.search(licence(one))} == {}


def test_a_licence_for_some_only_would_be_found():
    weac = pytest.importorskip("weac")
    assert weac and REFUSED.search(licence(distribution("weac")))


def listed():
    """{package: licence} of the table."""
    part = PAGE.split("## Licences")[1]
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \|$", part.split("The ffmpeg program")[0], re.MULTILINE)[1:]
    return {name: words.split(":")[0].strip() for names, words in rows
            for name in re.findall(r"[a-z][a-z0-9-]+", re.sub(r"\(.*?\)", "", names))}


def test_every_dependency_is_in_the_table_with_its_licence():
    project, table = PROJECT["project"], listed()
    texts = [*project["dependencies"], *(text for extra in project["optional-dependencies"].values() for text in extra)]
    wanted = [Requirement(text) for text in texts]
    assert {name_of(one) for one in wanted} <= set(table)
    wrong = {}
    for name in {name_of(one) for one in wanted} & set(installed([*EXTRAS, "docs"])):
        said = licence(distribution(name))
        if not re.search(WORDS[table[name]], said, re.IGNORECASE):
            wrong[name] = said
    assert wrong == {}
