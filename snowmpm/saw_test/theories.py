"""Theories that are worked out when a run is looked at, not while it goes on."""

import tempfile
from pathlib import Path

from snowmpm.errors import InputError
from snowmpm.saw_test import weac


def further_theories(run):
    """{name: value} of a `snowmpm.io.Run` of a saw test, beside what its summary holds; what there is of it."""
    from snowmpm.scenes import load_scene

    energy = run.summary.get("saw_test", {}).get("theory", {}).get("fracture_energy")
    if not energy:
        return {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.toml"
            path.write_text(run.provenance["scene"], encoding="utf-8")
            length = weac.critical_length(load_scene(path), energy)
    except (InputError, KeyError):  # of another version: the run itself can be looked at all the same
        return {}
    return {"critical_length_weac": length} if length else {}
