"""Rules: sums over neighbours, for method "sph"."""

import math

from snowmpm.advice.cautions.caution import beyond, rule, worded


@rule("sph")
def sph_pairing(facts):
    """Particles that pair under compression, with this kernel and this many neighbours."""
    chosen = facts.scene.solver.sph
    if border := beyond("sph_pairing", chosen.kernel.replace("_", " "), chosen.smoothing):
        yield worded(border, "solver.sph.kernel", chosen.smoothing)


@rule("sph")
def sph_free_surface(facts):
    """Stresses at a free surface with uncorrected gradients."""
    chosen = facts.scene.solver.sph
    if chosen.gradient != "plain":
        return
    if border := beyond("sph_free_surface", f"plain {_measured(chosen.smoothing):g}", 0.5):
        yield worded(border, "solver.sph.gradient", 0.5)


@rule("sph")
def sph_tensile(facts):
    """Materials that bear tension, without artificial stress: by the tensile strength, or by the load if the strength
    is unlimited."""
    chosen = facts.scene.solver.sph
    if chosen.disorder_damping > 0.0 or chosen.artificial_stress > 0.0:
        return
    for name, law in zip(facts.scene.materials, facts.model.laws, strict=True):
        strength = law.tensile_strength
        pulled = strength / (law.density * law.wave_speed() ** 2) if strength < math.inf else facts.least_strain
        if border := beyond("sph_tensile", "wendland c6 1.5", pulled):
            yield worded(border, f"materials.{name}", pulled)


@rule("sph")
def sph_wall(facts):
    """Fast particles that may penetrate a wall without a barrier force."""
    if facts.scene.solver.sph.barrier:
        return
    speed = max(facts.start_speed, facts.fall_speed) / facts.wave_speed
    if border := beyond("sph_wall", "mirrored", speed):
        yield worded(border, "solver.sph.barrier", speed)


@rule("sph")
def sph_layers(facts):
    """Touching bodies of unlike density, with sums that weight stresses by density: the pair that differs most."""
    chosen = facts.scene.solver.sph
    if chosen.momentum not in ("density", "corrected"):
        return
    densities = [sorted(facts.law(body).density for body in (pair.first, pair.second))
                 for pair in facts.pairs if pair.distance == 0]
    contrast = max((heavy / light for light, heavy in densities), default=1.0)
    if border := beyond("sph_layers", f"density {_measured(chosen.smoothing):g}", contrast):
        yield worded(border, "solver.sph.momentum", contrast)


def _measured(smoothing):
    """The nearest smoothing length of the atlas."""
    return min((1.2, 1.5, 2.0), key=lambda h: abs(h - smoothing))
