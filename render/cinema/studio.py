"""A scene of coloured triangles through a lens, by `pyvista.Plotter` off-screen, with motion blur and depth of field.

Light is computed at vertices (`shade`), so VTK draws colours as they are. A picture is the mean of several shots, each
at another moment within the time that the shutter is open, through another point of the lens and another part of each
pixel (accumulation buffer: Haeberli and Akeley 1990, doi:10.1145/97880.97913).
"""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from snowmpm.errors import InputError
from snowmpm.render import light

HELP = ("--look cinematic needs OpenGL without a display: apt-get install libegl1 libgl1-mesa-dri (Debian, Ubuntu), or"
        " the like; --look diagram needs none")
BRIGHTEST = 1.3
"""Light that a byte can hold: what is brighter than white is rolled off at the end."""


@dataclass(frozen=True)
class Part:
    """Triangles: vertices (n, 3) [m], faces (m, 3), light (n, 3), linear; velocity (n, 3) [m/s] or None at
    rest; st (n, 2) and picture (rows, columns, 3) sRGB bytes: what the light is multiplied by, or None."""

    vertices: np.ndarray
    faces: np.ndarray
    light: np.ndarray
    velocity: np.ndarray | None = None
    st: np.ndarray | None = None
    picture: np.ndarray | None = None


@dataclass(frozen=True)
class Lens:
    """shots of a picture; shutter [s]: open for so long; radius [m] of the lens; focus [m]: distance that is sharp."""

    shots: int = 1
    shutter: float = 0.0
    radius: float = 0.0
    focus: float = 1.0

    def moments(self):
        """(time [s], (x, y) on the lens [m], (x, y) within the pixel) of each shot."""
        for k in range(self.shots):
            share = (k + 0.5) / self.shots
            angle, reach = 2.399963 * k, self.radius * np.sqrt(share)  # Vogel's spiral
            yield ((share - 0.5) * self.shutter, np.array([np.cos(angle), np.sin(angle)]) * reach,
                   _halton(k + 1) - 0.5 if self.shots > 1 else np.zeros(2))


def _halton(k):
    """Point k of Halton's sequence in the unit square, bases 2 and 3."""
    found = []
    for base in (2, 3):
        share, number, rest = 1.0, 0.0, k
        while rest:
            share /= base
            number += share * (rest % base)
            rest //= base
        found.append(number)
    return np.array(found)


def do_without_display():
    """Let VTK draw where there is no display, before it is imported: it would look for an X server, and say so at
    length."""
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")


