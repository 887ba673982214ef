"""A warning of `snowmpm check`, and the registry of the rules that produce warnings."""

import math
from dataclasses import dataclass

from snowmpm.errors import InputError
from snowmpm.measured.borders import shipped
from snowmpm.methods import METHODS
from snowmpm.scenes.loader import with_overrides
from snowmpm.setup.refusals import refuse_beyond

RULES = {name: [] for name in METHODS}
"""Rules by method, in the order of evaluation."""


@dataclass(frozen=True)
class Caution:
    """entry: of the atlas, or ""; key: of the scene; says: which value is beyond which border; cure: settings."""

    entry: str
    key: str
    says: str
    cure: str

    def __str__(self):
        return f"{self.key}: {self.says}; {self.advice}"

    @property
    def advice(self):
        """The cure, and where to read more."""
        return f"{self.cure} (atlas: {self.entry})" if self.entry else self.cure


def accepted(facts, changes):
    """Whether a scene takes other values of some keys, {dotted key: value}: what it refuses is not advised."""
    try:
        refuse_beyond(with_overrides(facts.scene, changes))
    except InputError:
        return False
    return True


CURES = {}
"""More cures of cautions, {rule: [(facts, what it is about) -> text, such as ", or key = value"]}, of components."""


def cure(name):
    """Mark a function as one more cure that the rule of this name offers."""
    def marked(function):
        CURES.setdefault(name, []).append(function)
        return function
    return marked


def rule(*methods):
    """Mark a generator of cautions about scenes of these methods."""
    def marked(function):
        for method in methods:
            RULES[method].append(function)
        return function
    return marked


def beyond(entry, setting, value):
    """The border of an entry with a setting when `value` lies on its failing side, else None."""
    border = shipped()[entry, setting]
    return border if border.failing(value) else None


def worded(border, key, value, what=None):
    """A caution with the standard text: `what` has this value, beyond the border."""
    unit = f" {border.unit}" if border.unit else ""
    limit = f"{border.value:.3g}{unit}" if border.value is not None else "any"
    side = "over" if border.fails == "above" else "under"
    says = f"{what or border.parameter} {value:.3g}{unit} is {side} {limit}: {border.in_a_sentence}"
    return Caution(border.entry, key, says, border.cure)


def rounded_down(length):
    """A length rounded down to two digits."""
    unit = 10.0 ** (math.floor(math.log10(length)) - 1)
    return float(f"{math.floor(length / unit) * unit:.3g}")
