"""An observed avalanche computed in every way, and how near each came: a campaign of scenarios, and one table."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from snowmpm.campaigns import scenarios
from snowmpm.campaigns.spec import CampaignFile
from snowmpm.draft import write_table
from snowmpm.errors import InputError, shown_line
from snowmpm.events import store
from snowmpm.events.page import facts, place_of
from snowmpm.events.scoring import Observation, observed_reach, score_run
from snowmpm.events.ways import ways
from snowmpm.io import Run
from snowmpm.io.status import status_of
from snowmpm.quantities.scores import MISFIT, SCORES, VALUE
from snowmpm.quantities.table import quantity
from snowmpm.render.document import Document, Listing, Note, Paragraph, Picture, Section, Table
from snowmpm.render.outline_map import render_outlines
from snowmpm.render.page import page_of, write_page
from snowmpm.runout.ground import ground_of
from snowmpm.runout.models import on_ground, runout
from snowmpm.scenes import load_scene
from snowmpm.scenes.friction_cards import friction_card, friction_cards, law_for_volume

FILES = ("scores.csv", "event.html", "pictures/event.png", "models.csv")
LONGEST = 60
"""Characters of a way's name."""
DRAWN = 6
"""Outlines on the map: those of the lowest misfit."""


@dataclass(frozen=True)
class Scored:
    """way: its name; run; numbers: by name of `snowmpm.quantities.scores`; default: whether it is that of the scene."""

    way: str
    run: Run
    numbers: dict[str, Any]
    default: bool


def event_file(name, only=(), changes=None):
    """`CampaignFile` of all ways to compute an event, or of those whose names contain one of the words; changes: of the
    scene, one more way. InputError, also for observations that cannot be read."""
    known = ways(name)
    Observation.of(name)
    for word in only:
        if not any(word in way for way in known):
            raise InputError.not_in("--only", word, known)
    default = next(iter(known))
    chosen = {way: own for way, own in known.items()
              if not only or way == default or any(word in way for word in only)}
    if changes:
        words = ", ".join(f"{key.rpartition('.')[2]} {_words(value)}" for key, value in changes.items())
        chosen[shown_line(f"set: {words}", LONGEST)] = changes
    data = {"name": f"event_{name}", "scene": store.PREFIX + name, "design": "grid",
            "parameters": {"way": {"distribution": "scenarios", "sets": chosen}}}
    return CampaignFile.checked(data, f"event:{name}", store.kept(name))


def _words(value):
    """A value of a setting in short."""
    if isinstance(value, dict):
        return ", ".join(f"{name} {_words(one)}" for name, one in value.items())
    return str(value)


def score_event(name, campaign):
    """[`Scored`] of the runs of a `Campaign` that are done, in its order, and the `Observation`."""
    found = [(way, run, *score_run(run, name)) for way, run in scenarios.done(campaign, None)]
    default = next(iter(ways(name)))
    return [Scored(way, run, numbers, way == default) for way, run, numbers, _ in found], found[0][-1]


def best(found):
    """The `Scored` of the lowest misfit."""
    return min(found, key=lambda one: one.numbers["misfit"])


def names(found):
    """Names of the numbers that some of them have, in order."""
    known = [one.name for one in SCORES]
    held = {name for one in found for name in one.numbers} - {"runout_beyond"}
    return [*(name for name in known if name in held), *sorted(held - set(known))]


def _quantity(name):
    return next((one for one in SCORES if one.name == name), VALUE)


def label(name, event):
    """What a number is called: of a measured value, where and how."""
    if not name.startswith("value_error_"):
        return _quantity(name).label
    one = event.observed.values[int(name.rpartition("_")[2])]
    return f"{quantity(one.map).label} {place_of(one)} less measured, in deviations"


def _text(name, numbers):
    value = numbers.get(name)
    beyond = ">= " if name == "runout_error" and numbers.get("runout_beyond") else ""
    return "-" if value is None else f"{beyond}{_quantity(name).text(value)}"


def lines(found, event):
    """The scores as a table for reading: a row a way, from the lowest misfit."""
    columns, leader = names(found), best(found)
    rows = [["", *(label(name, event) for name in columns), "final"]]
    for one in sorted(found, key=lambda one: one.numbers["misfit"]):
        marks = [word for word, holds in (("best", one is leader), ("default", one.default)) if holds]
        rows.append([f"{one.way} [{', '.join(marks)}]" if marks else one.way,
                     *(_text(name, one.numbers) for name in columns),
                     "yes" if status_of(one.run).final else "no"])
    heads = [_two(head) for head in rows[0]]
    rows = [[head[0] for head in heads], [head[1] for head in heads], *rows[1:]]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]).rstrip() for row in rows]


def _two(text):
    """A heading on two lines."""
    words = text.split()
    half = min(range(len(words) + 1), key=lambda k: max(len(" ".join(words[:k])), len(" ".join(words[k:]))))
    return " ".join(words[:half]), " ".join(words[half:])


