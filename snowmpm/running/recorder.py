"""Output of a run: frames, history rows, maps, hazard numbers, summary."""

import copy
import json
import platform
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from snowmpm import __version__, plugins
from snowmpm.compiler import runtime, ti
from snowmpm.errors import InputError
from snowmpm.io import Background, Run, RunWriter
from snowmpm.io.archive import write_text
from snowmpm.io.status import Status
from snowmpm.particles.fields import field_units
from snowmpm.quantities.motion import Motion
from snowmpm.quantities.resolution import published
from snowmpm.results import maps
from snowmpm.running import audit as diagnostics
from snowmpm.running.description import written_fields
from snowmpm.running.device import device_name
from snowmpm.running.friction_class import class_chosen, doubts_after
from snowmpm.seeding.region_files import system_of as region_system
from snowmpm.setup.release_plan import release_plan
from snowmpm.solids.loads import LoadHistory
from snowmpm.terrain.raster import system_of as raster_system
from snowmpm.terrain.reference_system import system_beside

CAUSES = ("elastic", "breaking", "advective", "deformation", "fixed", "output")
"""Possible causes of the length of a step; the history counts the steps of each as steps_CAUSE."""


PATIENCE = 1.0
"""Seconds of wall time for which frames may wait to be written together: what is on the disk is that old at most."""


