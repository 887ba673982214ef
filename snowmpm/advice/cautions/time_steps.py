"""Rules: fixed time steps, and strains too large for one step."""

from snowmpm.advice.cautions.caution import beyond, rule, worded


@rule("mpm")
def fixed_steps(facts):
    """Limits that an adaptive step would respect."""
    dt = facts.scene.solver.dt
    if dt is None:
        return
    speed = max(facts.start_speed, facts.fall_speed)
    if border := beyond("crossing_step", facts.kernel, speed * dt / facts.dx):
        yield worded(border, "solver.dt", speed * dt / facts.dx, "at the speed of a fall,")
    share = dt / facts.solver.critical_dt()[0]
    setting = "elastic step 0.8" if share > 0.5 else "elastic step 0.4"
    if border := beyond("fast_impact", setting, speed / facts.wave_speed):
        yield worded(border, "solver.dt", speed / facts.wave_speed)


@rule("mpm", "sph")
def apex(facts):
    """Return maps whose error grows with the strain of a step, at the fastest motion at the start."""
    strain = facts.start_speed / facts.wave_speed * facts.solver.limits.cfl
    for name, law in zip(facts.scene.materials, facts.model.laws, strict=True):
        if law.integration == "frozen" and (border := beyond("apex", "cap, frozen", strain)):
            yield worded(border, f"materials.{name}.return_map", strain)