@dataclass(frozen=True)
class WithoutFlow:
    """Run-out of the models without a flow (`snowmpm.runout`) along the path of an event, less the observed one.

    errors: [m] by model, None beyond the end of the path; doubts: in words.
    """

    errors: dict[str, float | None]
    doubts: list[str]

    @property
    def lines(self):
        """As a table for reading."""
        width = max(map(len, self.errors), default=0)
        return ["models without a flow, run-out less observed",
                *(f"{model:<{width}}  {'beyond the path' if error is None else f'{error:+.0f} m':>15}"
                  for model, error in self.errors.items()),
                *(f"warning: {doubt}" for doubt in self.doubts)]


def without_flow(name, observation):
    """`WithoutFlow` of an event; None where no run-out was observed. Taichi runs."""
    far = observed_reach(observation)
    if far is None:
        return None
    ground = ground_of(load_scene(store.PREFIX + name))
    line = on_ground(ground, np.array(observation.event.observed.path))
    if len(line) < 2:
        return None
    found = runout(ground, line, f"{store.PREFIX}{name}: observed.path")
    # The longest way of routing is no length along the path
    return WithoutFlow({one.model: None if one.s is None else one.s - far for one in found.reaches
                        if "longest way" not in one.model and not one.note.startswith("needs")}, found.doubts)


def write_models(models, path):
    """Write the run-outs of `WithoutFlow` as CSV; -> the path."""
    return write_table(path, ["model", "runout_error"], [
        [model, "" if error is None else f"{error:.1f}"] for model, error in models.errors.items()])


def write_scores(found, path):
    """Write the scores as CSV, a row a way; -> the path."""
    columns = names(found)
    return write_table(path, ["way", *columns, "runout_beyond", "final", "statement", "class"], [
        [one.way, *("" if one.numbers.get(name) is None else f"{one.numbers[name]:.6g}" for name in columns),
         "yes" if one.numbers.get("runout_beyond") else "no",
         "yes" if status_of(one.run).final else "no", status_of(one.run).text, doubts(one.run)] for one in found])


def doubts(run):
    """Why the class of friction of a run does not hold for it, "" where nothing is known against it."""
    card = run.scene.get("terrain", {}).get("friction", {})
    card = card.get("card") if isinstance(card, dict) else None
    numbers = run.hazard.get("numbers", {})
    volume = numbers.get("release_volume")
    if card not in friction_cards() or volume is None:
        return ""
    found = friction_card(law_for_volume(friction_card(card), volume).card)  # of a card with classes: by the volume
    return "; ".join(found.doubts(volume, numbers.get("runout_z")))



def write_event_page(name, campaign, found, observation, command, models=None):
    """Write the page of an event: what was observed, what is assumed, scores, a map; -> paths, the page first.
    command: that makes it again; models: `WithoutFlow`, or None."""
    event, nearest = store.event(name), sorted(found, key=lambda one: one.numbers["misfit"])[:DRAWN]
    default = next((one for one in found if one.default), None)
    shown = [*nearest, *([default] if default and default not in nearest else [])]
    picture = render_outlines([(one.way, one.run) for one in shown], campaign.folder / FILES[2],
                              f"{name.replace('_', ' ')}", observed=observation.rings, places=observation.places)
    seen = f"; observed in black, {event.credit}" if observation.rings else ""
    blocks = [Picture(picture, f"Affected areas of the nearest ways and of the default{seen}"),
              Listing("\n".join(lines(found, event))), Paragraph(said(found))]
    blocks += [Listing("\n".join(models.lines))] if models else []
    blocks += [Note(f"{one.way}: {status_of(one.run).text}") for one in found if not status_of(one.run).final]
    blocks += [Note(f"{one.way}: {why}") for one in found if (why := doubts(one.run))]
    definitions = {one.label: one.definition for one in (*SCORES, VALUE) if one is VALUE or one.name in names(found)}
    page = write_page(campaign.folder / FILES[1], page_of(Document(event.title, f"{len(found)} ways to compute it", [
        Section("Scores", blocks), Section("What is known of it", [Table(facts(event))]),
        Section("What is assumed", [Paragraph(text) for text in event.assumed]),
        Section("What the numbers mean", [Table(definitions)]),
        Section("How to make it again", [Listing(command)])])))
    return [page, picture]


def said(found):
    """What the scores say of the default, in a sentence or two."""
    default, leader = next((one for one in found if one.default), None), best(found)
    agree = [one.way for one in found if one.numbers["misfit"] <= 1.0]
    agreed = (f" As near as the observation is known (misfit up to 1): {', '.join(agree)}." if agree else
              " None is as near as the observation is known (misfit up to 1).")
    if default is None or default is leader:
        return f"The default is the nearest of these ways.{agreed}" if default else agreed.strip()
    ahead = sum(one.numbers["misfit"] < default.numbers["misfit"] for one in found)
    text = (f"The default has a misfit of {MISFIT.text(default.numbers['misfit'])}; {ahead} of {len(found)} ways are"
            f" nearer, the nearest {leader.way} with {MISFIT.text(leader.numbers['misfit'])}.")
    error = default.numbers.get("runout_error")
    if error is not None and np.isfinite(error):
        text += f" Its flow gets {abs(error):.0f} m {'less far than' if error < 0 else 'further than'} was observed."
    return text + agreed
