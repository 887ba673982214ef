"""The page of a chain: what was found, what it depends on, what was assumed and by whom."""

from typing import Any

from PIL import Image

from snowmpm.io import Run
from snowmpm.pit.record import NAMES, told
from snowmpm.pit.scenes import BEARS
from snowmpm.quantities.table import quantity
from snowmpm.render.document import Document, Listing, Note, Numbers, Paragraph, Picture, Section, Table
from snowmpm.render.figure import save_picture
from snowmpm.render.page import page_of, write_page
from snowmpm.render.peak_map import MapSheet
from snowmpm.render.run_film import view_of

SIZE, DPI = (1100, 520), 100
MAPS = ("peak_pressure", "peak_depth")


def write_report(chain: Any, pit_picture: Any) -> list[Any]:
    """Draw the pictures of a `Chain` and write report.html; -> paths, the page last."""
    folder = chain.folder / "pictures"
    release = Run(chain.folder / "release")
    pictures = [_still(release, folder / "release.png")]
    sections = [
        Section("", [Numbers(_numbers(chain)), *_notes(chain)]),
        Section("What the result depends on", [
            *map(Paragraph, chain.dependence()), Listing("\n".join(_variations(chain)))]),
        Section("Profile and stability", [
            Picture(pit_picture, "The profile; the weak layer is marked"),
            Listing("\n".join(told(chain.profile, chain.candidates, chain.index, chain.column, chain.stability)))]),
        Section("Release on the local slope", [
            Picture(pictures[0], f"The slab at {release.times[-1]:g} s, over a weak layer of {chain.side:.0f} m"),
            *_release(chain)]),
    ]
    if chain.flow is not None:
        sheet = MapSheet(chain.flow)
        flow = [sheet.render(name, folder / f"{name}.png") for name in MAPS]
        pictures += flow
        sections.append(Section("Flow", [Picture(path, quantity(name).label) for name, path in
                                         zip(MAPS, flow, strict=True)]))
    sections.append(Section("Every assumption, and its source", [Listing("\n".join(_assumptions(chain)))]))
    sections.append(Section("Go on from here", [Paragraph(text) for text in (
        "release.toml, flow.toml and saw_test.toml are scenes: change them, then snowmpm run FILE.",
        "release.gpkg may be replaced by an area that you know; flow.toml reads it.")]))
    document = Document(f"{chain.profile.name}: from the pit to the map", _lead(chain), sections, "snowmpm chain")
    return [*pictures, write_page(chain.folder / "report.html", page_of(document))]


def _lead(chain):
    x, y = chain.slope.place
    return (f"A snow profile, its stability, the release of its slab at {x:.0f}, {y:.0f} on"
            f" {chain.slope.angle:.0f} degrees, and the flow from there."
            " Results of models with many assumptions. No hazard assessment.")


def _numbers(chain):
    found = {"slab": f"{100 * chain.column.thickness:.0f} cm, {chain.column.density:.0f} kg/m³",
             "local slope": f"{chain.slope.angle:.0f}°"}
    length = next((one for one in reversed(chain.stability.lengths) if one.value is not None), None)
    if length is not None:
        found[f"critical cut length, {NAMES[length.theory]}"] = (
            f"{length.value:.2f} m ({length.low:.2f} to {length.high:.2f})")
    if chain.released is not None:
        release = chain.released
        found["release of the assumed square"] = (
            f"{release.area:.0f} m², {release.thickness:.2f} m, {release.volume:.0f} m³")
    for name in ("runout", "area_above_1_kPa", "largest_flow_pressure") if chain.variations else ():
        if chain.base.get(name) is not None:
            found[quantity(name).label] = quantity(name).text(chain.base[name])
    return found


def _notes(chain):
    yield from map(Note, chain.notes)
    if chain.why:
        yield Note(f"The slab did not go: {chain.why}. No flow was computed.")
    strength = chain.column.weak.strength
    if strength is not None and strength < BEARS * chain.stability.shear:
        yield Note(f"By its form and density the weak layer has a shear strength of {strength:.0f} Pa, less than"
                   f" {BEARS:g} times the {chain.stability.shear:.0f} Pa of shear that the slab puts on it; the release"
                   " takes that.")
    if chain.released is not None:
        yield Note(f"The area of the release is that of the square of weak layer that was computed, {chain.side:.0f} m"
                   " wide: an assumption. --size computes more; put an area that you know in place of release.gpkg.")
    if chain.flow is not None and (chain.flow.summary.get("status") or {}).get("final") is False:
        yield Note(chain.flow.summary["status"].get("status", "The flow is not final."))


def _variations(chain):
    yield f"{'flow':56} {'run-out':>9} {'above 1 kPa':>12} {'speed':>9} {'pressure':>10}"
    for one in chain.variations:
        texts = [_text(one.numbers.get(name), factor, unit) for name, factor, unit in (
            ("runout", 1.0, "m"), ("area_above_1_kPa", 1.0, "m²"), ("largest_flow_speed", 1.0, "m/s"),
            ("largest_flow_pressure", 1e-3, "kPa"))]
        yield f"{one.what if one.step else one.name:56} {texts[0]:>9} {texts[1]:>12} {texts[2]:>9} {texts[3]:>10}"


def _release(chain):
    found = chain.released
    if found is None:
        return
    yield Table({"area in plan": f"{found.area:.0f} m²", "thickness, normal to the slope": f"{found.thickness:.2f} m",
                 "volume": f"{found.volume:.0f} m³", "snow in the scene": f"{found.slab:.0f} m²"})


def _assumptions(chain):
    from snowmpm.pit.chain import assumptions

    for step, what, source in assumptions(chain):
        yield f"{step:10} {what}\n{'':10}   source: {source}"


def _still(run, output):
    return save_picture(Image.fromarray(view_of(run, SIZE).picture(len(run) - 1)), output, DPI)


def _text(value, factor, unit):
    return "-" if value is None else f"{value * factor:.0f} {unit}"
