"""The unit that a mesh file says its coordinates are in: a remark, as none of the formats has a field for it."""

import re

from snowmpm.errors import InputError
from snowmpm.terrain.map_units import METRES

HEAD_BYTES = 4096
"""Beginning of a file in which its remarks are looked for."""

REMARKS = {".stl": rb"\A(.{80})", ".obj": rb"(?m)^#(.*)$", ".ply": rb"(?m)^(?:comment|obj_info)\s(.*)$"}
"""Where each format has them: in its first 80 bytes, behind #, behind `comment`."""

NAMED = re.compile(rb"\bunits?\s*[:=]\s*[\"']?([a-z_][a-z_ -]{0,24})", re.IGNORECASE)
SAID = re.compile(rb"\bunits? (?:are |is |in )+([a-z_][a-z_ -]{3,24})", re.IGNORECASE)
"""`units = mm`, which must be a length, and `units are in metres`, which counts where it is one."""


def metre_of_mesh(path, suffix):
    """Metres in the unit that a mesh file names, as `UNITS=mm` or `# File units = feet`; 1 where it names none.

    InputError: a unit that is no length.
    """
    if suffix not in REMARKS:
        return 1.0
    with open(path, "rb") as file:
        head = file.read(HEAD_BYTES)
    for remark in re.findall(REMARKS[suffix], head, re.DOTALL if suffix == ".stl" else 0):
        named = NAMED.search(remark)
        found = named or SAID.search(remark)
        words = found[1].decode("ascii").lower().split() if found else []
        lengths = [METRES[text] for n in range(len(words), 0, -1) if (text := " ".join(words[:n])) in METRES]
        if lengths:
            return lengths[0]
        if named and words[0] not in ("unknown", "none", "unitless", "undefined"):
            raise InputError(f"{path}: says that its unit is {' '.join(words)!r}: must be a length, as m, mm or ft")
    return 1.0
