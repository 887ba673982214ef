"""Everything that a package can add to snowmpm, one module each."""

from snow_extras import ageing, drag, kick, speed, wedge, words

__all__ = ["ageing", "drag", "kick", "speed", "wedge", "words"]
