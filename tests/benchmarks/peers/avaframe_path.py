"""ISeeSnow's avalanche by AvaFrame's com1DFA.

    avaframe_path.py FOLDER MU CELL [XI]

Coulomb friction MU, or Voellmy with XI [m/s2].

FOLDER holds Inputs/dem.asc and Inputs/REL/release.shp as AvaFrame wants them. One line of JSON on stdout: processor
seconds and steps of the whole run after its imports, and where its peak rasters lie.
"""

import json
import sys
import time
from pathlib import Path

from avaframe.com1DFA import com1DFA
from avaframe.in3Utils import cfgUtils

FOLDER, MU, CELL = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
CHANGED = {"simTypeList": "null", "resType": "ppr|pft|pfv", "tSteps": "", "relThFromFile": "False", "relTh": "1.5",
           "frictModel": "coulomb", "mucoulomb": MU, "meshCellSize": CELL, "sphKernelRadius": CELL}
"""Of AvaFrame's defaults."""
if len(sys.argv) > 4:
    CHANGED |= {"frictModel": "Voellmy", "muvoellmy": MU, "xsivoellmy": sys.argv[4]}


def main():
    main_cfg = cfgUtils.getGeneralConfig()
    main_cfg["MAIN"]["avalancheDir"] = str(FOLDER)
    cfg = cfgUtils.getModuleConfig(com1DFA, str(FOLDER), toPrint=False, onlyDefault=True)
    cfg["GENERAL"].update(CHANGED)
    begun = time.process_time()
    simulations, out, inputs, _ = com1DFA.com1DFAPreprocess(main_cfg, cfg)
    com1DFA.com1DFACoreTask(simulations, inputs, str(FOLDER), out, next(iter(simulations)))
    seconds = time.process_time() - begun
    peaks = sorted(str(path) for path in (FOLDER / "Outputs" / "com1DFA" / "peakFiles").glob("*.asc"))
    peaks += sorted(str(path) for path in (FOLDER / "Outputs" / "com1DFA" / "peakFiles").glob("*.tif"))
    print("\nROW " + json.dumps({"seconds": seconds, "peaks": peaks}))


main()