class Studio:
    """One plotter in a thread of its own, since a context of OpenGL belongs to the thread that made it."""

    def __init__(self, lit=False):
        """lit: by the lamps of VTK, for `draw`."""
        self._lit = lit
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="studio")
        self._plotter, self._lasting = None, {}

    def shoot(self, lasting, passing, camera, lens, behind):
        """(height, width, 3) in linear light of the parts as a `Camera` sees them through a `Lens`.

        lasting {name: Part}: the same objects stay in the scene from picture to picture; passing [Part]: of this
        picture alone; behind (height, width, 3): the sky. Raises InputError where there is no OpenGL.
        """
        return self._thread.submit(self._shoot, lasting, passing, camera, lens, behind).result()

    def draw(self, add, camera, behind):
        """(height, width, 3) uint8 of what `add(plotter)` adds, with its colours as they are, as a `Camera` sees it,
        before `behind` (height, width, 3) uint8."""
        return self._thread.submit(self._draw, add, camera, behind).result()

    def _draw(self, add, camera, behind):
        plotter = self._ready(camera.size)
        add(plotter)
        low, high = np.reshape(plotter.renderer.bounds, (3, 2)).T
        _aim(plotter, camera, Lens(focus=max(float((0.5 * (low + high) - camera.eye) @ camera.axes[2]), 1e-3)),
             np.zeros(2), np.zeros(2))
        plotter.render()
        picture = plotter.screenshot(None, return_img=True, transparent_background=True)
        plotter.clear_actors()
        cover = picture[..., 3:].astype(np.float32) / 255.0
        return np.round(picture[..., :3] * cover + behind * (1.0 - cover)).astype(np.uint8)

    def _shoot(self, lasting, passing, camera, lens, behind):
        plotter = self._ready(camera.size)
        actors = []
        for name, part in lasting.items():
            known = self._lasting.get(name)
            if known is None:
                self._lasting[name] = known = self._add(plotter, part)
            _paint(known[0], part)
        for part in passing:
            if len(part.faces):
                actors.append((*self._add(plotter, part), part))
        total = np.zeros((camera.size[1], camera.size[0], 3), np.float32)
        for time, on_lens, in_pixel in lens.moments():
            for mesh, _, part in actors:
                if part.velocity is not None and lens.shutter:
                    mesh.points = (part.vertices + np.float32(time) * part.velocity).astype(np.float32)
            _aim(plotter, camera, lens, on_lens, in_pixel)
            plotter.render()
            picture = plotter.screenshot(None, return_img=True, transparent_background=True)
            cover = picture[..., 3:].astype(np.float32) / 255.0
            total += BRIGHTEST * light.decode(picture[..., :3] / np.float32(255.0)) * cover + behind * (1.0 - cover)
        for _, actor, _ in actors:
            plotter.remove_actor(actor, render=False)
        return total / lens.shots

    def _ready(self, size):
        """The plotter at a size [px]."""
        if self._plotter is None:
            do_without_display()
            import pyvista as pv

            try:
                self._plotter = pv.Plotter(off_screen=True, window_size=list(size),
                                           lighting="light kit" if self._lit else "none")
                self._plotter.render_window.SetMultiSamples(4 if self._lit else 0)
                self._plotter.show(auto_close=False)
            except Exception as error:
                raise InputError(f"{HELP} ({error})") from None
        if tuple(self._plotter.window_size) != tuple(size):
            self._plotter.window_size = list(size)
        return self._plotter

    def _add(self, plotter, part):
        import pyvista as pv

        mesh = pv.PolyData.from_regular_faces(np.ascontiguousarray(part.vertices, np.float32),
                                              np.ascontiguousarray(part.faces))
        _paint(mesh, part)
        actor = plotter.add_mesh(mesh, scalars="light", rgb=True, lighting=False, render=False, show_scalar_bar=False,
                                 copy_mesh=False, reset_camera=False)
        if part.picture is not None:
            # Bytes are a power of light, so their product is that of light and albedo
            mesh.active_texture_coordinates = np.ascontiguousarray(part.st, np.float32)
            texture = pv.numpy_to_texture(np.ascontiguousarray(part.picture))
            texture.repeat = True
            texture.MipmapOn()
            texture.InterpolateOn()
            actor.texture = texture
        return mesh, actor


def _paint(mesh, part):
    # Without the roll-off of bright light, which is of the whole picture
    share = np.clip(part.light / BRIGHTEST, 0.0, 1.0) ** (1.0 / 2.2)
    mesh.point_data["light"] = np.round(255.0 * share).astype(np.uint8)


def _aim(plotter, camera, lens, on_lens, in_pixel):
    """Put the plotter's camera where a `Camera` is, moved on the lens [m] and within the pixel."""
    right, up, forward = camera.axes
    seen, (width, height) = plotter.camera, camera.size
    eye = camera.eye + on_lens[0] * right + on_lens[1] * up
    seen.position = eye
    # What lies at the focus stays where it is on the picture, whichever part of the lens is looked through
    seen.focal_point = camera.eye + lens.focus * forward
    seen.up = up
    if camera.perspective:
        seen.parallel_projection = False
        seen.view_angle = float(np.degrees(2.0 * np.arctan(0.5 * height / camera.scale)))
        seen.clipping_range = (0.02 * lens.focus, 300.0 * lens.focus)
    else:
        seen.parallel_projection = True
        seen.parallel_scale = 0.5 * height / camera.scale
        seen.clipping_range = (1e-3 * lens.focus, 30.0 * lens.focus)
    seen.SetWindowCenter(2.0 * in_pixel[0] / width, 2.0 * in_pixel[1] / height)