class Recorder:
    """Writes the output of a simulation: frames, history rows, loads on obstacles, maps, summary.

    background: the thread that writes frames, and checkpoints after them. frames: number of frames passed to it.
    """

    def __init__(self, simulation, folder, state=None):
        """state: of the recorder whose run file in `folder` is continued; later frames there are dropped.

        Raises InputError when that file is missing or holds fewer frames than the recorder had written.
        """
        self._simulation, self._folder = simulation, folder
        self.frames, self.particle_steps, self.last = 0, 0, {}
        self._settling_steps = simulation.settling_steps
        self._causes, self._smallest_dt = {}, float("inf")
        model = simulation.model
        self._origin = model.lower
        self._maps: Any = None
        self._moved = 0.0
        self._starts = [body.start_time for body in simulation.scene.bodies if body.start_time > 0.0]
        self._obstacles = model.obstacles
        self._loads = LoadHistory([obstacle.name for obstacle in self._obstacles], simulation.scene.dimension)
        if simulation.scene.dimension == 3:
            self._maps = maps.PeakMaps(simulation.solver, model.map_grid)
        if state is not None:
            self._restore(state)
        self._methods = 1
        self._writer = self._new_file() if state is None else self._continued_file()
        self.background = Background(self._writer.flush)

    def _new_file(self):
        surface = self._simulation.model.surface
        terrain = (surface.vertices - self._origin, surface.facets) if surface is not None else None
        drawings = {obstacle.name: obstacle.shape.drawing() for obstacle in self._obstacles}
        drawings = {name: (vertices - self._origin, facets) for name, (vertices, facets) in drawings.items()}
        skins = {obstacle.name: [replace(skin, vertices=skin.vertices - self._origin)
                                 for skin in obstacle.shape.skins()] for obstacle in self._obstacles}
        return RunWriter(self._folder, provenance=self._provenance(), terrain=terrain, obstacles=drawings, skins=skins,
                         origin=self._origin, dimension=self._simulation.scene.dimension, units=field_units(),
                         saw_test=crack.description() if (crack := self._simulation.crack) else None,
                         patience=PATIENCE)

    def _continued_file(self):
        time, run = self._simulation.time, Run(self._folder)
        there = int((run.times <= time + 1e-9 * max(1.0, time)).sum())
        if there != self.frames:
            raise InputError(f"{run.path}: {there} frames up to t = {time:.6g} s, but {self.frames} were written before"
                             " the checkpoint: not the file that it belongs to; start anew with --overwrite")
        writer = RunWriter.reopen(self._folder, until=time, patience=PATIENCE)
        scene = self._simulation.scene
        writer.provenance({"scene": scene.to_toml(), "end_time": scene.end_time, "complete": False,
                           **({"methods": self._simulation.relay.records} if scene.switch else {}),
                           "settings": {**run.provenance.get("settings", {}), **scene.overrides},
                           "end_state": {}, "resumed": [*run.provenance.get("resumed", []), time]})
        return writer

    def state(self):
        """All that a continuation needs, by name (`snowmpm.io.checkpoint`), as copies."""
        return copy.deepcopy({"frames": self.frames, "particle_steps": self.particle_steps, "last": self.last,
                "settling_steps": self._settling_steps, "causes": self._causes,
                "smallest_dt": self._smallest_dt, "moved": self._moved,
                "loads": self._loads.state(), "maps": self._maps.state() if self._maps else {}})

    def _restore(self, state):
        self.frames, self.particle_steps, self.last = state["frames"], state["particle_steps"], state["last"]
        self._causes, self._smallest_dt, self._moved = state["causes"], state["smallest_dt"], state["moved"]
        self._settling_steps = state.get("settling_steps", 0)  # checkpoints of older versions have none
        self._loads.restore(state["loads"])
        if self._maps:
            self._maps.restore(state["maps"])

    def _provenance(self):
        scene = self._simulation.scene
        spacing = scene.solver.spacing(scene.dimension)
        return {"program": "snowmpm", "version": __version__, "compiler": ti.__name__,
                "taichi": ".".join(map(str, ti.__version__)), "numpy": np.__version__,
                "python": platform.python_version(), "backend": runtime.backend(),
                "threads": runtime.threads(), "device": device_name(runtime.backend(), runtime.threads()),
                "precision": scene.solver.precision, "seed": scene.seed,
                "scene": scene.to_toml(), "settings": scene.overrides, "scene_name": scene.name,
                "particle_spacing": spacing, "dx": scene.solver.dx, "end_time": scene.end_time,
                "bodies": [body.name for body in scene.bodies],
                "materials": list(scene.materials), "particles": self._simulation.n_particles,
                **({"components": told} if (told := self._choices()) else {}),
                **({"plugins": made_with} if (made_with := plugins.records()) else {}),
                **({"zone_spacing": scene.zone.solver.spacing(scene.dimension)} if scene.zone else {}),
                **({"chosen": [str(choice) for choice in scene.choices]} if scene.choices else {}),
                **({"body_shares": shares} if (shares := self._cut_bodies()) else {}),
                **({"initial_from": taken.source} if (taken := self._simulation.model.taken) else {}),
                **map_origin(scene)}

    def _choices(self):
        """What components say beside maps, label -> text."""
        return {label: text for one in self._simulation.solver.adapters for label, text in one.choices().items()}

    def _cut_bodies(self):
        """Share of the volume, by name, of bodies cut at symmetric sides."""
        return {name: float(share) for name, share in self._simulation.model.shares.items() if share < 1.0}

    def watch(self):
        """After a step: keep the peak maps, the loads and the record of time steps and methods."""
        simulation = self._simulation
        self._note_methods()
        self.particle_steps += simulation.solver.particles.moves
        cause = simulation.dt_cause
        self._causes[cause] = self._causes.get(cause, 0) + 1
        self._smallest_dt = min(self._smallest_dt, simulation.dt)
        if self._obstacles:
            self._loads.watch(simulation.time, simulation.obstacle_totals)
        if self._maps:
            self._moved += simulation.max_speed * simulation.dt
            if self._moved > self._maps.cell or self._released():
                self._see(deposit=False)

    def _released(self):
        """Whether a body was released in the last step."""
        time, slack = self._simulation.time, 1e-9 * max(1.0, self._simulation.time)
        return any(time - self._simulation.dt + slack < start <= time + slack for start in self._starts)

    def _note_methods(self):
        """Write which methods have been at work, when another has taken over."""
        records = self._simulation.relay.records
        if len(records) > self._methods:
            self._methods = len(records)
            provenance = {"methods": copy.deepcopy(records)}
            self.background.do(lambda: self._writer.provenance(provenance))

    def _see(self, deposit):
        self._moved = 0.0
        self._maps.see(self._simulation.solver, deposit)

    def frame(self):
        """Write the state now: particles, obstacles, a row of the history, the maps so far."""
        simulation = self._simulation
        particles = simulation.particles
        loads = self._loads.take()
        self.last = {**simulation.audit(particles), **self._loads.means()}
        counts = {f"steps_{cause}": self._causes.get(cause, 0) for cause in dict.fromkeys([*CAUSES, *self._causes])}
        units = {**diagnostics.UNITS, **self._loads.mean_units(), **dict.fromkeys(counts, "1")}
        for adapter in simulation.solver.adapters:
            units.update(adapter.units())
        time, row = simulation.time, {**self.last, **counts}
        names = written_fields(simulation.scene)
        poses = {obstacle.name: obstacle.motion.placement(time, self._origin) for obstacle in self._obstacles}
        crack = copy.deepcopy(simulation.crack.take()) if simulation.crack else None
        series = simulation.solver.adapters.take_series()

        def write():
            values = {name: particles[name] for name in names}
            if "stress" in values and simulation.scene.dimension == 2:
                values["stress"] = values["stress"][:, [0, 2, 1, 4, 5, 3]]  # tensor axes x, z, out of plane -> x, y, z
            self._writer.history(time, row, units)
            self._writer.frame(time, particles["position"] - self._origin, values, poses, loads, crack, series)

        self.background.do(write)
        self.frames += 1
        if self._maps:
            self._see(deposit=True)

    def close(self, phases, complete, ended=None):
        """Write maps and summary and close the run file. ended: why a complete run did, in words."""
        whole = False
        try:
            self.background.close()
            if self._maps:
                surface = self._simulation.model.surface
                normal = None if surface is None else surface.normal
                for name, (values, x0, y0, cell) in self._maps.rasters(normal).items():
                    self._writer.map(name, values, x0 - self._origin[0], y0 - self._origin[1], cell, maps.UNITS[name])
                self._maps_of_components(x0 - self._origin[0], y0 - self._origin[1])
            assessed = self._assess()
            if assessed:
                self._writer.hazard(assessed.record())
            phases.lap("output")
            summary = {**self.summary(phases, complete), **({"ended": ended} if ended else {})}
            if assessed:
                known = max(self._maps.cell, self._simulation.scene.solver.dx)
                summary["hazard"] = published(assessed.numbers, known)
                summary["areas_by_class"] = assessed.classes
                if chosen := class_chosen(self._simulation.model):
                    summary["friction_class"] = chosen
                if doubts := doubts_after(self._simulation.model, assessed.numbers):
                    summary["friction_doubts"] = doubts
            self._writer.provenance({"wall_time": summary["wall_time"], "complete": complete,
                                     "end_state": self._end_state(),
                                     **({"ended": ended} if ended else {})})
            whole = complete
        finally:
            self._writer.close(complete=whole)
        write_text(self._folder / "summary.json", json.dumps(summary, indent=1))

    def _maps_of_components(self, x0, y0):
        """Write the rasters of components, whose first cell has its centre at x0, y0."""
        grid = self._simulation.model.map_grid
        for adapter in self._simulation.solver.adapters:
            for name, (values, unit) in adapter.maps(grid).items():
                self._writer.map(name, values.T, x0, y0, grid.cell, unit)

    def _assess(self):
        """Hazard numbers from the maps; None for a run without maps or terrain."""
        surface = self._simulation.model.surface
        if self._maps is None or surface is None:
            return None
        from snowmpm.results import hazard  # slow to import

        end = self._end_state()
        removed = self._simulation.solver.particles.removed
        particles = self._simulation.particles
        mass = float(particles["mass"][particles.flowing()].sum()) + removed.get("laid", 0.0)
        gone, entrained = removed["mass"], removed.get("entrained", 0.0)
        entrained += sum(one.entrained() for one in self._simulation.solver.adapters)
        apart = sum(sum(one.apart()) for one in self._simulation.solver.adapters)
        whole = {"release_mass": mass + gone + apart - entrained, "deposit_mass": mass,
                 **{name: end[name] for name in ("moving_share", "momentum_share", "left_share")}}
        found = hazard.assess(self._maps.values, self._maps.lower, self._maps.cell, self._maps.flow_depth, whole,
                              surface.height, release_plan(self._simulation.model))
        for adapter in self._simulation.solver.adapters:
            found.numbers.update(adapter.numbers(self._simulation.model.map_grid))
        return found

    def _end_state(self):
        """Input of `snowmpm.io.status` for the current state, which may be later than the last frame."""
        simulation = self._simulation
        particles, gone = simulation.particles, simulation.solver.particles.removed
        flows = particles.flowing()
        now = Motion.of(particles["mass"][flows], particles["velocity"][flows], simulation.motion.peak_momentum,
                        gone.get("laid", 0.0))
        apart = np.sum([one.apart() for one in simulation.solver.adapters] or [(0.0, 0.0)], axis=0)
        left = gone["mass"] - gone["taken"] + apart[1]
        return {"time": simulation.time, "moving_share": now.moving_share, "momentum_share": now.momentum_share,
                "left_share": float(left / max(now.mass + gone["mass"] + apart.sum(), 1e-300))}

    def summary(self, phases, complete):
        """What summary.json says."""
        simulation, solver = self._simulation, self._simulation.solver
        times = {name: round(value, 3) for name, value in phases.walls.items()}
        status = Status(complete, end_time=simulation.scene.end_time, **self._end_state())
        per_step = 1e9 * phases.steps / max(1, self.particle_steps)
        return {"scene": simulation.scene.name, "complete": complete, "time": simulation.time,
                **({} if simulation.crack else {"status": status.record()}),  # a saw test has no run-out
                "particles": simulation.n_particles, "steps": solver.steps, "settling_steps": self._settling_steps,
                "sorts": solver.particles.sorts,
                "frames": self.frames, "wall_time": round(sum(times.values()), 3), "wall_time_of": times,
                "processor_time": round(phases.processor, 3),
                "writing_time": round(self.background.work, 3),
                "particle_steps": self.particle_steps, "ns_per_particle_step": round(per_step, 2),
                "backend": runtime.backend(), "threads": runtime.threads(),
                "precision": simulation.scene.solver.precision, "dt_causes": self._causes,
                "smallest_dt": self._smallest_dt if solver.steps else None, "last": self.last,
                **({"methods": simulation.relay.records} if simulation.scene.switch else {}),
                **({"saw_test": simulation.crack.result()} if simulation.crack else {})}


def map_origin(scene):
    """Origin of the map coordinates of a scene: {"crs": WKT or None, "attribution": credits}, as far as known.

    The system of the terrain, in metres; where it names none, that of the first region file that does.
    """
    terrain = scene.terrain
    credit = terrain and terrain.get("attribution")
    system = None
    if terrain and terrain.get("file"):
        system = (raster_system if terrain.kind == "dem" else system_beside)(_path(scene, terrain))
    for body in scene.bodies:
        region = body.shape.get("region")
        if system is None and region and region.get("file"):
            system = region_system(_path(scene, region), "region.file")
    return {"crs": system and system.wkt, **({"attribution": credit} if credit else {})}


def _path(scene, item):
    return scene.base_dir / Path(item.file).expanduser()
