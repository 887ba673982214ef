"""The table of quantities: every number of a run that has a name, with its unit and its one definition.

Histories, logs, summary.json, maps, plots, reports, comparisons and vector files take names, units and words from here.
"""

from dataclasses import replace

from snowmpm.quantities import powder
from snowmpm.quantities.classes import PRESSURES
from snowmpm.quantities.motion import CREEP, FILMS, MOVING_SPEED, REST_MOMENTUM, REST_SHARE
from snowmpm.quantities.quantity import Quantity, per_width
from snowmpm.quantities.saw import SAW_TEST

AUDIT, MOTION = "snowmpm.running.audit", "snowmpm.quantities.motion"
MAPS, HAZARD, LOADS = "snowmpm.results.maps", "snowmpm.results.hazard", "snowmpm.io.impact"
GAUGED, ALONG = "snowmpm.io.gauges", "snowmpm.io.along_path"

MOVING_SHARE = Quantity("moving_share", "still moving", "share", f"Share of the mass in the domain that is faster than "
                        f"{MOVING_SPEED:g} m/s. At rest: {100 * REST_SHARE:g} % or less, and momentum_share at "
                        f"{100 * REST_MOMENTUM:g} % or less; or momentum_share at {100 * FILMS:g} % or less.", MOTION)
MOMENTUM_SHARE = Quantity("momentum_share", "momentum, of its peak", "share", "Total momentum over its largest value "
                          f"so far; 0 while the mean speed is below {100 * CREEP:g} cm/s.", MOTION)


