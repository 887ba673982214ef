"""A disk that is full to a command: two lines that name the file, exit code 1, no half file, and later all is well."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import snowmpm
from snowmpm.overwriting import LIST

HERE = Path(__file__).parent
CAN_MOUNT = shutil.which("unshare") and not subprocess.run(
    ["unshare", "-m", "true"], stderr=subprocess.DEVNULL, check=False).returncode


@pytest.mark.slow
@pytest.mark.skipif(not CAN_MOUNT, reason="no right to mount a small disk")
def test_every_command_that_writes(tmp_path):
    runs = {name: tmp_path / name for name in ("killed", "ball")}
    for name, folder in runs.items():
        snowmpm.run(snowmpm.load_scene(HERE.parent / "resume" / f"{name}.toml"), folder)
    script = [sys.executable, HERE / "on_small_disk.py", tmp_path, *runs.values()]
    done = subprocess.run(["unshare", "-m", *map(str, script)], stdout=subprocess.PIPE, text=True, check=True)
    refused = {}
    for line in done.stdout.splitlines():
        name, share, code, message, left, again, after, whole = json.loads(line)
        refused[name] = refused.get(name, 0) + bool(code)
        progress = (" so far", " left")  # every ten seconds
        text = [line for line in message.splitlines() if "[shell.py" not in line and not line.endswith(progress)]
        assert code in (0, 1), (name, share, message)
        if code:
            assert len(text) in (1, 2) and text[0].startswith("error: ") and "No space left on device" in text[0], text
            assert str(tmp_path / "disk" / "out") in text[0] and "unfinished" not in text[0], text
        left = {file: size for file, size in left.items() if Path(file).name != LIST}  # which grows with each file
        assert all(whole[file] == size for file, size in left.items()), (name, share, left)  # whole, or not there
        assert after.keys() == whole.keys(), (name, share, after)
        assert again == 0 or not code, (name, share)  # a scene that is there is not made once more
    print({name: f"{count} of 6 disks too small" for name, count in refused.items()})
    assert len(refused) == 11 and min(refused.values()) >= 4


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no file that is always full")
@pytest.mark.parametrize(("arguments", "stream", "code"), [
    (["--version"], "stdout", 1), (["list"], "stdout", 1), (["info", "nothing"], "stderr", 2)])
def test_standard_streams_that_are_full(arguments, stream, code):
    with open("/dev/full", "w") as full:
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, stream: full}
        done = subprocess.run([sys.executable, "-m", "snowmpm", *arguments], text=True, check=False, **streams)
    assert done.returncode == code
    if stream == "stdout":
        assert done.stderr == "error: standard output: No space left on device\n"
