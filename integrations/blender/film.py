"""A still or a film of a run of snowmpm, rendered by Blender without a display.

    python film.py RUN -o still.png --time 4        with Python 3.11 and the wheels bpy and h5py
    blender -b --python film.py -- RUN -o film.mp4  in Blender, once h5py is there (README.md)

--engine cycles|eevee, --samples N, --size WxH, --speed X, --fps N, --from T, --to T, --draw surface,clods,points,powder
"""

import argparse
import os
import sys
import time as clock
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parent))
from snowmpm_run import nodes, snow

ENGINES = {"cycles": "CYCLES", "eevee": "BLENDER_EEVEE_NEXT"}


def wishes(words):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run")
    parser.add_argument("-o", "--output", type=Path, required=True, help=".png: one picture; .mp4: a film")
    parser.add_argument("--time", type=float, help="of a picture [s]; by default the middle of the run")
    parser.add_argument("--from", dest="begin", type=float, default=0.0, help="of a film [s]")
    parser.add_argument("--to", dest="end", type=float, help="of a film [s]")
    parser.add_argument("--engine", choices=ENGINES, default="cycles")
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--size", default="960x540")
    parser.add_argument("--speed", type=float, default=1.0, help="simulated seconds in a second of film")
    parser.add_argument("--fps", type=float, default=24.0)
    parser.add_argument("--draw", default="surface,clods", help=f"of {nodes.SURFACE}, {nodes.CLODS}, {nodes.POINTS} and"
                        f" {nodes.POWDER}")
    parser.add_argument("--blend", type=Path, help="save the file of Blender here, too")
    chosen = parser.parse_args(words)
    if chosen.output.suffix not in (".png", ".mp4"):
        parser.error(f"-o {chosen.output}: must end in .png or .mp4")
    if unknown := set(chosen.draw.split(",")) - {nodes.SURFACE, nodes.CLODS, nodes.POINTS, nodes.POWDER}:
        parser.error(f"--draw: no {', '.join(sorted(unknown))}")
    return chosen


def main(words):
    chosen = wishes(words)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = (int(side) for side in chosen.size.lower().split("x"))
    scene.render.resolution_percentage = 100
    try:
        snow.open_run(chosen.run, draw=set(chosen.draw.split(",")), speed=chosen.speed, fps=chosen.fps)
    except (ValueError, OSError) as error:
        sys.exit(f"error: {error}")
    scene.render.engine = ENGINES[chosen.engine]
    if chosen.engine == "cycles":
        scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", chosen.samples, True
        scene.cycles.volume_step_rate = 4.0
    else:
        scene.eevee.taa_render_samples = chosen.samples
    scene.render.use_motion_blur = True
    rate = chosen.fps / chosen.speed
    scene.render.filepath = str(chosen.output.resolve())
    begun = clock.perf_counter()
    if chosen.output.suffix == ".png":
        middle = 0.5 * (scene.frame_start + scene.frame_end)
        scene.frame_set(round(middle if chosen.time is None else chosen.time * rate))
    else:
        scene.frame_start = round(chosen.begin * rate)
        scene.frame_end = min(scene.frame_end, round(chosen.end * rate)) if chosen.end is not None else scene.frame_end
        scene.render.image_settings.file_format = "FFMPEG"
        scene.render.ffmpeg.format, scene.render.ffmpeg.codec = "MPEG4", "H264"
        scene.render.ffmpeg.constant_rate_factor = "HIGH"
    if chosen.blend:
        bpy.ops.wm.save_as_mainfile(filepath=str(chosen.blend.resolve()))
    bpy.ops.render.render(write_still=chosen.output.suffix == ".png", animation=chosen.output.suffix == ".mp4")
    print(f"{chosen.output}: {clock.perf_counter() - begun:.1f} s")
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash when Python takes it down


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:])