HISTORY = (
    Quantity("mass", "mass in the domain", "kg", "Mass of all particles in the domain.", AUDIT),
    Quantity("momentum_x", "momentum along x", "kg m/s", "Sum of m v along x.", AUDIT),
    Quantity("momentum_y", "momentum along y", "kg m/s", "Sum of m v along y.", AUDIT),
    Quantity("momentum_z", "momentum along z", "kg m/s", "Sum of m v along z, upwards.", AUDIT),
    Quantity("angular_momentum", "angular momentum", "kg m2/s", "Of the snow in 2-D, about its centre of mass at the "
             "start, from x towards z. Not in a periodic domain.", AUDIT),
    *(Quantity(f"angular_momentum_{axis}", f"angular momentum about {axis}", "kg m2/s", "Of the snow in 3-D, about an "
               f"axis along {axis} through its centre of mass at the start. Not in a periodic domain.", AUDIT)
      for axis in "xyz"),
    Quantity("kinetic_energy", "kinetic energy", "J", "Sum of m v² / 2 over the particles.", AUDIT),
    Quantity("affine_energy", "affine energy", "J", "Kinetic energy of the motion within particles (affine transfers).",
             AUDIT),
    Quantity("elastic_energy", "elastic energy", "J", "Elastic energy stored in the snow, by its laws.", AUDIT),
    Quantity("potential_energy", "potential energy", "J", "Sum of -m g.x, from the first centre of mass.", AUDIT),
    Quantity("plastic_work", "plastic work", "J", "Work dissipated in the snow since the start.", AUDIT),
    Quantity("contact_work", "work taken by contact", "J", "Energy that ground and obstacles took since the start.",
             AUDIT),
    Quantity("force_work", "work of forces", "J", "Work that prescribed accelerations, pressures, tractions and "
             "displacements have done on the snow since the start.", AUDIT),
    Quantity("damping_work", "work taken by damping", "J", "Energy that prescribed damping took since the start.",
             AUDIT),
    Quantity("removed_energy", "energy that left", "J", "Energy of the particles that left or were taken out.", AUDIT),
    Quantity("handover_energy", "energy lost in handing over", "J", "Energy before less energy after all hand-overs to "
             "another method so far (switch): motion that it does not have, elastic energy, height.", AUDIT),
    Quantity("method", "method at work", "1", "Number of the method: 0 that of the scene, 1 that of the first switch.",
             AUDIT),
    Quantity("energy_remainder", "numerical remainder", "J", "Energy of the start less all that is accounted for: what "
             "the scheme itself took.", AUDIT),
    Quantity("null_space_noise", "noise that the grid cannot see", "1", "Share of the particles' kinetic energy that "
             "the grid does not see.", AUDIT),
    Quantity("occupied_cells", "occupied cells", "1", "Grid cells that hold particles.", AUDIT),
    Quantity("emptied_cells", "emptied cells", "1", "Grid cells without particles between two that hold some.", AUDIT),
    Quantity("parted_share", "snow beside emptied cells", "share", "Mass of the particles in cells beside an emptied "
             "one, over all.", AUDIT),
    Quantity("momentum_residual", "momentum residual", "1", "What is left open of the momentum balance, over the sizes "
             "of its terms, or over sqrt(2 m E) with the energy E that was turned over, where that is more.", AUDIT),
    Quantity("max_speed", "fastest particle", "m/s", "Speed of the fastest single particle at that time. The flow, a "
             "mean over a map cell, is slower: see largest_flow_speed.", AUDIT),
    Quantity("front", "front, from the first centre of mass", "m", "Where 99.5 % of the mass that has moved lies "
             "behind, in plan along the mean dip of the release, from the centre of mass at the start.", AUDIT),
    Quantity("front_distance", "front, from the top of what moved", "m", "The front, measured from the highest place "
             "that moving snow has left, in plan along the mean dip of the release. A straight line, unlike the "
             "run-out, which follows the thalweg.", AUDIT),
    Quantity("removed_particles", "particles that left", "1", "Particles that left the domain or were taken out.",
             AUDIT),
    Quantity("removed_mass", "mass that is gone", "kg", "Mass that left the domain, or that a cut or a removal took.",
             AUDIT),
    Quantity("taken_mass", "mass that was taken out", "kg", "The part of removed_mass that a cut or a removal took.",
             AUDIT),
    Quantity("entrained_mass", "snow cover taken up", "kg", "Mass of snow cover that the flow took up since the start.",
             AUDIT),
    Quantity("laid_mass", "snow laid down", "kg", "Mass that the flow has laid down since the start: stopped by trees, "
             "or come to rest and ground since then.", AUDIT),
    Quantity("water_mass", "water in the pores", "kg", "Mass of water in the particles; part of their mass.", AUDIT),
    Quantity("drained_water", "water that drained", "kg", "Mass of water that left through drained borders since the "
             "start, less what came in.", AUDIT),
    Quantity("added_water", "water from rain", "kg", "Mass of water that rain and melt added since the start.", AUDIT),
    Quantity("removed_water", "water that is gone", "kg", "The part of removed_mass that is water.", AUDIT),
    Quantity("water_residual", "water residual", "1", "What is left open of the balance of water, over its largest "
             "term.", AUDIT),
    Quantity("water_work", "work of pore water", "J", "Work of the pore pressure on the skeleton since the start, and "
             "energy of the water that it took in from elsewhere.", AUDIT),
    Quantity("rigid_energy", "energy of free bodies", "J", "Kinetic energy of the free rigid bodies, and M g times "
             "their height above the start.", AUDIT),
    Quantity("rigid_momentum_residual", "momentum residual of free bodies", "1", "What is left open of the "
             "momentum balance of the free rigid bodies, over the sizes of its terms.", AUDIT),
    Quantity("rigid_unsettled", "steps with unsettled contact", "1", "Steps since the start in which the contact "
             "impulses of free rigid bodies were cut off before they had settled.", AUDIT),
    Quantity("structure_energy", "energy of structures", "J", "Kinetic and elastic energy of the structures.", AUDIT),
    Quantity("structure_momentum_residual", "momentum residual of structures", "1", "What is left open of the momentum "
             "balance of the structures, over the sizes of its terms.", AUDIT),
    Quantity("structure_rounds", "rounds of coupling", "1", "Rounds since the start in which snow and structures seek "
             "the velocity that both end a step with.", AUDIT),
    Quantity("structure_unsettled", "steps with unsettled coupling", "1", "Steps since the start in which the rounds "
             "were cut off before they agreed.", AUDIT),
    Quantity("contact_lines", "lines of contact", "1", "Lines of nodes across a surface that the snow touched, added "
             "up over the steps since the start. Only with solver.method = implicit and surfaces that rub or let go.",
             AUDIT),
    Quantity("contact_spared", "lines of contact without a state", "1", "Those of contact_lines that neither stick nor "
             "slide, or neither lie nor part, in any way that was found, and that a rule settled: they slide, or are "
             "open.", AUDIT),
    Quantity("unconverged", "stress updates without convergence", "1", "Return maps that did not converge, since the "
             "start.", AUDIT),
    Quantity("plastic_fraction", "yielding particles", "share", "Particles that yielded in the last step, of all.",
             AUDIT),
    Quantity("min_J", "least volume ratio", "1", "Smallest volume of a particle over its volume at the start.", AUDIT),
    Quantity("max_J", "largest volume ratio", "1", "Largest volume of a particle over its volume at the start.", AUDIT),
    Quantity("dt", "time step", "s", "Length of the last step.", AUDIT),
    Quantity("steps", "steps", "1", "Steps since the start.", AUDIT),
    Quantity("particles", "particles", "1", "Particles in the domain.", AUDIT),
    MOVING_SHARE,
    Quantity("total_momentum", "total momentum", "kg m/s", "Sum of m |v|.", MOTION),
    MOMENTUM_SHARE,
)

