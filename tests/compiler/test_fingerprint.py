"""Digests of kernels: alike where all that their source may read is alike, others where any of it is another."""

import functools
import os
import subprocess
import sys
import threading
from collections import OrderedDict
from enum import Enum
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from snowmpm.compiler import ti
from snowmpm.compiler.fingerprint import Unknown, fingerprint
from snowmpm.particles import blocks

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


class Sizes:
    """A table of a class."""

    rows, columns = (1, 2), [3, 4]


class Mode(Enum):
    """Of two kinds."""

    ON = (1, 2)
    OFF = 0


class Own(dict):
    """More than its attributes."""


class Anything:
    """Answers to names that it does not hold."""

    def __getattr__(self, name):
        return 1


def scaled(number):
    def decorate(function):
        @functools.wraps(function)
        def call(x):
            return number * function(x)

        return call

    return decorate


def test_so_is_what_a_class_holds(monkeypatch):
    before = fingerprint(kernel(table=Sizes()))
    monkeypatch.setattr(Sizes, "rows", (1, 3))
    changed = fingerprint(kernel(table=Sizes()))
    Sizes.columns[1] = 5  # in place
    assert len({before, changed, fingerprint(kernel(table=Sizes()))}) == 3
    Sizes.columns[1] = 4


def test_and_a_member_and_what_a_decorator_adds(monkeypatch):
    before = fingerprint(kernel(table=Mode.ON))
    monkeypatch.setattr(Mode.ON, "_value_", (1, 3))
    assert fingerprint(kernel(table=Mode.ON)) != before
    one, two = (scaled(number)(abs) for number in (1.0, 2.0))
    assert fingerprint(kernel(inner=one)) != fingerprint(kernel(inner=two))
    assert fingerprint(kernel(inner={1: 2}.get)) != fingerprint(kernel(inner={1: 3}.get))


def test_texts_that_differ_in_a_name_alone_are_told_apart():
    """Without a file, and in one line."""
    found = set()
    for name in ("a", "b"):
        space = {}
        exec(f"def compute(table):\n    return (lambda t: t.{name})(table)\n", space)
        found.add(fingerprint(space["compute"]))
    assert len(found) == 2


def test_names_in_annotations_of_a_function_count(monkeypatch):
    def annotated(found: ti.types.ndarray()):
        x: KIND = 0.1
        found[0] = x

    before = fingerprint(annotated)
    monkeypatch.setattr(sys.modules[__name__], "KIND", ti.f64)
    assert fingerprint(annotated) != before


KIND = ti.f32


def test_modules_are_followed_to_the_end(monkeypatch):
    import snowmpm
    import snowmpm.particles.blocks

    def two_deep(found: ti.types.ndarray()):
        found[0] = snowmpm.particles.blocks.EDGE[2]

    before = fingerprint(two_deep)
    monkeypatch.setattr(snowmpm.particles.blocks, "EDGE", {2: 5, 3: 4})
    assert fingerprint(two_deep) != before


def importing(i):
    import math

    return math.sqrt(i)


def handing_on(i):
    return getattr(blocks, "EDGE")[i]  # noqa: B009 (what is tried)


def of_texts(i: "int"):
    return i


@pytest.mark.parametrize("thing", [
    threading.Lock(), (i for i in range(3)), Own(a=1), OrderedDict(a=1), Anything(), np.ma.array([1.0]), blocks,
    (blocks,), importing, handing_on, of_texts, functools.singledispatch(lambda i: i), np.frompyfunc(abs, 1, 1)],
    ids=lambda thing: type(thing).__name__)
def test_what_cannot_be_told_has_none(thing):
    with pytest.raises(Unknown):
        fingerprint(kernel(table=thing))


def test_a_set_is_told_in_the_order_in_which_a_loop_meets_it():
    """Which is another with another seed of Python's hashes: then the kernel is, too."""
    code = ("from snowmpm.compiler.fingerprint import fingerprint\nnames = {'a', 'b', 'c', 'd', 'e'}\n"
            "def compute(found):\n    return [n for n in names]\nprint(list(names), fingerprint(compute))")
    found = {subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True,
                            env={**os.environ, "PYTHONHASHSEED": str(seed)}).stdout for seed in range(1, 4)}
    assert len({line.split("]")[0] for line in found}) == len({line.split("]")[1] for line in found}) > 1


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
