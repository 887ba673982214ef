"""`snowmpm new --set`: values in the text of a scene, with its comments."""

import pytest

from snowmpm.scenes.edited import edited, tomllib

TEXT = """# a scene
name = "x"

[terrain]                         # the ground
kind = "dem"

[terrain.friction]                # a class
card = "samos_at_auto"            # by the volume
"mu" = 0.2
list = [
  1.0,
]
# law = "voellmy"

[[terrain.dams]]
name = "a"

[solver]
dx = 5.0                          # m

[solver.depth]
scheme = "volumes"
"""


@pytest.mark.parametrize(("changes", "expected"), [
    ({"solver.dx": 2.0}, {"solver": {"dx": 2.0, "depth": {"scheme": "volumes"}}}),
    ({"terrain.friction": {"law": "voellmy", "mu": 0.3}}, {"terrain": {
        "kind": "dem", "friction": {"law": "voellmy", "mu": 0.3}, "dams": [{"name": "a"}]}}),
    ({"terrain.friction": 0.4}, {"terrain": {"kind": "dem", "friction": 0.4, "dams": [{"name": "a"}]}}),
    ({"terrain.dams": []}, {"terrain": {"kind": "dem", "dams": [], "friction": {
        "card": "samos_at_auto", "mu": 0.2, "list": [1.0]}}}),
    ({"solver": {"dx": 1.0}}, {"solver": {"dx": 1.0}}),
    ({"materials.snow": {"kind": "elastic"}}, {"materials": {"snow": {"kind": "elastic"}}}),
])
def test_a_value_takes_the_place_of_a_value_or_a_table(changes, expected):
    """All else stays, comments among it."""
    changed = edited(TEXT, changes)
    assert tomllib.loads(changed) == {**tomllib.loads(TEXT), **expected}
    assert "# a scene" in changed and '# law = "voellmy"' in changed