RASTERS = (
    Quantity("release_depth", "release depth", "m", "Vertical depth of the snow over a map cell at the start.", MAPS),
    Quantity("peak_depth", "peak flow depth", "m", "Largest vertical depth over a map cell at any time: the volume at "
             "the density of the start, by the cell's area.", MAPS),
    Quantity("peak_speed", "peak flow speed", "m/s", "Largest mean speed over a map cell, weighted by mass, while the "
             "flow was at least flow_depth deep.", MAPS),
    Quantity("peak_pressure", "peak pressure ρv²", "Pa", "Largest ρv² over a map cell, with the density of the start "
             "and the mean of v² over the mass, while the flow was at least flow_depth deep. Without the factor of an "
             "obstacle's shape.", MAPS),
    Quantity("deposit_depth", "depth at the end", "m", "Vertical depth over a map cell at the end of the run, moving "
             "or not, at the density of the start.", MAPS),
    Quantity("peak_thickness", "peak flow thickness", "m", "Largest thickness of the flow, normal to the ground: "
             "peak_depth times the mean cosine of the ground's slope over the map cell. The normal distance where the "
             "surface of the flow is parallel to the ground.", MAPS),
    Quantity("deposit_thickness", "thickness at the end", "m", "deposit_depth times the mean cosine of the ground's "
             "slope over the map cell.", MAPS),
    Quantity("peak_momentum", "peak momentum hv", "m2/s", "Largest thickness normal to the ground times mean speed "
             "over a map cell, while the flow was at least flow_depth deep: what flows past a metre of width.", MAPS),
    Quantity("arrival_time", "arrival time", "s", "When the flow first was at least flow_depth deep; 0 in the release.",
             MAPS),
    Quantity("flow_duration", "duration of the flow", "s", "From the arrival time until the flow, at least flow_depth "
             f"deep, was last faster than {MOVING_SPEED:g} m/s; as long as the run at most.", MAPS),
)

PASSED = (
    Quantity("passed_east", "volume that passed, to the east", "m2", "Time integral of the depth times the velocity to "
             "the east: the volume that crossed a metre of a line to the north.", MAPS),
    Quantity("passed_north", "volume that passed, to the north", "m2", "As passed_east, to the north.", MAPS),
)
"""Rasters that a run keeps for its gauges: they are no maps of their own."""

