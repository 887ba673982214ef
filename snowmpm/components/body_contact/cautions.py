"""Rule: bodies that meet."""

import numpy as np

from snowmpm.advice.cautions.caution import beyond, rule, worded


@rule("mpm")
def early_contact(facts):
    """Separate bodies that may collide: they interact about a cell too early."""
    for pair in facts.pairs:
        first, second = (facts.scene.bodies[body] for body in (pair.first, pair.second))
        differ = np.linalg.norm(np.subtract(first.velocity, second.velocity)) > 1e-3 * facts.wave_speed
        if pair.distance == 0 and not differ:
            continue
        setting = ("separate" if pair.separate else "shared") + (" cubic" * (facts.scene.solver.kernel == "cubic"))
        if not pair.separate and (border := beyond("early_contact", setting, float(pair.distance))):
            yield worded(border, f"bodies ({first.name} and {second.name})", float(pair.distance))
