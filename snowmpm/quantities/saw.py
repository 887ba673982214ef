"""Numbers of a propagation saw test: names, units, definitions. In a campaign's table each name begins with `saw_`."""

from snowmpm.quantities.quantity import Quantity

RESULT, PREDICTION = "snowmpm.saw_test.result", "snowmpm.saw_test.prediction"
WEAC = "snowmpm.saw_test.weac"
BEFORE = "saw_"
"""Of the names of a saw test's numbers, where they stand beside other numbers."""
THEORY = "theory_"
"""After `BEFORE`, of what a theory predicts."""

COLUMN_TOO_SHORT = "column too short to tell"
RUN_TOO_SHORT = "run too short to tell"
NOT_HAPPENED = "did not happen"
VOID = "void"
REASONS = {NOT_HAPPENED: "no", COLUMN_TOO_SHORT: "column too short", RUN_TOO_SHORT: "run too short", VOID: "void"}
"""How the reason begins for which a number of a saw test has no value, and in short."""

MEASURED = (
    Quantity("saw_critical_length", "critical length", "m", "Length of the cut, notch included, when the crack began "
             "to run by itself: from there it runs on for two slab thicknesses, faster than three times the saw. In a "
             "shorter column, the tip must outrun the saw to the far end at that speed.", RESULT),
    Quantity("saw_critical_length_resolution", "critical length, ±", "m", "Width of a bin of the record: "
             "saw_test.resolution, two cells when missing. The critical length is known to about this.", RESULT),
    Quantity("saw_crack_speed", "crack speed", "m/s", "Median of the speed over windows of one slab thickness, from "
             "two of them beyond the critical length, or halfway, to two before the end of the crack.", RESULT),
    Quantity("saw_crack_speed_spread", "crack speed, ±", "m/s", "Half of the range that holds two thirds of the speeds "
             "of which crack_speed is the median, and at least what the record resolves: the speed over the number of "
             "its rows in a window.", RESULT),
    Quantity("saw_top_speed", "top speed of the crack", "m/s", "Speed that a tenth of the crack's own path exceeds, "
             "over windows of one slab thickness, without the last two slab thicknesses.", RESULT),
    Quantity("saw_crack_length", "crack length at the end", "m", "Tip of the crack at the end of the run, from the "
             "saw's end of the column.", RESULT),
    Quantity("saw_runs_to_the_end", "runs to the end", "1", "Whether the tip came within one slab thickness, and a "
             "tenth of the column, of its far end.", RESULT),
    Quantity("saw_stopped", "crack stopped", "1", "Whether the tip stood still at the end of the run although at "
             "crack_speed three more bins, or more, would have broken. At the far end it has not stopped.", RESULT),
    Quantity("saw_collapse_height", "collapse height", "m", "Median settlement of the slab at the end, normal to the "
             "slope, from two slab thicknesses beyond the critical length and the saw's cut to two behind the tip.",
             RESULT),
    Quantity("saw_fracture_energy", "fracture energy", "J/m2", "Median work in the weak layer per area until it has "
             "lost its strength, from one slab thickness beyond the critical length to two behind the tip.", RESULT),
    Quantity("saw_plastic_work", "plastic work in the saw test", "J", "Work dissipated in all snow at the end of the "
             "run. Per metre of width in 2-D.", RESULT),
    Quantity("saw_broken_at_rest", "broken before the saw began", "share", "Share of the column whose weak layer had "
             "broken before the saw began. Above 1 % the test is void.", RESULT),
)

PREDICTED = (
    Quantity("saw_theory_normal_stress", "normal stress on the weak layer", "Pa", "By the weight of the slab.",
             PREDICTION),
    Quantity("saw_theory_shear_stress", "shear stress on the weak layer", "Pa", "By the weight of the slab; its "
             "magnitude.", PREDICTION),
    Quantity("saw_theory_maxwell_load", "Maxwell's load", "Pa", "Normal stress below which no collapse propagates on "
             "the flat: the equal-area line of the weak layer's oedometric curve (Ericksen 1975).", PREDICTION),
    Quantity("saw_theory_critical_length_energy", "critical length by energy, rigid weak layer", "m", "Cut at which "
             "the energy that the slab releases reaches the work of collapse (Heierli et al. 2008, "
             "doi:10.1126/science.1153948).", PREDICTION),
    Quantity("saw_theory_critical_length_strength", "critical length by shear strength", "m", "Gaume et al. (2017), "
             "doi:10.5194/tc-11-217-2017.", PREDICTION),
    Quantity("saw_theory_critical_length_weac", "critical length by energy, elastic weak layer", "m", "By WEAC, where "
             "it is installed (Rosendahl & Weissgraeber 2020, doi:10.5194/tc-14-115-2020).", WEAC),
    Quantity("saw_theory_collapse_wave_speed", "speed of a collapse wave on the flat", "m/s", "With the collapse "
             "height that was measured (Heierli 2005, doi:10.1029/2004JF000178).", PREDICTION),
    Quantity("saw_theory_shear_wave_speed", "shear waves of the slab", "m/s", "Speed sqrt(G / rho).", PREDICTION),
    Quantity("saw_theory_plate_wave_speed", "plate waves of the slab", "m/s", "Speed sqrt(E' / rho), E' in plane "
             "strain.", PREDICTION),
    Quantity("saw_theory_fracture_energy", "work of collapse of the whole layer", "J/m2", "Work of the weak layer's "
             "oedometric curve to the end of softening, times its thickness.", PREDICTION),
)

SET_UP = (
    Quantity("saw_saw_speed", "speed of the saw", "m/s", "Speed at which the weak layer is taken away.", RESULT),
    Quantity("saw_saw_start", "start of the saw", "s", "Time at which the saw begins.", RESULT),
    Quantity("saw_saw_length", "length of the whole cut", "m", "Notch included.", RESULT),
    Quantity("saw_notch", "notch", "m", "Length that was cut before the start; part of the critical length.", RESULT),
)

SAW_TEST = (*MEASURED, *PREDICTED, *SET_UP)
