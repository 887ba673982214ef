"""The memory that reading a file may take."""

import math

import pytest

from snowmpm import memory
from snowmpm.errors import InputError
from snowmpm.reading import budget as read_budget


@pytest.fixture(autouse=True)
def _as_installed(monkeypatch):
    monkeypatch.delenv(read_budget.VARIABLE, raising=False)
    monkeypatch.setattr(memory, "available", lambda: 64 * 2.0**30)


@pytest.mark.parametrize("size", [0, 1, 4.0 * 2**30])
def test_what_fits_is_allowed(size):
    read_budget.allow("dem.tif", size, "its cells")


@pytest.mark.parametrize("size", [4.0 * 2**30 + 1, 1e300 * 1e10, math.nan, -1])
def test_what_does_not_fit_is_refused(size):
    with pytest.raises(InputError, match=r"dem\.tif: its cells need .* 4 GiB are allowed"):
        read_budget.allow("dem.tif", size, "its cells")


def test_the_message_names_file_size_and_limit():
    with pytest.raises(InputError) as refused:
        read_budget.allow("dem.tif", 74.5 * 2**30, "100000 x 100000 cells", "terrain.region cuts it")
    assert str(refused.value) == ("dem.tif: 100000 x 100000 cells need 74.5 GiB of memory, and 4 GiB are allowed for a"
                                  " file (SNOWMPM_READ_GIB sets it); terrain.region cuts it")


def test_no_more_than_is_free(monkeypatch):
    monkeypatch.setattr(memory, "available", lambda: 2.0**30)
    with pytest.raises(InputError, match="need 2 GiB of memory, and 1 GiB are free"):
        read_budget.allow("dem.tif", 2 * 2.0**30, "its cells")


def test_a_person_may_set_it(monkeypatch):
    monkeypatch.setenv(read_budget.VARIABLE, "0.5")
    with pytest.raises(InputError, match=r"0\.5 GiB are allowed"):
        read_budget.allow("dem.tif", 2.0**30, "its cells")
    monkeypatch.setenv(read_budget.VARIABLE, "8")
    read_budget.allow("dem.tif", 7 * 2.0**30, "its cells")


@pytest.mark.parametrize("text", ["", "much", "0", "-1", "nan"])
def test_a_setting_that_is_no_size_is_refused(monkeypatch, text):
    monkeypatch.setenv(read_budget.VARIABLE, text)
    with pytest.raises(InputError, match=r"SNOWMPM_READ_GIB = .*: must be a number of GiB above 0"):
        read_budget.allow("dem.tif", 1, "its cells")
