"""Scenes of the library say where their numbers come from."""

import re

import pytest

from snowmpm.scenes.library import comment, library


@pytest.mark.parametrize("name", library())
def test_what_is_published_and_what_is_chosen(name):
    """Either may be all: "Chosen: all numbers"."""
    said = " ".join(comment(name))
    assert re.search(r"\bChosen: ", said)
    assert re.search(r"\bPublished: ", said) or re.search(r"\bChosen: all numbers", said)
