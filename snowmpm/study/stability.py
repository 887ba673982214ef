"""Where each scheme fails and how: an atlas of measured borders.

Every entry (`atlas.catalogue`) has a small scene that shows one failure, a number for its severity, and settings that
differ in their resistance to it. The study writes a table of all measurements, a table of the borders (bisected to
2 %), a map for each group of entries, and a page. The program uses the borders shipped with it
(`snowmpm.measured.borders.SHIPPED`): `snowmpm check` warns of scenes beyond them.
"""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from snowmpm.draft import write_table, write_text
from snowmpm.errors import InputError
from snowmpm.measured import borders as borders_of
from snowmpm.reading.table_file import read_table
from snowmpm.render.atlas_map import MapPanel, render_atlas
from snowmpm.stages import counted
from snowmpm.study.atlas import page
from snowmpm.study.atlas.catalogue import ENTRIES, GROUPS

TABLE, BORDERS = "stability.csv", "stability_borders.csv"
COLUMNS = ("entry", "setting", "value", "symptom")


def study(folder, *, quick=False, only=(), say=print):
    """Measure, draw and write; -> paths. quick: of each entry the setting that fails and the one that is cured only;
    only: names of entries or groups, whose rows replace those in the folder's tables."""
    folder, entries = Path(folder), chosen(only)
    symptoms, borders = _kept(folder) if only else ({}, {})
    for entry in counted(entries, "stability", "entries"):
        started = time.process_time()
        for setting in entry.settings:
            if quick and setting not in (entry.shown, entry.cured):
                continue
            row = entry.row(setting)
            symptoms[entry.name, setting] = dict(zip(map(float, entry.values), row, strict=True))
            borders[entry.name, setting] = entry.border(setting, row)
        say(f"{entry.name:22s} {time.process_time() - started:6.1f} s  {_said(entry, borders)}")
        _write(symptoms, folder / TABLE)
        borders_of.write(borders.values(), folder / BORDERS)
    return [folder / TABLE, folder / BORDERS, *report(symptoms, borders, folder)]


def chosen(only):
    """Entries named, or of the groups named; all for none. Raises InputError for a name that is neither."""
    for name in only:
        if name not in ENTRIES and name not in GROUPS:
            raise InputError.at("--only", name, f"must be an entry ({', '.join(ENTRIES)}) or a group"
                                f" ({', '.join(GROUPS)})")
    return [entry for group, entries in GROUPS.items() for entry in entries
            if not only or entry.name in only or group in only]


def report(symptoms, borders, folder):
    """Maps of every group that was measured, and the page; -> paths."""
    charts = {}
    for group, entries in GROUPS.items():
        panels = [_panel(entry, symptoms, borders) for entry in entries if _settings(entry, borders)]
        if panels:
            charts[group] = render_atlas(panels, folder / f"stability_{group.replace(' ', '_').replace(',', '')}.png",
                                         title=f"Where schemes fail: {group}")
    path = folder / "stability.md"
    write_text(path, page.page(borders, symptoms, charts))
    return [*charts.values(), path]


def _settings(entry, borders):
    return [setting for setting in entry.settings if (entry.name, setting) in borders]


def _panel(entry, symptoms, borders):
    settings = _settings(entry, borders)
    table = np.array([list(symptoms[entry.name, setting].values()) for setting in settings])
    unit = f" [{entry.unit}]" if entry.unit else ""
    return MapPanel(entry.title, entry.parameter + unit, tuple(symptoms[entry.name, settings[0]]), tuple(settings),
                    table, entry.limit, tuple(borders[entry.name, setting].value for setting in settings),
                    f"{entry.symptom}; limit {entry.limit:g}")


def _said(entry, borders):
    found = borders[entry.name, entry.shown]
    return f"{entry.shown}: {page.verdict(found)}"


def _kept(folder):
    """Symptoms {(entry, setting): {value: symptom}} and borders of the tables of a folder, with the words of today."""
    if not (folder / TABLE).exists():
        return {}, {}
    symptoms, kept = {}, borders_of.read(folder / BORDERS)
    rows = read_table(folder / TABLE, lambda row: (row["entry"], row["setting"], float(row["value"]),
                                                   float(row["symptom"])))
    for entry, setting, value, symptom in rows:
        symptoms.setdefault((entry, setting), {})[value] = symptom
    known = [(name, setting) for name, entry in ENTRIES.items() for setting in entry.settings
             if (name, setting) in kept and (name, setting) in symptoms]
    return ({key: symptoms[key] for key in known},
            {key: replace(kept[key], **ENTRIES[key[0]].words) for key in known})


def _write(symptoms, path):
    write_table(path, COLUMNS, [(entry, setting, f"{value:g}", f"{symptom:.4g}")
                                for (entry, setting), row in symptoms.items() for value, symptom in row.items()])
