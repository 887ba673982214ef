"""Rules: bodies whose mass at the start is not that of their volume."""

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.methods import METHODS
from snowmpm.setup.mass_at_start import mass_doubts


@rule(*METHODS)
def doubtful_mass(facts):
    """Bodies that share a place, or lie below the ground."""
    if facts.begin == 0.0:
        for doubt in mass_doubts(facts.model):
            yield Caution("", doubt.key, doubt.says, doubt.cure)
