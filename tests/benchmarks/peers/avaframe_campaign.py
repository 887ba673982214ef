"""Runs of a campaign by AvaFrame's com1DFA, one for each row of friction and release thickness.

    avaframe_campaign.py FOLDER ROWS CELL OUT

FOLDER holds Inputs/dem.asc and Inputs/REL/release.shp as AvaFrame wants them; ROWS is a CSV table with the columns
run, mu, xi [m/s2], thickness [m]. OUT (.npz) gets the peak pressures [Pa] (runs, rows from north to south, columns),
corner and cell of their raster [m], and the processor seconds of each run. Runs that OUT holds already are kept.
"""

import csv
import shutil
import sys
import time
from pathlib import Path

import numpy as np
import rasterio
from avaframe.com1DFA import com1DFA
from avaframe.in3Utils import cfgUtils

FOLDER, ROWS, CELL, OUT = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3], Path(sys.argv[4])
CHANGED = {"simTypeList": "null", "resType": "ppr", "tSteps": "", "relThFromFile": "False", "frictModel": "Voellmy",
           "meshCellSize": CELL, "sphKernelRadius": CELL}
"""Of AvaFrame's defaults."""


def one(row):
    """Peak pressure [Pa], transform of its raster, processor seconds."""
    main_cfg = cfgUtils.getGeneralConfig()
    main_cfg["MAIN"]["avalancheDir"] = str(FOLDER)
    cfg = cfgUtils.getModuleConfig(com1DFA, str(FOLDER), toPrint=False, onlyDefault=True)
    cfg["GENERAL"].update({**CHANGED, "muvoellmy": row["mu"], "xsivoellmy": row["xi"], "relTh": row["thickness"]})
    outputs = FOLDER / "Outputs" / "com1DFA"
    for old in (outputs, FOLDER / "Work"):
        shutil.rmtree(old, ignore_errors=True)
    begun = time.process_time()
    simulations, out, inputs, _ = com1DFA.com1DFAPreprocess(main_cfg, cfg)
    com1DFA.com1DFACoreTask(simulations, inputs, str(FOLDER), out, next(iter(simulations)))
    seconds = time.process_time() - begun
    path = next(path for path in sorted((outputs / "peakFiles").iterdir()) if "_ppr" in path.name
                and path.suffix in (".asc", ".tif"))
    with rasterio.open(path) as file:
        return 1e3 * np.nan_to_num(np.maximum(file.read(1), 0.0)), file.transform, seconds


def main():
    rows = list(csv.DictReader(ROWS.open()))
    done = dict(np.load(OUT)) if OUT.exists() else {"pressure": [], "seconds": []}
    pressure, seconds = list(done["pressure"]), list(done["seconds"])
    for row in rows[len(pressure):]:
        found, transform, spent = one(row)
        pressure.append(found.astype(np.float32))
        seconds.append(spent)
        np.savez_compressed(OUT, pressure=pressure, seconds=seconds, corner=[transform.c, transform.f],
                            cell=transform.a)
        print(f"{len(pressure)} of {len(rows)}", flush=True)


main()
