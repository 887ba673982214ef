"""What a saw test cannot tell, since its column or its run is too short (`snowmpm.saw_test.result`)."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.methods import METHODS
from snowmpm.saw_test.prediction import predictions
from snowmpm.saw_test.result import FREE_END, STEADY
from snowmpm.saw_test.weak_layer import weak_layer_of


@rule(*METHODS)
def short_column(facts):
    """By the critical lengths that theories predict, the smallest of them or of the cut."""
    test = facts.scene.saw_test
    if test is None:
        return
    D, length, sawn = test.slab_thickness, test.length, _sawn(facts.scene)
    width = test.resolution or 2.0 * weak_layer_of(facts.scene).finest
    critical = max(test.notch, min([*_critical_lengths(facts.scene), test.cut_length])) + 2.0 * width
    needs = {"crack speed": critical + (STEADY + 1.0 + FREE_END) * D,
             "collapse height": max(critical, sawn) + 4.0 * D, "fracture energy": critical + 3.0 * D}
    if critical > max(0.5 * length, length - 2.0 * D):
        needs["critical length"] = 2.0 * critical
    short = [name for name, need in needs.items() if need > length + 1e-9]
    if short:
        wanted = max(needs[name] for name in short)
        yield Caution("", "saw_test.length", f"{length:g} m is too short to tell {', '.join(short)}",
                      f"saw_test.length = {_up(wanted)}")


@rule(*METHODS)
def short_cut(facts):
    """The run ends before the saw has cut to where theories let a crack run."""
    test, end = facts.scene.saw_test, facts.scene.end_time
    if test is None or _sawn(facts.scene) >= min(test.cut_length, *_critical_lengths(facts.scene), test.length) - 1e-9:
        return
    whole = test.saw_start + (test.cut_length - test.notch) / test.saw_speed
    yield Caution("", "end_time", f"{end:g} s: the saw is then at {_sawn(facts.scene):.2f} of {test.cut_length:g} m",
                  f"end_time = {_up(whole)}")


def _critical_lengths(scene):
    """What theories predict [m]."""
    return [value for name, value in predictions(scene).items() if name.startswith("critical_length_") and value]


def _sawn(scene):
    """Length of the cut at the end of the run [m]."""
    test = scene.saw_test
    return min(test.cut_length, test.notch + max(0.0, scene.end_time - test.saw_start) * test.saw_speed)


def _up(value):
    """A number of two digits that is no smaller."""
    rounded = float(f"{value:.2g}")
    return rounded if rounded >= value else float(f"{1.05 * value:.2g}")
