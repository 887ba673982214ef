"""What is registered is known at once to scenes, schemas and messages; what cannot be is refused by name."""

from typing import ClassVar, Literal

import pytest

import snowmpm
from snowmpm.errors import InputError
from snowmpm.materials import LAWS, Elastic
from snowmpm.measured import costs
from snowmpm.methods import METHODS, MethodEntry
from snowmpm.registry import EVENTS
from snowmpm.scenes import load_scene
from snowmpm.scenes.events import Event
from snowmpm.scenes.messages import schema_of
from snowmpm.scenes.schema import Scene

SNOW = {"kind": "plain", "density": 300.0, "youngs_modulus": 1e5, "poisson_ratio": 0.2}


class Plain(Elastic):
    """An elastic law by another name."""

    kind: Literal["plain"] = "plain"


def fence(**settings):
    return load_scene("fence_2d", {"materials.snow": SNOW, **settings})


def test_a_law_is_known_once_it_is_registered():
    with pytest.raises(InputError, match=r'materials.snow.kind = "plain": must be one of "elastic", '):
        fence()
    assert "Plain" not in schema_of(Scene)["$defs"]
    assert snowmpm.register(Plain) is Plain
    assert type(fence().materials["snow"]) is Plain and LAWS["plain"] is Plain
    assert "Plain" in schema_of(Scene)["$defs"]
    with pytest.raises(InputError, match=r'"wet_snow", "plain"; did you mean plain?'):
        fence(**{"materials.snow.kind": "plane"})


def test_what_is_written_can_be_read(tmp_path):
    snowmpm.register(Plain)
    (tmp_path / "again.toml").write_text(fence().to_toml())
    assert load_scene(tmp_path / "again.toml").materials == fence().materials


def test_a_name_that_is_taken_is_refused():
    class Elastics(Elastic):
        """Of another name, of the same kind."""

    with pytest.raises(InputError, match=r"law 'elastic': there is one already, of snowmpm"):
        snowmpm.register(Elastics)
    snowmpm.register(Plain)

    class Other(Elastic):
        kind: Literal["plain"] = "plain"

    with pytest.raises(InputError, match=r"law 'plain': there is one already, of .*test_registry"):
        snowmpm.register(Other)


def test_a_class_that_is_defined_anew_takes_its_own_place():
    """As where a cell of a notebook is run again."""
    for stiffness in (1.0, 2.0):
        namespace = {"__name__": __name__, "Elastic": Elastic, "Literal": Literal, "snowmpm": snowmpm}
        exec('@snowmpm.register\nclass Cell(Elastic):\n    kind: Literal["cell"] = "cell"\n'
             f"    stiffer: float = {stiffness}\n", namespace)
    assert LAWS["cell"].model_fields["stiffer"].default == 2.0


@pytest.mark.parametrize("thing", [object(), Scene, 5, lambda: None])
def test_what_belongs_nowhere_is_refused(thing):
    with pytest.raises(InputError, match="no law, event, force, shape, field, component, method or command"):
        snowmpm.register(thing)


def test_an_entry_without_a_name_is_refused():
    class Nameless(Event):
        """Has no kind."""

        NEEDS: ClassVar = "loads"

    before = dict(EVENTS)
    with pytest.raises(InputError, match=r'a event needs kind: Literal\["its name"\]'):
        snowmpm.register(Nameless)
    assert dict(EVENTS) == before


def test_a_law_without_measured_cost_takes_that_of_its_base():
    snowmpm.register(Plain)
    scheme = costs.Scheme(2)
    assert costs.taken_as("plain") == "elastic" and costs.taken_as("wet_snow") == "wet_snow"
    assert costs.law(scheme, "plain") == costs.law(scheme, "elastic")


def test_a_method_is_a_row():
    with pytest.raises(InputError, match=r'solver.method = "sheets": must be "mpm", "sph", "depth" or "implicit"'):
        load_scene("fence_2d", {"solver.method": "sheets"})
    snowmpm.register(MethodEntry("sheets", lambda *_: None, METHODS["mpm"].capabilities))
    assert load_scene("fence_2d", {"solver.method": "sheets"}).solver.method == "sheets"
