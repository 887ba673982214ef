"""Everything that a package can add to snowmpm, one module each."""

from snow_extras import ageing, air, drag, kick, speed, wedge, words

__all__ = ["ageing", "air", "drag", "kick", "speed", "wedge", "words"]
