"""Rules: what a scene asks for and can never happen, and dams where the snow lies at the start."""

import math

from snowmpm.advice.cautions.caution import Caution, rule
from snowmpm.handover.moment import Moment
from snowmpm.methods import METHODS
from snowmpm.running.fall import fall_speed
from snowmpm.scenes.switch import FLOWING, REACHED

LEAST_SHARE = 0.01
"""Share of the snow on a dam that is told."""


@rule(*METHODS)
def switch_that_never_comes(facts):
    """A hand-over after the end, at a speed that no fall reaches, or where no snow comes."""
    scene, model = facts.scene, facts.model
    if facts.begin > 0.0:
        return
    for i, switch in enumerate(scene.switch):
        why = ""
        if switch.time is not None and switch.time >= scene.end_time:
            why = f"the scene ends at {scene.end_time:g} s"
        elif switch.when == FLOWING and switch.speed > (fastest := fall_speed(model)):
            why = f"a fall over all of the ground gives {fastest:.3g} m/s, and speed is {switch.speed:g} m/s"
        elif switch.when == REACHED and _out_of_reach(model, switch, f"switch.{i}"):
            why = "its region lies outside the domain"
        if why:
            yield Caution("", f"switch.{i}.when", f"never comes: {why}", "put it right, or leave the switch out")


@rule(*METHODS)
def begins_after_the_end(facts):
    """What begins when the scene has ended."""
    scene = facts.scene
    if facts.begin > 0.0:
        return
    for table, items in (("events", scene.events), ("forces", scene.forces)):
        for i, one in enumerate(items):
            begin = max(one.get("start") or 0.0, one.get("time") or 0.0)
            if begin >= scene.end_time:
                yield Caution("", f"{table}.{i} ({one.kind})", f"never comes: it begins at {begin:g} s, and the scene"
                              f" ends at {scene.end_time:g} s", "put it right, or leave it out")


def _out_of_reach(model, switch, key):
    moment = Moment(switch, model.surface, model.scene.base_dir, key)
    return moment.outside(model.lower, model.upper)


@rule(*METHODS)
def dam_on_the_release(facts):
    """A dam whose foot reaches under the snow at the start, which then lies on it."""
    import shapely

    terrain, snow = facts.scene.terrain, facts.model.population
    if facts.begin > 0.0 or terrain is None or facts.dim != 3:
        return
    for i, dam in enumerate(terrain.get("dams", ())):
        foot = 0.5 * dam.crest_width + dam.height / math.tan(math.radians(dam.slope))
        far = shapely.distance(shapely.points(snow.positions[:, :2]), shapely.LineString(dam.line))
        share = float(snow.volumes[far < foot].sum() / snow.volumes.sum())
        if share > LEAST_SHARE:
            yield Caution("", f"terrain.dams.{i} ({dam.name})", f"its foot lies under {share:.0%} of the snow at the"
                          " start: snow on it is lifted, and slides off", "move the dam, or cut the release there")
