"""Digests of kernels: alike where all that their source may read is alike, others where any of it is another."""

import os
import subprocess
import sys
import threading
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from snowmpm.compiler import ti
from snowmpm.compiler.fingerprint import Unknown, fingerprint

SHARED = 1.0


class Numbers(NamedTuple):
    a: float
    b: float


class Table:
    size = 3

    def half(self):
        return self.size // 2


def kernel(number=1.0, values=(1, 2), inner=None, table=None, kind=ti.f32):
    @ti.func
    def added(x):
        return x + number

    def compute(found: ti.types.ndarray(dtype=kind)):
        for i in ti.static(range(len(values))):
            found[i] = added(values[i]) + SHARED + (inner(i) if inner else 0) + (table.n if table else 0)

    return compute


def plus(number):
    @ti.func
    def add(x):
        return x + number

    return add


def test_made_twice_it_has_one_digest():
    assert fingerprint(kernel()) == fingerprint(kernel())
    assert fingerprint(kernel(inner=plus(1))) == fingerprint(kernel(inner=plus(1)))


@pytest.mark.parametrize("other", [
    {"number": 2.0}, {"number": 1}, {"values": (1, 3)}, {"values": [1, 2]}, {"values": (1, 2, 2)}, {"inner": plus(1)},
    {"table": SimpleNamespace(n=1)}, {"kind": ti.f64}, {"values": np.array([1, 2])}, {"values": Numbers(1, 2)}])
def test_what_it_closes_over_is_part_of_it(other):
    assert fingerprint(kernel()) != fingerprint(kernel(**other))


@pytest.mark.parametrize(("one", "other"), [
    ({"inner": plus(1)}, {"inner": plus(2)}),
    ({"table": SimpleNamespace(n=1)}, {"table": SimpleNamespace(n=2)}),
    ({"values": np.array([1.0, 2.0])}, {"values": np.array([1.0, 3.0])}),
    ({"values": Numbers(1, 2)}, {"values": Numbers(1, 3)}),
    ({"values": {"a": 1, "b": 2}}, {"values": {"b": 2, "a": 1}}),  # the order in which a loop meets them
    ({"number": 0.0}, {"number": -0.0}),
    ({"number": True}, {"number": 1})])
def test_and_all_that_hangs_on_it(one, other):
    assert fingerprint(kernel(**one)) != fingerprint(kernel(**other))


def test_so_are_names_of_its_module_and_of_others(monkeypatch):
    from snowmpm.particles import blocks

    def of_a_module(found: ti.types.ndarray()):
        found[0] = blocks.EDGE[2] + Table().half()

    before = fingerprint(kernel()), fingerprint(of_a_module)
    monkeypatch.setattr(sys.modules[__name__], "SHARED", 2.0)
    monkeypatch.setattr(blocks, "EDGE", {2: 5, 3: 4})
    assert fingerprint(kernel()) != before[0]
    changed = fingerprint(of_a_module)
    assert changed != before[1]
    monkeypatch.setattr(Table, "size", 4)
    assert fingerprint(of_a_module) != changed


def test_the_source_is_part_of_it(tmp_path):
    text = "def compute(found):\n    found[0] = 0.1 * {} * found[1]\n"
    found = []
    for product in ("2.0 * 3.0", "6.0", "2.0 * 3.0"):  # Python itself makes the first two one
        file = tmp_path / "one.py"
        file.write_text(text.format(product), encoding="utf-8")
        space = {}
        exec(compile(file.read_text(encoding="utf-8"), str(file), "exec"), space)
        found.append(fingerprint(space["compute"]))
    assert found[0] == found[2] != found[1]


def test_what_cannot_be_told_has_none():
    for thing in (threading.Lock(), (i for i in range(3))):
        with pytest.raises(Unknown):
            fingerprint(kernel(table=thing))


def test_it_is_the_same_in_every_process(tmp_path):
    """Whatever the seed of Python's hashes, and wherever objects lie."""
    code = ("from snowmpm.compiler import ti, front_end\nfrom snowmpm import Simulation, load_scene\n"
            "kept = front_end.fingerprint\n"
            "def said(function, *more):\n    name = kept(function, *more)\n    print(function.__name__, name)\n"
            "    return name\n"
            "front_end.fingerprint = said\n"
            "Simulation(load_scene('column_collapse_2d', {'solver.dx': 0.05})).step()\n")
    found = [subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True,
                            env={**os.environ, "PYTHONHASHSEED": seed}).stdout for seed in ("1", "2")]
    assert found[0] == found[1]
    assert found[0].count("\n") > 8
