"""Rules: a saw test whose column fails before it is cut, or with loads that theory neglects."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.saw_test.prediction import uncounted_by_theories
from snowmpm.saw_test.strength import loads, overloaded

CURE = "a gentler saw_test.slope_angle, a lighter slab or a stronger layer stands"
NEARLY = 0.9
"""Share of its shear strength from which on a layer weakens before it is cut: near the ends loads are larger."""
CURE_OF_END = 'saw_test.ends = "vertical", or a gentler slope'


@rule("mpm", "sph")
def uncounted_load(facts):
    """A saw test with loads other than the weight of its slab."""
    if facts.scene.saw_test and (names := uncounted_by_theories(facts.scene)):
        yield Caution("", names[0], f"theories of the saw test count the weight of the slab alone, not"
                      f" {' and '.join(names)}", "read them as those of the test without")


@rule("mpm", "sph")
def overloaded_layer(facts):
    """A layer that yields under the weight of the snow above it on the given slope."""
    failing = overloaded(facts.scene)
    standing = loads(facts.scene) if facts.scene.saw_test and not failing else []
    for load in standing:
        if load.share > NEARLY:
            yield Caution("", "saw_test.slope_angle", f"weight and slope load {load.layer}"
                          f" (materials.{load.material}) to {load.share:.0%} of its shear strength, and to more near"
                          " the ends of the column: it weakens before the saw comes", CURE)
    for load in failing:
        if load.at_end:
            yield Caution("", "saw_test.ends", str(load), CURE_OF_END)
        else:
            yield Caution("", "saw_test.slope_angle" if load.strength > 0.0 else "saw_test.slab", str(load), CURE)
