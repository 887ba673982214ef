"""A sheet of snow on a raster by AvaFrame's com1DFA, depth-averaged, with Coulomb friction alone.

    avaframe_line.py FOLDER FRICTION CELL

FOLDER holds Inputs/dem.asc and Inputs/REL/release.shp as AvaFrame wants them. One line of JSON on stdout: processor
seconds and steps of its time loop, and where each of its particles began and ended along x.
"""

import json
import pickle
import sys
import time
from pathlib import Path

import numpy as np
from avaframe.com1DFA import com1DFA
from avaframe.in3Utils import cfgUtils

FOLDER, FRICTION, CELL = Path(sys.argv[1]), sys.argv[2], sys.argv[3]
CHANGED = {"simTypeList": "null", "resType": "ppr|pft|pfv|particles", "tSteps": "0", "relThFromFile": "False",
           "relTh": "1.0", "frictModel": "coulomb", "mucoulomb": FRICTION, "meshCellSize": CELL,
           "sphKernelRadius": CELL}
"""Of AvaFrame's defaults."""


def timed(iterate, seconds):
    """`iterate`, whose processor seconds are put into a list."""
    def run(*arguments, **options):
        begun = time.process_time()
        found = iterate(*arguments, **options)
        seconds.append(time.process_time() - begun)
        return found
    return run


def main():
    main_cfg = cfgUtils.getGeneralConfig()
    main_cfg["MAIN"]["avalancheDir"] = str(FOLDER)
    cfg = cfgUtils.getModuleConfig(com1DFA, str(FOLDER), toPrint=False, onlyDefault=True)
    cfg["GENERAL"].update(CHANGED)
    seconds = []
    com1DFA.DFAIterate = timed(com1DFA.DFAIterate, seconds)
    simulations, out, inputs, _ = com1DFA.com1DFAPreprocess(main_cfg, cfg)
    com1DFA.com1DFACoreTask(simulations, inputs, str(FOLDER), out, next(iter(simulations)))
    states = []
    for file in (FOLDER / "Outputs" / "com1DFA" / "particles").glob("*.pickle"):
        with open(file, "rb") as stream:
            states.append(pickle.load(stream))
    states.sort(key=lambda state: state["t"])
    begin, end = (np.asarray(state["x"]) + state["xllcenter"] for state in (states[0], states[-1]))
    steps = round(states[-1]["t"] / cfg["GENERAL"].getfloat("dt"))
    print("\nROW " + json.dumps({"seconds": seconds[0], "steps": steps, "begin": begin.tolist(), "end": end.tolist()}))


main()
