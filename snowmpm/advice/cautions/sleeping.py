"""Rule: snow that may sleep although it has begun to move."""

from snowmpm.advice.cautions.caution import beyond, rule, worded


@rule("mpm")
def slow_start(facts):
    """Snow that accelerates slowly stays below the speed that counts as calm."""
    tolerance = facts.scene.solver.sleeping
    if tolerance > 0.0 and (border := beyond("slow_start", "pulled by 0.02 g", tolerance)):
        yield worded(border, "solver.sleeping", tolerance)
