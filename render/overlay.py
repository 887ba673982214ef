"""What is written on a picture: title, time, colour scale, length scale."""

from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

INK = (24, 34, 46)
HALO = (255, 255, 255)
PANEL = (255, 255, 255, 178)


class Overlay:
    """Draws on one picture (height, width, 3) uint8; sizes follow the height of the picture."""

    def __init__(self, picture):
        self.image = Image.fromarray(picture)
        self.draw = ImageDraw.Draw(self.image, "RGBA")
        self.unit = self.image.height / 720.0

    def px(self, length):
        """Pixels for a length given for a picture 720 pixels high, at least one."""
        return max(1, round(length * self.unit))

    def text(self, position, words, size=20, anchor="la", bold=False):
        """`words` with a halo, so that they can be read on snow, rock and sky."""
        halo = max(1, round(0.09 * size * self.unit))
        font = _font(max(8, round(size * self.unit)), bold)
        self.draw.text(position, words, INK, font, anchor, stroke_width=halo, stroke_fill=HALO)

    def heading(self, title, time):
        """Title and time in the upper left corner."""
        left = self.px(28)
        self.text((left, self.px(22)), title, 24, bold=True)
        self.text((left, self.px(56)), f"t = {time:.2f} s", 22)

    def note(self, words, corner="lb"):
        """A small line at the bottom left (lb) or bottom right (rb)."""
        x = self.px(28) if corner[0] == "l" else self.image.width - self.px(28)
        self.text((x, self.image.height - self.px(20)), words, 14, anchor=f"{corner[0]}s")

    def colour_scale(self, scale):
        """The colours of `scale` with numbers and units, in the lower right corner."""
        width, height = self.px(300), self.px(14)
        left = self.image.width - width - self.px(44)
        top = self.image.height - self.px(64)
        box = [left - self.px(26), top - self.px(38), left + width + self.px(26), top + height + self.px(34)]
        self.draw.rounded_rectangle(box, self.px(8), fill=PANEL)
        font, small = _font(max(8, self.px(16)), True), _font(max(8, self.px(14)), False)
        self.draw.text((left, top - self.px(10)), scale.title, INK, font, "ls")
        if scale.names:
            self._swatches(scale, left, top, width, height, small)
            return
        strip = np.repeat((255 * scale.table()[None]).astype(np.uint8), height, axis=0)
        self.image.paste(Image.fromarray(strip).resize((width, height)), (left, top))
        self.draw.rectangle([left, top, left + width, top + height], outline=INK)
        for value in ticks(scale.low, scale.high):
            x = left + width * (value - scale.low) / (scale.high - scale.low)
            self.draw.line([x, top + height, x, top + height + self.px(5)], INK, self.px(1.4))
            self.draw.text((x, top + height + self.px(7)), f"{value:g}", INK, small, "ma")

    def _swatches(self, scale, left, top, width, height, font):
        step = width / len(scale.names)
        for k, name in enumerate(scale.names):
            colour = tuple(int(255 * c) for c in scale.table()[int(255 * scale.share(k))])
            x = left + k * step
            self.draw.rectangle([x, top, x + height, top + height], fill=colour, outline=INK)
            self.draw.text((x + 1.4 * height, top + 0.5 * height), name, INK, font, "lm")

    def length_scale(self, pixels_per_metre):
        """A bar of a round length in the lower left corner, for views without perspective."""
        longest = 0.2 * self.image.width / pixels_per_metre
        length = max(value for value in _rounds(longest) if value <= longest)
        left, bottom = self.px(28), self.image.height - self.px(44)
        right = left + length * pixels_per_metre
        for colour, extra in ((HALO, 2), (INK, 0)):
            w = self.px(3) + 2 * extra
            self.draw.line([left - extra, bottom, right + extra, bottom], colour, w)
            for x in (left, right):
                self.draw.line([x, bottom - self.px(6) - extra, x, bottom + self.px(6) + extra], colour, w)
        self.text((0.5 * (left + right), bottom - self.px(10)), f"{length:g} m", 15, anchor="ms")

    def inset(self, picture, position):
        """`picture` with a frame, its upper left corner at `position`."""
        x, y = position
        self.image.paste(Image.fromarray(picture), (x, y))
        self.draw.rectangle([x, y, x + picture.shape[1], y + picture.shape[0]], outline=INK, width=self.px(1.5))

    def rectangle(self, box):
        """A frame (left, top, right, bottom)."""
        self.draw.rectangle(box, outline=(200, 50, 40), width=self.px(2))

    def picture(self):
        """(height, width, 3) uint8."""
        return np.asarray(self.image)


@cache
def _font(size, bold):
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


def ticks(low, high):
    """Round numbers from `low` to `high`, four to eight of them."""
    step = min((s for s in _rounds(high - low) if (high - low) / s <= 6.0), default=high - low)
    first = np.ceil(low / step - 1e-6) * step
    return [float(round(value / step) * step) + 0.0 for value in np.arange(first, high + 1e-6 * step, step)]


def _rounds(near):
    power = int(np.floor(np.log10(near)))
    return [m * 10.0**e for e in range(power - 2, power + 1) for m in (1.0, 2.0, 5.0)]
