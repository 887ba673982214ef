"""The suite of `transfer_suite` over every transfer that is registered: a new one has its tests by being there."""

from dataclasses import replace

import pytest

from snowmpm.schemes import SCHEMES, TRANSFERS, Transfer
from tests.mpm.transfer_suite import CHECKS, CLAIMS, Case, Claims, without_claims

# All of them in plane strain; in 3-D, whose kernels take longer to compile, each transfer once, over bases and
# gradients
PLANE = [Case(2, *scheme) for scheme in SCHEMES]
SPACE = [Case(3, kernel, gradient, transfer) for kernel, gradient, transfer in (
    ("quadratic", "affine", "apic"), ("quadratic", "shape", "pic"), ("cubic", "affine", "flip"),
    ("cubic", "shape", "aflip"), ("linear", "shape", "flip"))]


def name_of(case):
    return "-".join(map(str, (case.dim, case.kernel, case.gradient, case.transfer)))


def test_every_registered_transfer_claims_something():
    assert not without_claims()


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
@pytest.mark.parametrize("case", PLANE + SPACE, ids=name_of)
def test_transfer(case, check):
    check(case)


def failures(case):
    """Names of the checks that a case does not pass."""
    failed = set()
    for check in CHECKS:
        try:
            check(case)
        except AssertionError:
            failed.add(check.__name__)
    return failed


@pytest.fixture
def registered(monkeypatch):
    """registered(transfer, claims) -> a `Case` of it."""

    def add(transfer, claims):
        monkeypatch.setitem(TRANSFERS, transfer.name, transfer)
        assert without_claims() == {transfer.name}  # and the suite says so
        monkeypatch.setitem(CLAIMS, transfer.name, claims)
        return Case(2, "quadratic", "affine", transfer.name)

    return add


def test_a_transfer_that_is_registered_gets_the_suite(registered):
    assert not failures(registered(replace(TRANSFERS["apic"], name="twin"), CLAIMS["apic"]))


@pytest.mark.parametrize(("affine", "claims", "found"), [
    (False, CLAIMS["apic"], {"linear_motion", "momenta", "a_wave"}),
    (True, Claims(linear=True, spin=True, order=1), {"a_wave"}),
    (True, Claims(linear=False, spin=False, order=3), {"linear_motion", "momenta"})])
def test_the_suite_finds_what_is_wrong(registered, affine, claims, found):
    """Claims beyond what a transfer keeps, and short of it."""
    failed = failures(registered(Transfer("boastful", affine=affine, flip=False), claims))
    assert failed == {check.__name__ for check in CHECKS if check.__name__.startswith(tuple(found))}
