"""Each pair of components that a method supports is declared in conflict, or runs five steps with closed budgets."""

import contextlib
import importlib
import itertools

import pytest

from snowmpm import components
from snowmpm.errors import InputError
from snowmpm.registry import COMPONENTS
from snowmpm.running.simulation import Simulation
from tests.contract import method_examples as given
from tests.contract.method_suite import steps

METHODS = "mpm", "sph", "depth", "implicit"
ONE_TABLE = {"flow_water", "pore_water", "seepage", "two_velocities"}
"""Components that one table of a scene asks for, by a key that has one value."""
PAIRS = [(method, *pair) for method in METHODS for pair in itertools.combinations(
    sorted(component.name for component in components.declared() if component.supports(method)), 2)
    if not set(pair) <= ONE_TABLE]
CONFLICT = "does not go with", "is not computed around", "acts on columns"


def joined(*tables):
    """Tables of a scene together: values of keys, entries of lists, tables of the same name in these joined again."""
    found = {}
    for table in tables:
        for key, value in table.items():
            before = found.get(key)
            if isinstance(before, dict) and before.get("kind") == value.get("kind", before.get("kind")):
                value = joined(before, value)
            elif isinstance(before, list) and isinstance(value, list):
                named = {item.get("name", i): item for i, item in enumerate(before)}
                for i, item in enumerate(value):
                    name = item.get("name", len(before) + i)
                    named[name] = {**named.get(name, {}), **item}
                value = list(named.values())
            found[key] = value
    return found


def part_of(name, method):
    """Context: keys of a scene for a component."""
    module = importlib.import_module(f"tests.components.{name}.capability")
    return module.part_of(method) if hasattr(module, "part_of") else contextlib.nullcontext(module.part(method))


@pytest.mark.parametrize(("method", "first", "second"), PAIRS, ids=map(" ".join, PAIRS))
def test_pair(method, first, second):
    dim = given.least_dimension(method)
    block = {"bodies": [given.block(dim, (2.0, 0.0))], "solver": {}, "materials": {"snow": given.snow(method)}}
    if COMPONENTS["body_contact"].supports(method):
        block["solver"]["transfer"] = "apic"
    with part_of(first, method) as one, part_of(second, method) as two:
        scene = given.scene(method, **joined(block, one, two))
        try:
            simulation = Simulation(scene)
        except InputError as error:
            assert any(words in str(error) for words in CONFLICT), error
            return
        assert {first, second} <= {adapter.name for adapter in simulation.solver.adapters}
        start = simulation.audit()
        row = steps(simulation, 5).audit()
    gained = row["entrained_mass"] - row["laid_mass"] - row["removed_mass"]
    gained += row.get("added_water", 0.0) - row.get("drained_water", 0.0)
    gained += row.get("settled_mass", 0.0) - row.get("suspended_mass", 0.0)
    assert row["mass"] == pytest.approx(start["mass"] + gained, rel=1e-6)
    solved = scene.solver.implicit
    assert row["momentum_residual"] < (solved.tolerance if solved else 1e-9)
    energy = start["kinetic_energy"] + abs(row["force_work"]) + 1e-9
    # finite volumes lose 26 % in the shock of this block, four cells wide, without any component
    assert abs(row["energy_remainder"]) < (0.3 if scene.solver.in_volumes else 0.1) * energy


def test_conflicts_are_what_components_declare():
    """Things that only one may have are those of two at least, or would be no matter of pairs."""
    owners = {}
    for component in components.declared():
        for thing in component.owns:
            owners.setdefault(thing, []).append(component.name)
    assert owners["the velocity fields of nodes"] == ["two_velocities", "body_contact", "interface_layer"]
    assert owners["the deformation of particles"] == ["interface_layer", "f_bar"]
