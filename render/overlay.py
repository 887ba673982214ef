"""What is written on a picture: title, time, colour scale, length scale."""

import textwrap
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

INK = (24, 34, 46)
WARNING = (193, 18, 31)
HALO = (255, 255, 255)
PANEL = (255, 255, 255, 178)
CORNER = 0.26
"""Share of the width of a picture that sentences in a corner take."""

EDGE = 16  # from a panel to the edge of a picture 720 pixels high
PAD = 12  # from what stands in a panel to its own edge
STRIP = (300, 14)  # width and height of the colours
ABOVE, BELOW = 26, 24  # of the colours: title and numbers


class Overlay:
    """Draws on one picture (height, width, 3) uint8; sizes follow the height of the picture, of a strip its width."""

    def __init__(self, picture):
        self.image = Image.fromarray(picture)
        self.draw = ImageDraw.Draw(self.image, "RGBA")
        self.unit = unit_of(self.image.size)

    def px(self, length):
        """Pixels for a length given for a picture 720 pixels high, at least one."""
        return max(1, round(length * self.unit))

    def text(self, position, words, size=20, anchor="la", bold=False, ink=INK):
        """`words` with a halo, so that they can be read on snow, rock and sky."""
        halo = max(1, round(0.09 * size * self.unit))
        font = _font(max(8, round(size * self.unit)), bold)
        self.draw.text(position, words, ink, font, anchor, stroke_width=halo, stroke_fill=HALO)

    def heading(self, title, time, duration=1.0, pace=""):
        """Title and time in the upper left corner; duration [s]: of the whole run, which chooses the unit; pace: of a
        film beside real time."""
        left, (factor, prefix) = self.px(28), small_prefix(10.0 * duration)
        self.text((left, self.px(22)), title, 24, bold=True)
        self.text((left, self.px(56)), f"t = {time / factor:.2f} {prefix}s" + (f", {pace}" if pace else ""), 22)

    def warnings(self, sentences, side="left"):
        """In a lower corner, above a note or a length scale, in red: why what the picture shows is not final."""
        if not sentences:
            return
        font = _font(max(8, self.px(13)), True)
        letters = max(16, int(CORNER * self.image.width / self.draw.textlength("n", font)))
        words = "\n".join(textwrap.fill(one, letters) for one in sentences)
        box = self.draw.multiline_textbbox((0, 0), words, font, spacing=self.px(4))
        left = self._left(box[2], side)
        top = self.image.height - self.px(2 * EDGE + 4 * PAD + 24) - box[3]
        self._panel([left, top, left + box[2], top + box[3]])
        self.draw.multiline_text((left, top), words, WARNING, font, spacing=self.px(4))

    def note(self, words, side="left"):
        """A small line in a lower corner."""
        font, bottom = _font(max(8, self.px(14)), False), self.image.height - self.px(EDGE + PAD)
        left = self._left(self.draw.textlength(words, font), side)
        self._panel(self.draw.textbbox((left, bottom), words, font, "ls"))
        self.draw.text((left, bottom), words, INK, font, "ls")

    def _left(self, width, side, taken=0):
        """Where something of a `width` [px] begins in a panel on that side, beside what has `taken` [px] there."""
        rim = self.px(EDGE + PAD) + taken
        return rim if side == "left" else self.image.width - rim - width

    def _panel(self, box):
        m = self.px(PAD)
        self.draw.rounded_rectangle([box[0] - m, box[1] - m, box[2] + m, box[3] + m], self.px(7), fill=PANEL)

    def colour_scale(self, scale, side="right"):
        """The colours of `scale` with numbers and units, in a lower corner."""
        width, height = (self.px(side) for side in STRIP)
        left, top = self._left(width, side), self.image.height - self.px(EDGE + PAD + BELOW) - height
        self._panel([left, top - self.px(ABOVE), left + width, top + height + self.px(BELOW)])
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
        x = left
        names = [name.replace("_", " ") for name in scale.names]
        free = width - sum(self.draw.textlength(name, font) + 1.4 * height for name in names)
        gap = max(free / max(len(names) - 1, 1), 0.5 * height)
        for k, name in enumerate(names):
            colour = tuple(int(255 * c) for c in scale.table()[int(255 * scale.share(k))])
            self.draw.rectangle([x, top, x + height, top + height], fill=colour, outline=INK)
            self.draw.text((x + 1.4 * height, top + 0.5 * height), name, INK, font, "lm")
            x += 1.4 * height + self.draw.textlength(name, font) + min(gap, 2.0 * height)

    def length_scale(self, pixels_per_metre, side="left", beside=False, about=False):
        """A bar of a round length in a lower corner.

        beside: next to a colour scale in that corner;  about: of a view whose scale is that of its middle only
        """
        longest = 0.2 * self.image.width / pixels_per_metre
        length = max(value for value in _rounds(longest) if value <= longest)
        width = length * pixels_per_metre
        left = self._left(width, side, self.px(STRIP[0] + 3 * PAD) if beside else 0)
        bottom = self.image.height - self.px(EDGE + PAD + 6)
        self._panel([left, bottom - self.px(24), left + width, bottom + self.px(6)])
        self.draw.line([left, bottom, left + width, bottom], INK, self.px(3))
        for x in (left, left + width):
            self.draw.line([x, bottom - self.px(6), x, bottom + self.px(6)], INK, self.px(2))
        font = _font(max(8, self.px(14)), False)
        factor, prefix = small_prefix(10.0 * length)
        words = f"{'about ' if about else ''}{length / factor:g} {prefix}m"
        self.draw.text((left + 0.5 * width, bottom - self.px(9)), words, INK, font, "ms")

    def pointer(self, place, words, anchor="ma"):
        """A small triangle that points up at `place`, with words below it, the middle or an end of them there."""
        (x, y), r = place, self.px(6)
        self.draw.polygon([(x, y), (x - r, y + 1.5 * r), (x + r, y + 1.5 * r)], fill=WARNING, outline=HALO)
        self.text((x, y + 1.8 * r), words, 17, anchor)

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


def unit_of(size):
    """Pixels of a picture of `size` (width, height) for one of a picture 720 high; of a strip it follows the width."""
    return max(size[1] / 720.0, size[0] / 1500.0)


def bands(size):
    """Shares (top, bottom) of the height of a picture of `size` that heading and colour scale take."""
    share = unit_of(size) / size[1]
    return 90.0 * share, (EDGE + 2 * PAD + ABOVE + STRIP[1] + BELOW) * share


@cache
def _font(size, bold):
    name = "DejaVuSans-Bold.ttf" if bold else "DejaVuSans.ttf"
    return ImageFont.truetype(str(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / name), size)


def small_prefix(size):
    """Power of 1000 that makes `size` a number from 1 to 1000 of its unit, and the prefix; 1 and none from 1 on."""
    return next(((factor, prefix) for factor, prefix in ((1.0, ""), (1e-3, "m"), (1e-6, "µ")) if size >= factor),
                (1e-9, "n"))


def ticks(low, high):
    """Round numbers from `low` to `high`, four to eight of them; `low` alone where they are the same."""
    if not high > low:
        return [low]
    step = min((s for s in _rounds(high - low) if (high - low) / s <= 6.0), default=high - low)
    first = np.ceil(low / step - 1e-6) * step
    return [float(round(value / step) * step) + 0.0 for value in np.arange(first, high + 1e-6 * step, step)]


def _rounds(near):
    power = int(np.floor(np.log10(near)))
    return [m * 10.0**e for e in range(power - 2, power + 1) for m in (1.0, 2.0, 5.0)]
