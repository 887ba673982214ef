"""Theories that are evaluated when a run is read, not during the run."""

import tempfile
from pathlib import Path

from snowmpm.errors import InputError
from snowmpm.saw_test import weac


def further_theories(run):
    """{name: value} for a `snowmpm.io.Run` of a saw test, in addition to its summary and to what its file said from the
    start, as far as available."""
    from snowmpm.scenes import load_scene

    said = run.summary.get("saw_test", {}).get("theory") or run.saw_test.about.get("theory", {})
    energy = said.get("fracture_energy")
    if not energy:
        return {}
    try:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.toml"
            path.write_text(run.provenance["scene"], encoding="utf-8")
            length = weac.critical_length(load_scene(path), energy)
    except (InputError, KeyError):  # of another version: the run itself is still readable
        return {}
    return {"critical_length_weac": length} if length else {}
