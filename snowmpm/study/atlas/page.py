"""The page of the atlas, written from its borders."""

from snowmpm.study.atlas.catalogue import GROUPS
from snowmpm.study.atlas.entry import RESOLUTION

HEAD = """# Where schemes fail: an atlas

Written by `snowmpm study stability` from what it measured. {n} failures: the smallest scene that shows each, what is
seen, which settings cure it, and from where on. A border is where the symptom passes the limit that is given, bisected
to 2 % where nothing else is said; runs are in double precision and plane strain, on one thread, and give the same
numbers each time. `snowmpm check` warns of scenes that lie beyond a border, and a run that fails says which entry it
looks like.
"""


def verdict(border):
    """Where a setting fails, in words."""
    unit = f" {border.unit}" if border.unit else ""
    if border.value is not None:
        return f"{border.fails} {border.value:.3g}{unit}"
    if border.held:
        return f"nowhere from {border.lowest:g} to {border.highest:g}{unit}"
    return f"everywhere from {border.lowest:g} to {border.highest:g}{unit}"


def page(borders, symptoms, charts):
    """Markdown of all that is in `borders` {(entry, setting): Border}; symptoms {(entry, setting): {value: symptom}};
    charts: {group: path}."""
    parts, counted = [], len({entry for entry, _ in borders})
    for group, entries in GROUPS.items():
        if group not in charts:
            continue
        parts.append(f"\n## {group.capitalize()}\n\n![Maps: {group}]({charts[group].name})\n")
        parts += [_section(entry, borders, symptoms) for entry in entries
                  if any((entry.name, setting) in borders for setting in entry.settings)]
    return HEAD.format(n=counted) + "".join(parts)


def _section(entry, borders, symptoms):
    limit = f"{entry.symptom}, at most {entry.limit:g}"
    rows = "".join(f"| {setting} | {verdict(borders[entry.name, setting])} |"
                   f" {max(symptoms[entry.name, setting].values()):.2g} |\n"
                   for setting in entry.settings if (entry.name, setting) in borders)
    if entry.resolution != RESOLUTION:
        limit += f"; border to {entry.resolution:.2g} of itself"
    return (f"\n### {entry.title} (`{entry.name}`)\n\n"
            f"Scene: {entry.scene}.\n\nSeen: {entry.seen}.\n\nCured by: {entry.cure}.\n\n"
            f"Symptom: {limit}. Over: {entry.parameter}{f' [{entry.unit}]' if entry.unit else ''}.\n\n"
            f"| setting | fails | worst seen |\n|---|---|---|\n{rows}")