OVER_TIME = (
    Quantity("momentary_depth", "flow depth", "m", "Vertical depth of the snow over a map cell at a time, at the "
             "density of the start; of columns, the mean of their depths.", "snowmpm.io.flow_maps"),
    Quantity("momentary_speed", "flow speed", "m/s", "Mean speed over a map cell at a time, weighted by volume, where "
             "the snow is at least flow_depth deep.", "snowmpm.io.flow_maps"),
)

NUMBERS = (
    Quantity("release_area", "release area", "m2", "Plan area of the snow at the start: of the polygons that it was "
             "given by, or what its particles cover.", HAZARD),
    Quantity("release_volume", "release volume", "m3", "Volume of the snow at the start.", HAZARD),
    Quantity("release_mass", "release mass", "kg", "Mass of the snow at the start.", HAZARD),
    Quantity("affected_area", "affected area", "m2", "Plan area where the flow once was at least flow_depth deep.",
             HAZARD),
    *(Quantity(f"area_above_{p / 1e3:g}_kPa", f"affected area above {p / 1e3:g} kPa", "m2", "The part of the affected "
               f"area where the peak pressure reached {p / 1e3:g} kPa.", HAZARD) for p in PRESSURES),
    Quantity("largest_flow_depth", "largest flow depth", "m", "Largest value of the map peak_depth.", HAZARD),
    Quantity("largest_flow_speed", "largest flow speed", "m/s", "Largest value of the map peak_speed: a mean over a "
             "map cell, below the fastest particle (max_speed).", HAZARD),
    Quantity("largest_flow_pressure", "largest pressure ρv²", "Pa", "Largest value of the map peak_pressure.", HAZARD),
    Quantity("deposit_area", "deposit area", "m2", "Plan area with at least flow_depth of snow at the end, moving or "
             "not.", HAZARD),
    Quantity("deposit_volume", "deposit volume, at release density", "m3", "Volume that the snow in the domain at the "
             "end would have at its density at the start. The deposit itself is denser or looser.", HAZARD),
    Quantity("deposit_mass", "deposit mass", "kg", "Mass of the snow in the domain at the end, moving or not.", HAZARD),
    Quantity("deposit_mean_depth", "mean depth of the deposit", "m", "Mean of the map deposit_depth over the deposit "
             "area.", HAZARD),
    Quantity("flow_depth", "least depth of a flow", "m", "A tenth of the mean release depth: what is thinner counts as "
             "scattered grains.", HAZARD),
    MOVING_SHARE,
    MOMENTUM_SHARE,
    Quantity("left_share", "mass that left the model", "share", "Mass that left over an open side or the edge of the "
             "terrain, over the mass at the start.", HAZARD),
    Quantity("top", "height of the release's top", "m", "Height of the highest ground under the release.", HAZARD, 1),
    Quantity("runout", "run-out", "m", "Length in plan of the thalweg: the way down that took the snow least time, "
             "from the top of the release to the run-out point.", HAZARD),
    Quantity("fall", "fall", "m", "Height of the release's top above the ground at the run-out.", HAZARD),
    Quantity("travel_angle", "travel angle", "degrees", "atan(fall / run-out), the Fahrböschung.", HAZARD, 1),
    Quantity("runout_x", "run-out point, east", "m", "Place in the deposit, in map coordinates, behind which 99 % of "
             "the snow lies along the ways down: the middle of the tongue there that has most snow.", HAZARD, 1),
    Quantity("runout_y", "run-out point, north", "m", "As runout_x.", HAZARD, 1),
    Quantity("runout_z", "run-out point, height", "m", "Height of the ground at the run-out point.", HAZARD, 1),
    Quantity("deposit_reach", "reach of the deposit", "m", "Length in plan, along the thalweg, from the top of the "
             "release to the furthest corner of the deposit.", HAZARD),
    Quantity("deposit_reach_x", "furthest deposit, east", "m", "Place of the deposited cell furthest along the thalweg,"
             " in map coordinates.", HAZARD, 1),
    Quantity("deposit_reach_y", "furthest deposit, north", "m", "As deposit_reach_x.", HAZARD, 1),
    Quantity("deposit_reach_z", "furthest deposit, height", "m", "Height of the ground there.", HAZARD, 1),
    Quantity("thalweg_dry", "dry share of the thalweg", "share", "Share of the thalweg outside of the affected area.",
             HAZARD),
    Quantity("thalweg_climb", "climb of the thalweg", "m", "Largest height of the thalweg's ground above the lowest "
             "place before it.", HAZARD),
    Quantity("reach_of_flow", "reach of the flow", "m", "Length in plan, along the thalweg and straight on, from "
             "the top of the release to the furthest corner of the affected area.", HAZARD),
    *(Quantity(f"reach_of_{p / 1e3:g}_kPa", f"reach of {p / 1e3:g} kPa", "m", "Length in plan, along the thalweg, from "
               "the top of the release to the furthest corner of the part of the affected area where the peak pressure "
               f"reached {p / 1e3:g} kPa.", HAZARD) for p in PRESSURES),
    *powder.NUMBERS,
)

