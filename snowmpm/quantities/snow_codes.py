"""Codes of grain forms and hand hardness (Fierz et al. 2009), as files have them."""

import re

CLASSES = {"PP": "precipitation particles", "MM": "machine made snow", "DF": "decomposing and fragmented particles",
           "RG": "rounded grains", "FC": "faceted crystals", "DH": "depth hoar", "SH": "surface hoar",
           "MF": "melt forms", "IF": "ice formations"}
PERSISTENT = ("FC", "DH", "SH")
"""Main classes whose layers stay weak for weeks."""
SWISS = {"1": "PP", "2": "DF", "3": "RG", "4": "FC", "5": "DH", "6": "SH", "7": "MF", "8": "IF", "9": "FCxr",
         "0": "PPgp"}
"""Digits of SNOWPACK's code F1F2F3."""
STEPS = {"F": 1.0, "4F": 2.0, "1F": 3.0, "P": 4.0, "K": 5.0, "I": 6.0}
HARDNESS = re.compile(r"(F|4F|1F|P|K|I)([+-]?)")
THIRD = 1.0 / 3.0
"""What + and - add and take."""


def main_class(form: str) -> str:
    """First two letters of a form, where they are a main class; "" otherwise."""
    return form[:2].upper() if form[:2].upper() in CLASSES else ""


def is_crust(form: str) -> bool:
    """Whether it is a crust or ice."""
    return form.lower() == "mfcr" or main_class(form) == "IF"


def words(form: str) -> str:
    """Of a form, for reading."""
    special = {"MFcr": "melt-freeze crust", "PPgp": "graupel", "FCxr": "rounding faceted particles",
               "RGxf": "faceted rounded particles", "FCsf": "near-surface faceted particles", "RGwp": "wind packed"}
    return special.get(form) or CLASSES.get(main_class(form), form or "not observed")


def hardness_index(text: str) -> float | None:
    """Of "4F+", "P-", "F-4F" (its middle) or a number; None for anything else."""
    text = text.strip().replace(" ", "")
    if found := HARDNESS.fullmatch(text.upper()):
        return STEPS[found[1]] + {"+": THIRD, "-": -THIRD, "": 0.0}[found[2]]
    parts = re.fullmatch(r"((?:F|4F|1F|P|K|I)\+?)-((?:F|4F|1F|P|K|I)[+-]?)", text.upper())
    if parts:
        return 0.5 * (hardness_index(parts[1]) + hardness_index(parts[2]))
    try:
        return float(text)
    except ValueError:
        return None


def hardness_code(index: float) -> str:
    """The code nearest to an index."""
    step = min(STEPS, key=lambda name: abs(STEPS[name] - index))
    rest = index - STEPS[step]
    return step + ("+" if rest > 0.5 * THIRD else "-" if rest < -0.5 * THIRD else "")


def of_swiss(code: int) -> str:
    """Form of SNOWPACK's three digits: the first is the main form; 7 with a 2 at its end is a crust."""
    digits = f"{code:03d}"
    if digits[0] == "7" and digits[2] == "2":
        return "MFcr"
    return SWISS[digits[0]]
