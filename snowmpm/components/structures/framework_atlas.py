"""Entries: frameworks of members that meet in joints."""

import numpy as np

from snowmpm.components.structures.framework import Framework
from snowmpm.components.structures.framework_mesh import Member
from snowmpm.components.structures.mast_atlas import FOOT, HEIGHT, energies_after
from snowmpm.components.structures.section import Section
from snowmpm.study.atlas.entry import Entry

BAR = Section.tube(0.06, 0.01, 2e9, 1000.0)
DEFLECTED = 1e-4
"""Of a member in `bent`, in its middle, over its length: so little that it does not act as a rope."""


def bent(elements, pinned):
    """Error of the moment at the first end of a member of 1 m under an even load, against a beam: q L^2 / 12, or
    q L^2 / 8 where the last end is pinned."""
    n = round(elements)
    one = Framework({"a": (0.0, 0.0, 0.0), "b": (0.0, 0.0, 1.0)}, {"a": "fixed", "b": "pinned" if pinned else "fixed"},
                    [Member("a", "b", BAR, n)], damping=1.0, plane=True)
    if n == 1:
        return 1.0  # all of the load is on the ends
    q = 384.0 * BAR.bending * DEFLECTED
    forces = np.zeros_like(one.x)
    forces[2:, 0] = q / n
    one.advance(8.0 * 2.0 * np.pi / one.modes.first, forces)
    return abs(one.moments[0, 0, 1]) / (q / (8.0 if pinned else 12.0)) - 1.0


def braced(ratio, coupling, contact):
    """Largest energy as in `.mast_atlas.struck`, for a post that a strut holds from behind."""
    return max(energies_after(ratio, coupling, contact, {
        "joints": {"a": [FOOT, 0.0], "b": [FOOT, HEIGHT], "c": [FOOT + HEIGHT, 0.0]},
        "feet": {"a": "fixed", "c": "pinned"},
        "members": [{"ends": ["a", "b"], "segments": 4}, {"ends": ["c", "b"], "pinned": ["b"], "segments": 2}]}))


ENTRIES = (
    Entry(
        name="few_elements", title="Members of few elements", scene="A member at rest under an even load across it",
        seen="The load goes to the ends of the elements in shares: the moments at the ends of a member come out too"
             " small by 1 / n^2, and none at all for one element", cure="more segments of this member",
        parameter="elements of a member", unit="", values=(1, 2, 3, 4, 5, 6, 8, 12), fails="below",
        settings={"both ends fixed": {"pinned": False}, "one end pinned": {"pinned": True}},
        symptom="error of the moment at a fixed end", limit=0.1, measure=bent, shown="both ends fixed"),
    Entry(
        name="light_framework", title="A braced post that the snow sticks to",
        scene="An elastic block that is thrown at a post with a strut behind it",
        seen="With weak coupling the post is thrown back by more than the snow came with, as a mast is"
             " (light_structure): the strut does not help. Snow that may leave does no harm",
        cure='contact = "separate", or coupling = "strong"',
        parameter="mass of the snow in the cells around it over its own", unit="",
        values=(0.05, 0.1, 0.2, 0.35, 0.5, 1.0),
        settings={"weak, stick": {"coupling": "weak", "contact": "stick"},
                  "weak, separate": {"coupling": "weak", "contact": "separate"},
                  "strong, stick": {"coupling": "strong", "contact": "stick"}}, symptom="largest energy gained",
        limit=0.05, measure=braced, shown="weak, stick", cured="strong, stick", resolution=0.1),
)