IMPACT = (
    Quantity("impact_arrival", "arrival at the obstacle", "s", "When 1 % of the impulse along the load has been given.",
             LOADS),
    Quantity("impact_peak_force", "early peak of the force", "N", "Largest force of the snow on the obstacle along the "
             "load, a mean over 2 % of the time that the load lasts; of a depth-averaged flow the largest of the "
             "record. Per metre of width in 2-D.", LOADS),
    Quantity("impact_peak_time", "time of the peak", "s", "When the early peak of the force begins.", LOADS),
    Quantity("impact_peak_pressure", "early peak, over the wetted area", "Pa", "The early peak of the force, over the "
             "wetted area at that time.", LOADS),
    Quantity("impact_steady_force", "steady part of the force", "N", "Mean force along the load while the middle half "
             "of the impulse is given. Per metre of width in 2-D.", LOADS),
    Quantity("impact_steady_pressure", "steady part, over the wetted area", "Pa", "The steady part of the force, over "
             "the mean wetted area of that time.", LOADS),
    Quantity("impact_impulse", "impulse on the obstacle", "N s", "Impulse that the snow gave the obstacle along the "
             "load. Per metre of width in 2-D.", LOADS),
    Quantity("wetted_area", "wetted area, at most", "m2", "Area, seen along the load, of the part of the obstacle's "
             "face that snow touches: where particles are closer than two of their spacings; of a depth-averaged flow "
             "its vertical depth times the width of the obstacle. In 2-D a length.", LOADS),
    Quantity("face_area", "whole face of the obstacle", "m2", "Area of the whole obstacle seen along the load, what is "
             "in the ground included. In 2-D a length.", LOADS),
)

GAUGES = (
    Quantity("gauge_arrival", "arrival at the gauge", "s", "Least arrival time in the map cells that the line runs "
             "through, or that the point lies in; none where the flow was never flow_depth deep.", GAUGED),
    Quantity("gauge_duration", "duration at the gauge", "s", "From the arrival there until the flow on it, at least "
             f"flow_depth deep, was last faster than {MOVING_SPEED:g} m/s; as long as the run at most.", GAUGED),
    Quantity("gauge_depth", "largest depth at the gauge", "m", "Largest peak_depth in its map cells.", GAUGED),
    Quantity("gauge_speed", "largest speed at the gauge", "m/s", "Largest peak_speed in its map cells.", GAUGED),
    Quantity("gauge_pressure", "largest ρv² at the gauge", "Pa", "Largest peak_pressure in its map cells.",
             GAUGED),
    Quantity("gauge_momentum", "largest hv at the gauge", "m2/s", "Largest peak_momentum in its map cells.",
             GAUGED),
    Quantity("gauge_discharge", "largest discharge", "m3/s", "Largest volume per time that crosses the line in a "
             "frame; positive to the side to which more passed in all.", GAUGED),
    Quantity("gauge_volume", "volume that passed", "m3", "Volume that crossed the line, at the density of the start, "
             "less what came back: a sum over the steps of the run.", GAUGED),
    Quantity("gauge_both_ways", "volume that crossed either way", "m3", "As gauge_volume, with what came back added.",
             GAUGED),
    Quantity("gauge_frames", "volume by the frames", "m3", "Integral of the discharge over time. Off gauge_volume by "
             "more than 5 % of gauge_both_ways, the discharge is doubtful: frames are too far apart.", GAUGED),
)

