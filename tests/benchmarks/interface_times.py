"""Time of saw tests whose weak layer is an interface on cells of 25 cm, over that of the layer resolved by 2.5 cm.

    python tests/benchmarks/interface_times.py [CASE ...]

Processor time of the steps of one thread, in turn in one process, with bins of 5 cm in both (10 points a cell); after
a coarse run that loads kernels. Prints a line a case of `tests/components/interface_layer/saw_tests.py`: seconds of
both, median of three coarse runs, their ratio, and the speeds of the crack [m/s]. Twenty times less was asked.
"""

import sys
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from snowmpm.compiler import runtime
from tests.components.interface_layer.saw_tests import CASES, cracked

COARSE, FINE, POINTS = 0.25, 0.025, 10


def coarse(case):
    return cracked(case, COARSE, True, points=POINTS)


def main():
    runtime.start("cpu", threads=1)
    for name in sys.argv[1:] or ("S2 runs", "S4"):
        case = CASES[name]
        coarse(case)
        runs = [coarse(case), coarse(case)]
        resolved = cracked(case, FINE, False)
        runs.append(coarse(case))
        seconds = median(one["seconds"] for one in runs)
        print(f"{name}: {resolved['seconds']:.2f} s resolved, {seconds:.3f} s on {COARSE} m:"
              f" {resolved['seconds'] / seconds:.1f} times; {resolved['crack_speed']:.1f} and"
              f" {runs[0]['crack_speed']:.1f} m/s", flush=True)


if __name__ == "__main__":
    main()
