"""A disk that fills up in the middle of a run: a clear message, whole files, and the run goes on when there is room."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import snowmpm
from tests.support.same_runs import assert_same_runs

CAN_MOUNT = shutil.which("unshare") and not subprocess.run(
    ["unshare", "-m", "true"], stderr=subprocess.DEVNULL, check=False).returncode


@pytest.mark.skipif(not CAN_MOUNT, reason="no right to mount a small disk")
@pytest.mark.parametrize("sizes", [(20, 90, 150), pytest.param(range(1, 230, 6), marks=pytest.mark.slow)],
                         ids=["some", "all"])
def test_small_disk(whole, tmp_path, sizes):
    script = [sys.executable, Path(__file__).with_name("full_disk.py"), tmp_path, *map(str, sizes)]
    done = subprocess.run(["unshare", "-m", *script], capture_output=True, text=True, check=True)
    times, codes = snowmpm.Run(whole).times, []
    for size, line in zip(sizes, done.stdout.splitlines(), strict=True):
        code, message, readable, second, again = json.loads(line)
        codes.append(code)
        assert readable == times[: len(readable)].tolist()
        if code:
            text = message[message.find("error: "):].splitlines()  # after the lines of progress
            assert code == 1 and "Traceback" not in message and "unexpected" not in message
            assert len(text) == 2 and text[0].startswith("error: ")
            assert "No space left on device" in message
            assert "last checkpoint: " in message or "no checkpoint was written" in message
            if readable:
                assert f"frames up to t = {readable[-1]:.6g} s are safe" in message
        assert second == 0, again
        assert_same_runs(whole, tmp_path / str(size))
    assert 1 in codes