PATH = (
    Quantity("path_runout", "run-out along the path", "m", "Length in plan, from the upper end of the path, to the "
             "last cross-section on which the peak pressure exceeds 1 kPa: sRunout of AvaFrame's AIMEC. The path is "
             "the one that is given, else the thalweg, extended straight by 0.3 of its length.", ALONG),
    Quantity("path_runout_x", "run-out along the path, east", "m", "Place of the largest peak pressure on that "
             "cross-section.", ALONG, 1),
    Quantity("path_runout_y", "run-out along the path, north", "m", "As path_runout_x.", ALONG, 1),
    Quantity("path_delta", "length that was reached", "m", "From the first such cross-section to the last: deltaSXY "
             "of AIMEC.", ALONG),
    Quantity("path_fall", "fall along the path", "m", "Height of the path at the first above that at the last: deltaZ "
             "of AIMEC.", ALONG),
    Quantity("path_angle", "run-out angle", "degrees", "atan(path_fall / path_delta): runoutAngle of AIMEC.", ALONG, 1),
    Quantity("path_area", "area of the ground above 1 kPa", "m2", "Area of the ground, not in plan, where the peak "
             "pressure exceeds 1 kPa, within 300 m of the path.", ALONG),
    Quantity("path_pressure", "largest pressure ρv² on cross-sections", "Pa", "Largest peak_pressure on cross-sections "
             "of the path, 600 m wide, linear between map cells: maxpprCrossMax of AIMEC.", ALONG),
    Quantity("path_thickness", "largest thickness on cross-sections", "m", "As path_pressure, of peak_thickness: "
             "maxpftCrossMax.", ALONG),
    Quantity("path_speed", "largest speed on cross-sections", "m/s", "As path_pressure, of peak_speed: maxpfvCrossMax.",
             ALONG),
)

RENAMED = {"runout": "front_distance"}
"""Old names of columns of the history, and their new names."""

OLD_NUMBERS = {"largest_depth": "largest_flow_depth", "largest_speed": "largest_flow_speed",
               "largest_pressure": "largest_flow_pressure"}
"""Old names of hazard numbers, and their new names."""

POWDER_LAYER = (*powder.HISTORY, *powder.RASTERS)
"""Columns of the history and maps of flows with a powder layer."""

QUANTITIES = {one.name: one for one in (*HISTORY, *RASTERS, *POWDER_LAYER, *PASSED, *OVER_TIME, *NUMBERS, *IMPACT,
                                        *GAUGES, *PATH, *SAW_TEST)}
"""All quantities by name."""


def quantity(name, unit="", dimension=3):
    """The quantity of this name; if the table lacks it, one without definition, labelled by its name. dimension: of the
    run; in 2-D amounts are per metre of width."""
    found = QUANTITIES.get(name) or Quantity(name, name.replace("_", " "), unit or "1", "", "")
    return found if dimension == 3 else replace(found, unit=per_width(found.unit))


def units_of(quantities):
    """name -> unit as stored in files; a share has none."""
    return {one.name: "1" if one.unit == "share" else one.unit for one in quantities}


def renamed(values, names):
    """A dict with its old names replaced."""
    return {names.get(name, name): value for name, value in values.items()}
