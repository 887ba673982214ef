"""In a notebook: cells that compute, kernels of a cell's own, and the button that interrupts."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("ipykernel", reason="a notebook's kernel is in the dev extra")
from jupyter_client import BlockingKernelClient
from jupyter_client.connect import write_connection_file

from tests.support.usual_signals import usual_signals

TESTS = Path(__file__).parents[1]
LIMIT = 600

STEPS = f"""
import snowmpm, numpy as np
simulation = snowmpm.Simulation(snowmpm.load_scene({str(TESTS / 'cli' / 'block.toml')!r}))
for _ in range(3):
    simulation.step()
print(simulation.solver.steps)
"""

OWN_KERNEL = """
import taichi as ti

@ti.kernel
def doubled(x: ti.types.ndarray(dtype=ti.f64, ndim=1)):
    for i in x:
        x[i] *= FACTOR

values = np.arange(3.0)
doubled(values)
simulation.step()
print(values.tolist(), simulation.solver.steps)
"""

LONG = f"""
def tell(report):
    print(report.frames, flush=True)

scene = snowmpm.load_scene({str(TESTS / 'resume' / 'killed.toml')!r}, {{"end_time": 1000.0}})
snowmpm.run(scene, "run", tell)
"""


@pytest.fixture
def notebook(tmp_path):
    """(kernel's process, client) of a notebook in an empty folder."""
    file, _ = write_connection_file(str(tmp_path / "kernel.json"))
    paths = os.pathsep.join([str(TESTS.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    with usual_signals():
        process = subprocess.Popen([sys.executable, "-m", "ipykernel_launcher", "-f", file], cwd=tmp_path,
                                   env={**os.environ, "PYTHONPATH": paths}, start_new_session=True,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    client = BlockingKernelClient(connection_file=file)
    client.load_connection_file()
    client.start_channels()
    try:
        client.kernel_info(reply=True, timeout=LIMIT)  # wait_for_ready gives up on a kernel that starts slowly
        yield process, client
    finally:
        client.stop_channels()
        process.kill()
        process.wait()


@pytest.mark.slow
def test_cells(notebook):
    process, client = notebook
    printed = []

    def listen(message):
        if message["msg_type"] == "stream" and message["content"]["name"] == "stdout":
            printed.extend(line for line in message["content"]["text"].splitlines() if "[Taichi]" not in line)

    def run(cell):
        printed.clear()
        return client.execute_interactive(cell, timeout=LIMIT, output_hook=listen)["content"]

    def interrupt(message):
        before = len(printed)
        listen(message)
        if before == 0 < len(printed):  # once: a second time ends it without its checkpoint
            os.kill(process.pid, signal.SIGINT)

    assert run(STEPS)["status"] == "ok" and printed == ["3"]
    for factor, found in ((2, "[0.0, 2.0, 4.0] 4"), (3, "[0.0, 3.0, 6.0] 5")):  # the same cell, edited
        assert run(OWN_KERNEL.replace("FACTOR", str(factor)))["status"] == "ok" and printed == [found]
    printed.clear()
    ended = client.execute_interactive(LONG, timeout=LIMIT, output_hook=interrupt)["content"]
    assert ended["ename"] == "KeyboardInterrupt", ended
    assert run("print(len(snowmpm.Run('run')) > 0)")["status"] == "ok" and printed == ["True"]
    assert run("simulation.step(); print(simulation.solver.steps)")["status"] == "ok" and printed == ["6"]
