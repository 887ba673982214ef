"""Entries: drag between water and a skeleton with a velocity each."""

import numpy as np

from snowmpm.study.atlas.entry import Entry
from snowmpm.water.drag import relaxed


def slip_left(size, way):
    """Slip of water and skeleton after 50 steps of drag alone, over its start; size: dt times drag (1 / m_s + 1 /
    m_w)."""
    v, w = np.zeros(1), np.ones(1)
    for _ in range(50):
        if way == "exact":
            v, w = relaxed(v, w, np.zeros(1), np.zeros(1), (np.ones(1), np.ones(1)), np.full(1, 0.5), size)
        else:
            pull = 0.5 * size * (w - v)
            v, w = v + pull, w - pull
    return float(np.abs(w - v)[0])


ATLAS = {"water in the pores": (
    Entry(
        name="stiff_drag", title="Drag between water and skeleton that is stiff for a step",
        scene="Water that moves against a skeleton, with nothing but drag between them",
        seen="A step beyond twice the time of the drag, 1e-4 s in wet sand, lets the slip change its sign and grow",
        cure="drag that is integrated exactly, as the program does", parameter="dt over the time of the drag", unit="",
        values=(0.5, 1.0, 1.5, 1.9, 2.5, 10.0, 1000.0),
        settings={"explicit": {"way": "explicit"}, "exact": {"way": "exact"}}, symptom="slip over its start", limit=1.0,
        measure=slip_left, shown="explicit", cured="exact"),
)}
