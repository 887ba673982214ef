"""Patches to Taichi's inside save time and change no result."""

import pytest

from snowmpm.compiler import patches


@pytest.mark.slow
@pytest.mark.parametrize("choice", ["none", "all", *patches.GAINS])
def test_the_same_bits_with_other_patches(program, expected, monkeypatch, choice):
    monkeypatch.setenv(patches.VARIABLE, choice)
    assert program("print(go_on(block()))\nprint(go_on(block('f64')))") == [expected["f32"], expected["f64"]]
