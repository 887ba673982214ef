"""What is known of an event, in words."""


from snowmpm.quantities.table import quantity


def place_of(value):
    """Where a value was measured."""
    return "largest" if value.x is None else f"at {value.x:.0f}, {value.y:.0f}"


def facts(event):
    """{what: words} of an `Event`."""
    seen = event.observed
    found = {"date": f"{event.date:%Y-%m-%d}", "place": event.place, "avalanche": event.kind}
    if seen.outline:
        found["observed outline"] = f"{seen.outline.file}, its border to {seen.outline.uncertainty:g} m"
    if seen.deposit:
        found["observed deposit"] = f"{seen.deposit.file}, its border to {seen.deposit.uncertainty:g} m"
    if seen.stopped:
        found["stopped at"] = f"{seen.stopped.x:.0f}, {seen.stopped.y:.0f}, to {seen.stopped.uncertainty:g} m"
    if seen.deposit_volume:
        found["deposit volume"] = f"{seen.deposit_volume.value:g} ± {seen.deposit_volume.deviation:g} m³"
    for k, one in enumerate(seen.values):
        unit = quantity(one.map).unit
        found[f"value {k + 1}: {quantity(one.map).label}, {place_of(one)}"] = (
            f"{'at least ' if one.at_least else ''}{one.value:g} ± {one.deviation:g} {unit}, {one.by}")
    found |= {"data by": event.credit, "licence": f"{event.licence}: {event.uses}", "its text": event.terms}
    for k, text in enumerate(event.sources):
        found["source" if len(event.sources) == 1 else f"source {k + 1}"] = text
    for one in event.brought:
        found[f"you bring {one.name}"] = f"{one.what}, from {one.source}"
    return found
