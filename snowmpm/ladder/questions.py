"""What can be asked of a scene: a closed list, each with the one definition of its answer."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from snowmpm import components
from snowmpm.errors import InputError

FLOW, SAW, RELEASE, STRENGTH, REST = "flow", "saw test", "release", "strength", "rest"
SLIDES = 0.2
"""Speed of a slab that has released, over sqrt(g h)."""


@dataclass(frozen=True)
class Question:
    """name: on the command line; label, unit: in words; group: of questions that the same models answer; says: the
    definition of the answer; yes_no: whether the answer is 1 or 0."""

    name: str
    label: str
    unit: str
    group: str
    says: str
    yes_no: bool = False


QUESTIONS = {one.name: one for one in (
    Question("run-out", "run-out", "m", FLOW, "Length in plan from the top of the release to the furthest corner of the"
             " affected area, along the thalweg (reach_of_flow); in profile, from the highest place that moving snow"
             " has left to the front (front_distance)."),
    Question("affected-area", "affected area", "m2", FLOW, "Plan area where the flow was at least a tenth of the mean"
             " release depth deep (affected_area)."),
    Question("peak-pressure", "peak pressure at the place", "Pa", FLOW, "Largest density times speed squared over the"
             " map cell that holds the place (peak_pressure)."),
    Question("load", "load on the obstacle", "N", FLOW, "Early peak of the force on an obstacle along its load"
             " (impact_peak_force); of all obstacles together by default. Per metre of width in profile."),
    Question("deposit-volume", "deposit volume", "m3", FLOW, "Volume of the snow in the domain at the end, at the"
             " density of the release (deposit_volume)."),
    Question("critical-length", "critical cut length", "m", SAW, "Length of the cut when the crack begins to run by"
             " itself (saw_critical_length)."),
    Question("crack-speed", "crack speed", "m/s", SAW, "Median speed of the crack that runs by itself"
             " (saw_crack_speed)."),
    Question("release", "whether the slab releases", "1", RELEASE, f"Yes, if the root mean square speed of the snow"
             f" exceeds {SLIDES:g} sqrt(g h) before the end, h its depth at the start.", yes_no=True),
    Question("factor-of-safety", "factor of safety", "1", STRENGTH, "Least number by which the strength of the slope"
             " can be divided so that it slides (`snowmpm strength`)."),
    Question("settlement", "settlement", "m", REST, "Fall of the centre of mass of the snow from the start to the end"
             " of the run."),
)}


@dataclass(frozen=True)
class Ask:
    """A question about a scene. place (2,) [m]: in map coordinates, of peak-pressure; obstacle: name, all by default;
    path: function (`ReferenceSystem` of the terrain, or None) -> (k, 2) [m], for models along a path; the way of most
    snow by default."""

    question: Question
    place: Any = None
    obstacle: str | None = None
    path: Any = None

    @classmethod
    def of(cls, scene, name, place=None, obstacle=None, path=None):
        """Of a scene. Raises InputError for a question that there is none of, or that the scene cannot answer."""
        if name not in QUESTIONS:
            raise InputError.not_in("--question", name, QUESTIONS)
        if why := unanswerable(scene, name):
            raise InputError.at("--question", name, why, scene.source)
        if (name == "peak-pressure") != (place is not None):
            raise InputError("--question peak-pressure and --at X,Y go together: the place, in map coordinates")
        if obstacle is not None and (name != "load" or obstacle not in (names := [o.name for o in scene.obstacles])):
            raise InputError("--obstacle goes with --question load" if name != "load" else
                             f"--obstacle {obstacle}: must be one of {', '.join(names)}")
        question = QUESTIONS[name]
        if name == "load" and scene.dimension == 2:
            question = replace(question, unit="N/m")
        return cls(question, None if place is None else np.asarray(place, float), obstacle, path)


def unanswerable(scene, name):
    """Why a scene cannot answer a question, in words; empty where it can."""
    group = QUESTIONS[name].group
    if (group == SAW) != bool(scene.saw_test):
        return "needs a scene with [saw_test]" if group == SAW else (
            "a saw test answers critical-length and crack-speed")
    if name in ("affected-area", "peak-pressure", "deposit-volume") and not (
            scene.dimension == 3 and scene.terrain is not None):
        return "needs a scene in three dimensions on a terrain, which has maps"
    if name == "load" and not scene.obstacles:
        return "needs an obstacle"
    if not np.any(scene.gravity_vector):
        return "needs gravity"
    if group in (RELEASE, STRENGTH) and scene.solver.method == "depth":
        return "a depth-averaged scene flows from the start: it has no strength"
    return ""


def usual_question(scene):
    """Name of what a scene is asked first, by what it has; None of one that none of the questions is for: a test of a
    material without weight, something that swings, bodies and structures that move."""
    swings = scene.solver.method != "depth" and all(law.kind == "elastic" for law in scene.materials.values())
    if swings or not np.any(scene.gravity_vector) or any(component.solid for component in components.used(scene)):
        return None
    if scene.saw_test:
        return "critical-length"
    if scene.reference is not None and scene.reference.kind == "slope_stability":
        return "factor-of-safety"
    if scene.obstacles and not any(one.motion for one in scene.obstacles):
        return "load"
    if any(event.kind in ("cut", "load") for event in scene.events):
        return "release"
    return "settlement" if scene.forces else "run-out"
