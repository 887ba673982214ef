"""How near a run is to an observed avalanche: the numbers of `snowmpm events score`."""

from snowmpm.quantities.quantity import Quantity

WHERE = "snowmpm.events.scoring"

MISFIT = Quantity("misfit", "misfit", "1", "Root of the mean square of all differences from what was observed, each"
                  " over its uncertainty. Of an area the difference is 1 - success_index, and its uncertainty what is"
                  " left of that where the observed border itself is moved by its uncertainty.", WHERE)
SCORES = (
    MISFIT,
    Quantity("success_index", "critical success index", "share", "Area that is computed and observed, over the area"
             " that is either (Jaccard). Areas are those of map cells and polygons in plan; the computed one is"
             " affected_area.", WHERE),
    Quantity("hit_rate", "hit rate", "share", "Area that is computed and observed, over the observed area.", WHERE),
    Quantity("false_alarm_ratio", "false alarm ratio", "share", "Area that is computed only, over the computed area.",
             WHERE),
    Quantity("area_ratio", "area ratio", "1", "Computed over observed area.", WHERE),
    Quantity("runout_error", "run-out less observed", "m", "Reach of the affected area along the path of the event,"
             " less that of the observed one, or of the place where it stopped: lengths in plan.", WHERE),
    Quantity("angle_error", "travel angle less observed", "degrees", "Angle from the start of the path to its furthest"
             " reached place, computed less observed.", WHERE),
    Quantity("deposit_success_index", "deposit, critical success index", "share", "As success_index, of the deposit:"
             " where at least flow_depth lies at the end.", WHERE),
    Quantity("deposit_ratio", "deposit volume over observed", "1", "deposit_volume over the observed volume. The"
             " computed one is at the density of the release; a deposit is denser.", WHERE),
)
VALUE = Quantity("value_error", "value less measured", "1", "Value of a map at a place, or its largest anywhere, less"
                 " what was measured there, over its standard deviation; 0 above what it was at least.", WHERE)
