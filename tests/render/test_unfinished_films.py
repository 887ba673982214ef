"""What is left of a film that is cut: by Ctrl-C, by the death of the program, by that of its encoder too."""

import subprocess
import sys
import time

import imageio_ffmpeg
import numpy as np
import pytest
from synthetic_runs import slab_2d

from snowmpm.io import Run
from snowmpm.render import render_run
from snowmpm.render.film import open_film
from snowmpm.render.mp4 import unfinished

SIZE = (160, 90)


def picture(i):
    return np.random.default_rng(i).integers(0, 255, (64, 96, 3), np.uint8)


@pytest.mark.parametrize("kind", ["mp4", "gif"])
def test_an_interrupted_film_is_kept_as_far_as_it_came(tmp_path, kind):
    slab_2d(tmp_path / "run", frames=5)
    film = tmp_path / "films" / f"film.{kind}"

    def interrupted(done, total):
        if done == 3:
            raise KeyboardInterrupt

    run = Run(tmp_path / "run")
    with pytest.raises(KeyboardInterrupt, match=rf"the film so far, 3 pictures, is in .*film\.unfinished\.{kind}"):
        render_run(run, film, size=SIZE, fps=10, progress=interrupted)
    assert [path.name for path in film.parent.iterdir()] == [f"film.unfinished.{kind}"]
    assert imageio_ffmpeg.count_frames_and_secs(str(unfinished(film)))[0] == 3
    if kind == "mp4":
        render_run(run, film, size=SIZE, fps=10)
        assert [path.name for path in film.parent.iterdir()] == ["film.mp4"]
        assert imageio_ffmpeg.count_frames_and_secs(str(film))[0] == 5


@pytest.mark.parametrize("kind", ["mp4", "gif"])
@pytest.mark.parametrize("error", [KeyboardInterrupt, ValueError, OSError])
def test_nothing_is_left_of_no_pictures_nor_of_an_error(tmp_path, kind, error):
    with pytest.raises(error), open_film(tmp_path / f"film.{kind}", 10) as show:
        if error is not KeyboardInterrupt:
            show(picture(0))
        raise error
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(sys.platform != "linux", reason="the encoder is found by /proc")
@pytest.mark.parametrize("encoder_too", [False, True])
def test_after_kill_9_the_film_can_be_played(tmp_path, encoder_too):
    """The encoder ends what it has when the program dies; where it dies too, the fragments on the disk are there."""
    film, n = tmp_path / "film.mp4", 240
    script = f"""
import os, time, numpy as np
from pathlib import Path
from snowmpm.render.film import open_film
with open_film({str(film)!r}, 25) as show:
    for i in range({n}):
        show(np.random.default_rng(i).integers(0, 255, (64, 96, 3), np.uint8))
    if {encoder_too}:
        time.sleep(3.0)  # until the encoder has taken them
        for child in Path(f"/proc/{{os.getpid()}}/task/{{os.getpid()}}/children").read_text().split():
            os.kill(int(child), 9)
    os.kill(os.getpid(), 9)
"""
    done = subprocess.run([sys.executable, "-c", script], timeout=120, check=False, stdout=subprocess.DEVNULL)
    assert done.returncode == -9 and not film.exists()
    wanted = n - 90 if encoder_too else n  # it looks ahead by some sixty pictures
    deadline = time.monotonic() + 60.0
    while True:
        count = imageio_ffmpeg.count_frames_and_secs(str(unfinished(film)))[0]
        if count >= wanted or time.monotonic() > deadline:
            break
        time.sleep(0.5)
    assert wanted <= count <= n
