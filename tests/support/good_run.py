"""A run file with something of everything in it, and a journal beside it."""

import json
import struct
import zlib

import numpy as np

from snowmpm.io import RunWriter
from snowmpm.io.journal import HEADER, MAGIC

PROFILE = ("x", "y", "z", "s", "peak_depth", "peak_speed", "peak_pressure", "deposit_depth")


def good_run(folder, dimension=3):
    """A run with something of everything in it."""
    rng = np.random.default_rng(1)
    square = np.array([[0.0, 0, 0], [4, 0, 0], [4, 4, 1], [0, 4, 1]]), np.array([[0, 1, 2], [0, 2, 3]])
    record = {"scene": 'name = "good"\n', "scene_name": "good", "version": "1", "materials": ["snow"], "dx": 0.2,
              "particle_spacing": 0.1, "bodies": ["slab"], "backend": "cpu"}
    with RunWriter(folder, provenance=record, terrain=square, obstacles={"wall": square}, dimension=dimension,
                   durable=False) as writer:
        for i in range(3):
            points = rng.random((300, 3)) * 3.0
            writer.history(0.1 * i, {"mass": 2.0, "max_speed": 1.0 * i, "front": 0.1 * i}, {"mass": "kg"})
            loads = {"time": np.array([0.1 * i]), "force": np.ones((1, 3)), "moment": np.ones((1, 3)),
                     "impulse": np.ones((1, 3)) * i, "work": np.ones(1)}
            writer.frame(0.1 * i, points, {"velocity": points, "density": points[:, 0]}, loads={"wall": loads})
        writer.map("peak_depth", rng.random((20, 20)), 0.0, 0.0, 0.2, "m")
        writer.hazard({"numbers": {"runout": 1.0, "travel_angle": 20.0, "flow_depth": 0.1, "top": 2.0, "fall": 1.0},
                       "profile": {name: [0.0, 1.0, 2.0] for name in PROFILE},
                       "runout_line": [[0.0, 0.0], [1.0, 1.0]]})
    (folder / "summary.json").write_text(json.dumps({"wall_time": 1.0, "steps": 3, "last": {"mass": 2.0}}))
    return folder


def journal(payload, counter=1, length=None):
    head = HEADER.pack(MAGIC, counter, len(payload) if length is None else length, zlib.crc32(payload), 0)[:-4]
    return head + struct.pack("<I", zlib.crc32(head)) + payload
