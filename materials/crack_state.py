"""What is kept of the cracks of a particle, beside the state of the law around them, and what is told of it.

In order: PER_CRACK numbers for each crack that may be there (`crack_planes`), how many made way for new ones where they
may, the state of the law around them.
"""

from typing import TYPE_CHECKING

from .arrays import Array
from .crack_planes import DAMAGE, NORMAL, OPENING, PER_CRACK
from .law import StateVariable
from .symmetric import COMPONENTS

if TYPE_CHECKING:
    from .cohesive_crack import CohesiveCrack


def _of_crack(number: str, which: str) -> tuple[StateVariable, ...]:
    """State of a crack; number: "" or "_2", after the names."""
    return (
        StateVariable(f"crack_damage{number}", "-", f"ω: share of the cohesion that {which} crack has lost"),
        StateVariable(f"crack_opening{number}", "m", f"w: normal jump of {which} crack"),
        *(StateVariable(f"crack_normal{number}_{c}", "-", f"{c} of n ⊗ n, n the normal of {which} crack; zero without"
                        " one") for c in COMPONENTS),
    )  # fmt: skip


FIRST, SECOND = _of_crack("", "the"), _of_crack("_2", "the second")
RESETS = StateVariable("crack_resets", "-", "how many cracks lost all cohesion and made way for new ones")
OWN_OUTPUTS = {"damage": "-", "crack_opening": "m", "cracks": "-"}


def variables(law: "CohesiveCrack") -> tuple[StateVariable, ...]:
    """`Law.STATE` of a law."""
    own = FIRST + (SECOND if law.cracks == 2 else ()) + ((RESETS,) if law.reset else ())
    return own + (law.bulk.STATE if law.bulk else ())


def tensors(law: "CohesiveCrack") -> tuple[int, ...]:
    """`Law.TENSORS` of a law."""
    own = tuple(PER_CRACK * c + NORMAL for c in range(law.cracks))
    return own + tuple(law.first_of_bulk + first for first in (law.bulk.TENSORS if law.bulk else ()))


def outputs(law: "CohesiveCrack") -> dict[str, str]:
    """`Law.OUTPUTS` of a law."""
    return {**(law.bulk.OUTPUTS if law.bulk else {}), **OWN_OUTPUTS}


def output_fields(law: "CohesiveCrack", state: Array) -> dict[str, Array]:
    """`Law.outputs` of states (..., n_state)."""
    rows = state[..., : PER_CRACK * law.cracks].reshape(*state.shape[:-1], law.cracks, PER_CRACK)
    begun = (rows[..., NORMAL : NORMAL + 3].sum(axis=-1) > 0.5).sum(axis=-1)
    before = state[..., law.first_of_bulk - 1] if law.reset else 0.0
    of_bulk = law.bulk.outputs(state[..., law.first_of_bulk :]) if law.bulk else {}
    return {**of_bulk, "damage": rows[..., DAMAGE].max(axis=-1), "crack_opening": rows[..., OPENING].max(axis=-1),
            "cracks": begun + before}  # fmt: skip
