"""A sheet of snow on a raster by AvaFrame's com1DFA, depth-averaged, with Coulomb friction alone.

    avaframe_line.py FOLDER FRICTION CELL

FOLDER holds Inputs/dem.asc and Inputs/REL/release.shp as AvaFrame wants them; where its particles began and ended goes
to FOLDER/particles.npz, and one line of JSON on stdout says how many they were, their steps and processor seconds.
"""

import json
import sys
import time

import numpy as np
from avaframe.com1DFA import com1DFA
from avaframe.in3Utils import cfgUtils

FOLDER, FRICTION, CELL = sys.argv[1], sys.argv[2], sys.argv[3]
CHANGED = {"simTypeList": "null", "modelType": "dfa", "resType": "ppr|pft|pfv|particles", "tSteps": "0",
           "relThFromFile": "False", "relTh": "1.0", "frictModel": "coulomb", "mucoulomb": FRICTION,
           "meshCellSize": CELL, "sphKernelRadius": CELL, "explicitFriction": "0", "tEnd": "120"}
"""Of AvaFrame's defaults."""


def timed(iterate, seen):
    """`iterate`, whose processor seconds are put into `seen`."""
    def run(*arguments, **options):
        begun = time.process_time()
        found = iterate(*arguments, **options)
        seen["seconds"] = time.process_time() - begun
        seen["found"] = found
        return found
    return run


def main():
    main_cfg = cfgUtils.getGeneralConfig()
    main_cfg["MAIN"]["avalancheDir"], main_cfg["MAIN"]["nCPU"] = FOLDER, "1"
    cfg = cfgUtils.getModuleConfig(com1DFA, FOLDER, toPrint=False, onlyDefault=True)
    cfg["GENERAL"].update(CHANGED)
    seen = {}
    com1DFA.DFAIterate = timed(com1DFA.DFAIterate, seen)
    simulations, out, inputs, _ = com1DFA.com1DFAPreprocess(main_cfg, cfg)
    com1DFA.com1DFACoreTask(simulations, inputs, FOLDER, out, next(iter(simulations)))
    particles = next(item for item in seen["found"] if isinstance(item, list) and item and isinstance(item[0], dict)
                     and "x" in item[0])
    first, last = particles[0], particles[-1]
    np.savez(f"{FOLDER}/particles.npz", **{f"{name}_{when}": np.asarray(state[name]) for name in ("x", "y", "z", "m")
                                           for when, state in (("begin", first), ("end", last))})
    print("ROW " + json.dumps({"particles": len(first["x"]), "seconds": seen["seconds"], "end": float(last["t"])}))


main()
