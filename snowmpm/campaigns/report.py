"""Pictures of a campaign, and its report page."""

import numpy as np

from snowmpm.campaigns import convergence, scenarios
from snowmpm.campaigns.answers import is_saw_test, samples_the_parameters, summary
from snowmpm.campaigns.distributions import Scenarios
from snowmpm.campaigns.listing import curves, listing, numeric_parameters, shown_numbers
from snowmpm.campaigns.order import orders
from snowmpm.campaigns.probability import QUANTITIES, short
from snowmpm.quantities.table import quantity
from snowmpm.render.campaign_plot import (
    render_convergence,
    render_corner,
    render_curves,
    render_distribution,
    render_scatter,
    render_tornado,
)
from snowmpm.render.document import Document, Listing, Note, Numbers, Paragraph, Picture, Section, Table
from snowmpm.render.outline_map import render_outlines
from snowmpm.render.page import page_of, write_page
from snowmpm.render.probability_map import render_probability
from snowmpm.stages import stage

MOST = 4
MOST_LISTED = 200
"""Runs on the page."""


def write_pictures(campaign, folder=None):
    """Draw everything of a `Campaign` to its folder `pictures`, and its report page; -> paths, the page first."""
    folder = folder or campaign.folder / "pictures"
    prefix = "" if campaign.variant == campaign.plan.variants[0] else f"{campaign.variant}_"
    with stage("drawing pictures"):
        sections = [draw(campaign, folder, prefix) for draw in (_scenarios, _maps, _numbers, _convergence)]
        page = write_page(campaign.folder / f"{prefix}report.html", page_of(_document(campaign, sections)))
    return [page, *(block.path for section in sections for block in section.blocks if isinstance(block, Picture))]


def _scenarios(campaign, folder, prefix):
    """Outlines and numbers of scenarios, where a campaign has some."""
    section, found = Section("Scenarios", []), scenarios.done(campaign)
    if not found:
        return section
    section.blocks.append(Listing("\n".join(scenarios.lines(found))))
    if any("peak_depth" in run.maps for _, run in found):
        path = render_outlines([(name, run) for name, run in found if "peak_depth" in run.maps],
                               folder / f"{prefix}scenarios.png", campaign.file.name.replace("_", " "))
        section.blocks.append(Picture(path, "Affected area of each scenario"))
    return section


def _maps(campaign, folder, prefix):
    maps, run = campaign.maps, campaign.example
    section = Section("Maps over all runs", [])
    if maps is None or run is None or not samples_the_parameters(campaign.file):
        return section  # shares of the runs of a grid are no probabilities
    n, what = maps.attrs["runs"], maps.attrs["meaning"]
    for name, (raster, _) in QUANTITIES.items():
        if f"{name}_probability" not in maps:
            continue
        shares = maps[f"{name}_probability"]
        for k, limit in enumerate(maps[f"{name}_limit"].values):
            words = f"probability of a {quantity(raster).label} of at least {short(limit, quantity(raster).unit)}"
            widest = float((maps[f"{name}_probability_high"][k] - maps[f"{name}_probability_low"][k]).max())
            path = render_probability(run, maps.x.values, maps.y.values, shares.values[k],
                                      folder / f"{prefix}{name}_probability_{limit:g}.png",
                                      title=f"{campaign.file.name}: {words}",
                                      words=f"{what}, {n} runs; 95 % interval at most {100 * widest:.0f} % wide.")
            section.blocks.append(Picture(path, words))
    path = render_probability(run, maps.x.values, maps.y.values, maps.agreement.values,
                              folder / f"{prefix}agreement.png", agreement=True,
                              title=f"{campaign.file.name}: agreement of the runs",
                              words=f"{n} runs; share on the side of the majority, whether the flow is at least"
                                    f" {min(campaign.file.maps.depth):g} m deep; blank: all agree.")
    section.blocks.append(Picture(path, "Agreement: where the answer depends on the parameters"))
    return section


