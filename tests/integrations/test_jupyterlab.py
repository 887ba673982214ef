"""Runs in JupyterLab itself, in a browser: the table and picture of a run, its pictures, its view in motion, the bar.

It needs Chromium (apt-get install chromium), JupyterLab and Playwright (pip install jupyterlab playwright).
"""

import importlib.util
import os
import shutil
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
MISSING = [name for name in ("jupyterlab", "playwright", "nbformat") if importlib.util.find_spec(name) is None]
pytestmark = [pytest.mark.slow, pytest.mark.skipif(
    CHROMIUM is None or bool(MISSING), reason="needs Chromium, and pip install jupyterlab playwright")]
SOFTWARE = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
CELLS = ("""import snowmpm
scene = snowmpm.load_scene("avalanche_depth_averaged", {"solver.dx": 20.0, "end_time": 20.0})
run = snowmpm.run(scene, "runs/valley")
run""", "run.plot()", "run.show()")


@contextmanager
def server(folder):
    """JupyterLab over a folder, on a port of this machine; yields the address."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = ["--no-browser", "--allow-root", f"--port={port}", "--ip=127.0.0.1", "--IdentityProvider.token=t",
             f"--ServerApp.root_dir={folder}", "--LabApp.news_url=None", "--LabApp.check_for_updates_class="
             "jupyterlab.NeverCheckForUpdate"]
    home = {"JUPYTER_CONFIG_DIR": str(folder / ".config"), "JUPYTER_DATA_DIR": str(folder / ".data"),
            "JUPYTER_RUNTIME_DIR": str(folder / ".runtime")}
    surroundings = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    command = [sys.executable, "-m", "jupyterlab", *words]
    with open(folder / "server.txt", "w") as log, subprocess.Popen(
            command, stdout=log, stderr=log, env={**surroundings, **home}) as child:
        try:
            for _ in range(120):
                try:
                    socket.create_connection(("127.0.0.1", port)).close()
                    break
                except OSError:
                    time.sleep(0.5)
            yield f"http://127.0.0.1:{port}"
        finally:
            child.terminate()


def test_a_run_in_jupyterlab(tmp_path):
    import nbformat
    from playwright.sync_api import sync_playwright

    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    nbformat.write(nbformat.v4.new_notebook(metadata=kernel, cells=[nbformat.v4.new_code_cell(one) for one in CELLS]),
                   tmp_path / "a.ipynb")
    with server(tmp_path) as address, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=list(SOFTWARE))
        page, said = browser.new_page(viewport={"width": 1400, "height": 1000}), []
        page.on("pageerror", lambda error: said.append(str(error)))
        page.goto(f"{address}/lab/tree/a.ipynb?token=t")
        page.wait_for_selector(".jp-Notebook", timeout=120_000)
        page.wait_for_selector("text=Python 3 (ipykernel) | Idle", timeout=120_000)
        page.click(".jp-Notebook")
        page.click(".lm-MenuBar >> text=Run")
        page.click("text=Run All Cells")
        frame = page.wait_for_selector("iframe[srcdoc]", timeout=180_000, state="attached")
        inner = frame.content_frame()
        inner.wait_for_selector("[data-ready=yes]", timeout=120_000)
        outputs = [one.inner_html() for one in page.query_selector_all(".jp-OutputArea-output")]
        assert "<progress" in outputs[0] and "done in" in outputs[0]
        assert "<table>" in outputs[1] and "<img" in outputs[1]
        assert outputs[2].count("<img") == 2 and "<iframe" in outputs[3]
        assert page.query_selector("[data-mime-type='application/vnd.jupyter.stderr']") is None
        frame.scroll_into_view_if_needed()
        time.sleep(2.0)
        picture = Path(tmp_path / "view.png")
        frame.screenshot(path=str(picture))
        assert said == []
        browser.close()
    import imageio.v2 as imageio
    import numpy as np

    colours = np.unique(imageio.imread(picture)[..., :3].reshape(-1, 3), axis=0)
    assert len(colours) > 2000  # sky, snow and ground, not an empty frame
