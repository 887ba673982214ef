"""Where a step spends its time: each kernel of a scene, by Taichi's own clock, on one thread.

    python tests/benchmarks/step_profile.py SCENE TIME STEPS [KEY=VALUE ...]

Runs SCENE to TIME [s], then STEPS steps. Prints, for each kernel that is launched in every step, nanoseconds a
particle: the shortest launch, which other programs disturb least, and the mean. For two versions, run it in two
checkouts.
"""

import json
import os
import re
import sys
import warnings

os.environ["TI_KERNEL_PROFILER"] = "1"


def main():
    warnings.simplefilter("ignore")
    import taichi as ti

    import snowmpm
    from snowmpm.compiler import runtime
    from snowmpm.scenes import load_scene

    scene, time, steps = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
    changes = {key: json.loads(value) for key, value in (part.split("=", 1) for part in sys.argv[4:])}
    runtime.start("cpu", 1)
    simulation = snowmpm.Simulation(load_scene(scene, changes))
    while simulation.solver.time < time:
        simulation.step()
    for _ in range(5):
        simulation.step()
    ti.profiler.clear_kernel_profiler_info()
    for _ in range(steps):
        simulation.step()
    count = simulation.solver.particles.count
    found = {}
    profiler = ti.lang.impl.get_runtime().prog
    ti.sync()
    for record in profiler.get_kernel_profiler_records():
        name = re.sub(r"_c\d+_\d+_kernel_\d+_\w+$", "", record.name)
        found.setdefault(name, {}).setdefault(record.name, []).append(1e6 * record.kernel_time / count)
    print(f"{scene}: {count} particles, {steps} steps; ns a particle: shortest, mean")
    rows = []
    for name, parts in found.items():
        every = [values for values in parts.values() if len(values) >= steps]
        if every:
            mean = sum(sum(values) / len(values) for values in every)
            rows.append((name, sum(min(values) for values in every), mean))
    for name, least, mean in sorted(rows, key=lambda row: -row[1]):
        if least >= 0.05:
            print(f"{name:30s}{least:8.1f}{mean:8.1f}")
    print(f"{'all':30s}{sum(row[1] for row in rows):8.1f}{sum(row[2] for row in rows):8.1f}")


if __name__ == "__main__":
    main()
