"""Numbers of a powder cloud: columns of the history, maps, and numbers beside those of an avalanche."""

from snowmpm.quantities.classes import PRESSURES
from snowmpm.quantities.quantity import Quantity

ROW, MAPS = "snowmpm.running.audit", "snowmpm.running.recorder"
"""What asks the component for them."""
EXPERIMENT = "_experiment"
"""How names of maps and numbers end that no measurement stands behind."""
DILUTE = 50.0
"""Density [kg/m3] up to which a cloud is taken as dilute: about that of the densest ones near a core."""
WHERE = "while the cloud was at least 0.5 m high and 0.1 kg/m³ heavier than air"
NOT_MEASURED = "An experiment: no measured avalanche was compared with it."

HISTORY = (
    Quantity("suspended_mass", "snow from the flow into the cloud", "kg", "Mass of ice that went from the flow into "
             "the cloud since the start.", ROW),
    Quantity("settled_mass", "snow from the cloud into the flow", "kg", "Mass of ice that fell out of the cloud into "
             "the moving flow since the start; what fell on the ground is cloud_laid_mass.", ROW),
    Quantity("cloud_laid_mass", "snow from the cloud on the ground", "kg", "Mass of ice that fell out of the cloud "
             "where no flow moved under it, and of clouds that went over into the air. In no map of a deposit.", ROW),
    Quantity("cloud_cover_mass", "snow cover that the cloud took up", "kg", "Mass of snow cover that the cloud took up "
             "by itself since the start.", ROW),
    Quantity("cloud_left_mass", "ice of the cloud that left", "kg", "Mass of ice that left the model with the cloud "
             "since the start.", ROW),
    Quantity("cloud_ice_mass", "ice in the cloud", "kg", "Mass of ice in the cloud.", ROW),
    Quantity("cloud_air_volume", "air in the cloud", "m3", "Volume of air in the cloud.", ROW),
    Quantity("cloud_air_taken_in", "air that the cloud took in", "m3", "Volume of air that the cloud took in since the "
             "start.", ROW),
    Quantity("cloud_momentum", "momentum of the cloud", "kg m/s", "Size of the cloud's momentum, its air included.",
             ROW),
    *(Quantity(f"cloud_momentum_{axis}", f"momentum of the cloud along {axis}", "kg m/s", "Momentum of the cloud, its "
               "air included.", ROW) for axis in "xyz"),
    Quantity("cloud_energy", "energy from the cloud", "J", "Kinetic and potential energy that the flow got of the "
             "cloud since the start; negative, since it gives it snow and momentum.", MAPS),
    *(Quantity(f"cloud_{one}_residual", f"{one} residual of the cloud", "1", f"What is left open of the balance of "
               f"{one} of the cloud, over its largest term.", ROW) for one in ("ice", "air", "momentum")),
)

RASTERS = (
    Quantity("cloud_peak_height_experiment", "peak height of the cloud (experiment)", "m", "Largest height of the "
             f"powder cloud, normal to the ground, {WHERE}. {NOT_MEASURED}", MAPS),
    Quantity("cloud_peak_pressure_experiment", "peak pressure ρu² of the cloud (experiment)", "Pa", "Largest ρu² of "
             f"the means over the cloud's height, {WHERE}. Without the factor of an obstacle's shape. {NOT_MEASURED}",
             MAPS),
    Quantity("cloud_peak_foot_pressure_experiment", "peak pressure ρu² at the cloud's foot (experiment)", "Pa",
             f"Largest ρu² at the foot of the cloud's assumed profile, {WHERE}. {NOT_MEASURED}", MAPS),
    Quantity("cloud_peak_speed_experiment", "peak speed of the cloud (experiment)", "m/s", "Largest mean speed over "
             f"the cloud's height, {WHERE}. {NOT_MEASURED}", MAPS),
)

NUMBERS = (
    Quantity("largest_cloud_height_experiment", "largest height of the cloud (experiment)", "m", "Largest value of the "
             "map cloud_peak_height_experiment.", MAPS),
    Quantity("largest_cloud_pressure_experiment", "largest pressure ρu² of the cloud (experiment)", "Pa", "Largest "
             "value of the map cloud_peak_pressure_experiment.", MAPS),
    Quantity("largest_cloud_density_experiment", "largest density of the cloud (experiment)", "kg/m3", "Largest mean "
             f"density over the cloud's height, {WHERE}. A cloud of more than {DILUTE:g} kg/m³ is not dilute.", MAPS),
    Quantity("largest_cloud_speed_experiment", "largest speed of the cloud (experiment)", "m/s", "Largest value of the "
             "map cloud_peak_speed_experiment.", MAPS),
    *(Quantity(f"cloud_area_above_{p / 1e3:g}_kPa_experiment", f"area of the cloud above {p / 1e3:g} kPa (experiment)",
               "m2", f"Plan area where cloud_peak_pressure_experiment reached {p / 1e3:g} kPa.", MAPS)
      for p in PRESSURES),
)
