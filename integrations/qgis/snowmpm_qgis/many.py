"""Campaigns: what scenario sets, dam variants and campaigns have in common."""

import csv
import os
import shutil

from . import program, results
from .base import Algorithm, file_name, toml, words_of_settings

MOST_MAPS = 12
"""Scenarios whose maps are added to the project."""


class Many(Algorithm):
    """Base of algorithms that run a campaign of one scene."""

    def write_scene(self, parameters, context, feedback, folder, show, release, terrain, **more):
        """Write the scene that all runs have in common, scene.toml."""
        settings = self.settings(parameters, context, **more)
        program.run(["new", "scene", "--terrain", terrain, "--release", release, "--method", "depth", "-o", folder,
                     "--overwrite", *words_of_settings(settings)], feedback, show, folder)

    def run_campaign(self, feedback, folder, show, name, head, tables):
        """Write and run a campaign; -> its folder. head: {key: value}; tables: [(header, {key: value})]."""
        head = {"name": file_name(name), "scene": "scene.toml", **head}
        lines = [f"{key} = {toml(value)}" for key, value in head.items()]
        for header, values in tables:
            lines += ["", f"[{header}]", *(f"{toml(key)} = {toml(value)}" for key, value in values.items())]
        with open(os.path.join(folder, "campaign.toml"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        out = os.path.join(folder, "campaign")
        if os.path.isfile(os.path.join(out, "plan.json")):  # of an earlier run of this algorithm
            shutil.rmtree(out)
        program.run(["campaign", "run", os.path.join(folder, "campaign.toml"), "-o", out], feedback, show, folder)
        return out

    def run_scenarios(self, parameters, context, feedback, folder, steps, sets):
        """Run scenarios {name: {key: value}}, and write the maps of each; -> outputs."""
        name = self.title(parameters, context)
        tables = [("parameters.scenario", {"distribution": "scenarios"}),
                  *((f"parameters.scenario.sets.{toml(one)}", changes) for one, changes in sets.items())]
        out = self.run_campaign(feedback, folder, steps.next(), name, {"design": "grid"}, tables)
        show, done = steps.next(), rows(os.path.join(out, "table.csv"))[:MOST_MAPS]
        self._maps = []
        for k, row in enumerate(done):
            maps = os.path.join(folder, "maps", f"{k:02d}")
            program.run(["maps", os.path.join(out, "runs", row["hash"]), "-o", maps, "--files", "gis", "-q"],
                        feedback, None, folder)
            self._maps.append((row["scenario"], maps))
            show((k + 1) / len(done))
        self._load, self._name, self._out = self.parameterAsBoolean(parameters, "LOAD", context), name, out
        return {"OUTPUT": folder, "TABLE": os.path.join(out, "scenarios.csv"),
                "OUTLINES": os.path.join(out, "scenarios.gpkg"), "REPORT": os.path.join(out, "report.html")}

    def add_scenarios(self, project):
        """Add the outlines of all scenarios, and the maps of each in a group of its own; -> layers to look at."""
        group, found = results.new_group(project, self._name), []
        path = os.path.join(self._out, "scenarios.gpkg")
        for inner, title in (("affected_area", "affected area"), ("above_1_kPa", "above 1 kPa"),
                             ("above_3_kPa", "above 3 kPa"), ("above_10_kPa", "above 10 kPa"),
                             ("above_30_kPa", "above 30 kPa")):
            layer = results.add_vector(path, inner, title, project, group, inner == "affected_area")
            found += [layer] if layer is not None and inner == "affected_area" else []
        for scenario, maps in self._maps:
            own = group.addGroup(scenario)
            results.add_project(os.path.join(maps, "avalanche.qgs"), project, own,
                                lambda name: name != "terrain")
            own.setExpanded(False)
            own.setItemVisibilityChecked(False)
        if self._maps:
            ground = os.path.join(self._maps[0][1], "avalanche.qgs")
            results.add_project(ground, project, group, lambda name: name == "terrain")
        return found


def rows(path):
    """Rows of a table, without the runs that failed."""
    with open(path, encoding="utf-8", newline="") as file:
        return [row for row in csv.DictReader(file) if row["status"] == "done"]