def _numbers(campaign, folder, prefix):
    section, names = Section("Numbers, and what they depend on", []), shown_numbers(campaign)
    if not names:
        return section
    dimension, numeric = campaign.dimension, numeric_parameters(campaign.file)
    for name in names:
        output = folder / f"{prefix}{name}.png"
        if campaign.file.design == "grid" and numeric:  # its values are chosen: how many lie above says nothing
            across, lines = curves(campaign, name)
            path = render_curves(name, across, lines, output, dimension=dimension)
            section.blocks.append(Picture(path, f"{quantity(name).label} over {across}"))
        elif not scenarios.has(campaign.file):
            path = render_distribution(name, campaign.values(name), output, dimension=dimension)
            section.blocks.append(Picture(path, f"{quantity(name).label}: share of runs at or above"))
    section.blocks.extend(map(Paragraph, orders(campaign, names)))
    rows = campaign.sensitivities.to_dict("records")
    for name in names:
        own = [row for row in rows if row["number"] == name]
        if own:
            path = render_tornado(name, own, folder / f"{prefix}{name}_tornado.png")
            section.blocks.append(Picture(path, f"{quantity(name).label}: what it depends on"))
    if numeric:
        table = {name: campaign.values(name) for name in (*numeric, *names)}
        path = render_scatter(table, numeric[:5], names, folder / f"{prefix}scatter.png", dimension=dimension)
        section.blocks.append(Picture(path, "Every run"))
    return section


def _convergence(campaign, folder, prefix):
    section, rows = Section("Are these enough runs?", []), campaign.convergence.to_dict("records")
    if len(rows) < 3 or not samples_the_parameters(campaign.file):
        return section
    section.blocks.append(Picture(render_convergence(rows, folder / f"{prefix}convergence.png"),
                                  "How the maps change with the number of runs"))
    for (name, limit), needed in convergence.enough(rows).items():
        words = f"{name} of {short(limit, quantity(f'peak_{name}').unit)}"
        enough = needed <= campaign.done
        section.blocks.append(Note(
            f"{words}: about {needed} runs make the probability sure to ±{100 * convergence.WANTED:g} % on average"
            f" where runs differ; there are {campaign.done}.", "good" if enough else "warning"))
    return section


def _document(campaign, sections):
    file = campaign.file
    n = len(campaign.members)
    rows, sampled = {}, samples_the_parameters(file)
    for name, low, middle, high in summary(campaign.table):
        one, values = quantity(name, dimension=campaign.dimension), campaign.values(name)
        rows[one.label] = (f"{one.text(middle)}, 5 to 95 %: {one.text(low)} to {one.text(high)}" if sampled else
                           f"{one.text(np.nanmin(values))} to {one.text(np.nanmax(values))}")
    counts = {"runs done": f"{campaign.done} of {n}", "failed": str(len(campaign.failures)),
              "parameters": str(len(file.parameters)), "design": file.design.replace("_", " ")}
    first = [Numbers(counts), *(Note(f"{name} failed: {reason}") for name, reason in
                                list(campaign.failures.items())[:MOST])]
    not_final = int((~campaign.table["final"].fillna(True).astype(bool)).sum()) if "final" in campaign.table else 0
    if not_final:
        why = ("the crack did not come to the end of the column" if is_saw_test(campaign.table) else
               "still moving at their end")
        first.append(Note(f"{not_final} runs are not final: {why}, or mass left the model."))
    parameters = {name: _words(one) for name, one in file.parameters.items()}
    again = f"snowmpm campaign run {campaign.folder.name}/campaign.toml -o again"
    return Document(file.name.replace("_", " "), f"{n} runs of {file.scene}", [
        Section("", first), Section("Parameters", [Table(parameters)]), *sections,
        Section("Run by run", [Listing("\n".join(listing(campaign, MOST_LISTED)))]),
        Section("Median and range of the numbers" if sampled else "Least and largest of the numbers", [Table(rows)]),
        Section("How to make it again", [Paragraph(f"seed {file.seed}"), Listing(again),
                                         Listing((campaign.folder / "campaign.toml").read_text(encoding="utf-8"),
                                                 "The campaign's file")])])


def _words(parameter):
    if isinstance(parameter, Scenarios):
        return "; ".join(f"{name}: {', '.join(f'{key} = {value}' for key, value in own.items())}"
                         for name, own in parameter.sets.items())
    data = parameter.model_dump(exclude_none=True, exclude_defaults=True, exclude={"key", "distribution"})
    values = ", ".join(f"{name} {value}" for name, value in data.items())
    return f"{', '.join(parameter.keys)}: {parameter.distribution}, {values}"


def draw_posterior(found, output):
    """Draw the posterior of a `Posterior`; -> the path."""
    samples = {name: np.asarray(found.values[:, k]) for k, name in enumerate(found.names)}
    return render_corner(samples, found.weights, output, prior=found.ranges)
