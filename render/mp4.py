"""Films as MP4 that can be played as far as they have come.

While pictures come in, the film grows as FILM.unfinished.mp4, in fragments of half a second: each can be played once it
is on the disk, and the encoder, a program of its own, ends it in good order also when this one is killed. At the end it
is rewritten without fragments, which every player takes, and gets its name.
"""

import subprocess
from contextlib import contextmanager
from pathlib import Path

import imageio.v2 as imageio
import imageio_ffmpeg

from snowmpm.draft import draft

QUALITY = "20"  # of H.264: constant rate factor, 18 is visually lossless
FRAGMENT = "500000"  # microseconds of film
COPY_TIMEOUT = 600.0  # s


def unfinished(path):
    """Path of a film that is not finished: FILM.unfinished.mp4."""
    path = Path(path)
    return path.with_name(f"{path.stem}.unfinished{path.suffix}")


@contextmanager
def open_mp4(path, fps):
    """A function that takes one picture (height, width, 3) uint8 after the other.

    Raises OSError when the film cannot be written, and then leaves nothing; at Ctrl-C or SIGTERM KeyboardInterrupt,
    which names the film so far.
    """
    begun, pictures = unfinished(path), 0

    def show(picture):
        nonlocal pictures
        writer.append_data(picture)
        pictures += 1

    try:
        with draft(path) as part:
            writer = _encoder(begun, fps)
            try:
                yield show
            finally:  # of itself imageio leaves it open when it is interrupted, until the garbage is collected
                writer.close()
            _without_fragments(begun, part, pictures)
    except KeyboardInterrupt as interruption:
        if not pictures:
            begun.unlink(missing_ok=True)
            raise
        raise film_so_far(begun, pictures) from interruption
    except BaseException:
        begun.unlink(missing_ok=True)
        raise
    begun.unlink(missing_ok=True)


def film_so_far(path, pictures):
    """The interruption that tells where the film so far is."""
    return KeyboardInterrupt(f"interrupted; the film so far, {pictures} picture{'s' * (pictures != 1)}, is in {path};"
                             " the same command draws it anew (with --from TIME only the rest)")


def _encoder(path, fps):
    fragments = ["-movflags", "+empty_moov+default_base_moof", "-frag_duration", FRAGMENT, "-flush_packets", "1"]
    return imageio.get_writer(
        path,
        format="FFMPEG",
        mode="I",
        fps=fps,
        codec="libx264",
        pixelformat="yuv420p",
        macro_block_size=2,
        output_params=["-crf", QUALITY, "-preset", "medium", *fragments],
        ffmpeg_log_level="quiet",
    )


def _without_fragments(begun, path, pictures):
    """Copy a film with its index in front. Raises OSError when not all of its pictures are there (a full disk)."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-v", "quiet", "-y", "-i", begun, "-c", "copy",
               "-movflags", "+faststart", path]
    done = subprocess.run([str(word) for word in command], stdin=subprocess.DEVNULL, check=False, timeout=COPY_TIMEOUT)
    if done.returncode or _count(path) != pictures:
        raise OSError("ffmpeg left it unfinished")


def _count(path):
    try:
        return imageio_ffmpeg.count_frames_and_secs(str(path))[0]
    except RuntimeError:  # of a file without an index
        return None
