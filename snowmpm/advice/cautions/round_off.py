"""Rules: positions and strains that single precision cannot resolve."""

from pathlib import Path

import numpy as np

from snowmpm.advice.cautions.caution import beyond, rule, worded


@rule("mpm", "sph")
def far_from_origin(facts):
    """Meshes whose vertices are stored in float32."""
    named = [("terrain.file", facts.scene.terrain)]
    named += [(f"obstacles.{i}.shape.file", obstacle.shape) for i, obstacle in enumerate(facts.scene.obstacles)]
    for key, spec in named:
        if spec is None or spec.kind != "mesh" or not _is_binary_stl(facts.scene.base_dir / spec.file):
            continue
        farthest = max(np.abs(facts.model.lower).max(), np.abs(facts.model.upper).max()) / facts.dx
        if border := beyond("far_from_origin", "binary STL", farthest):
            yield worded(border, key, farthest)


def _is_binary_stl(path):
    path = Path(path).expanduser()
    if path.suffix.lower() != ".stl":
        return False
    with open(path, "rb") as file:
        return not file.read(6).lower().startswith(b"solid ")


@rule("mpm")
def small_strains(facts):
    """Strains too small for the precision."""
    if facts.least_strain > 0.0:
        precision = facts.scene.solver.precision
        if border := beyond("small_strains", precision, facts.least_strain):
            yield worded(border, "solver.precision", facts.least_strain)
