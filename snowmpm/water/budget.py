"""What water did since time zero, for the audit."""

from dataclasses import asdict, dataclass


@dataclass
class Budget:
    """Water [kg]: at the start, drained through faces (negative where it came in), added by rain and melt. work [J] of
    the pore pressure on the skeleton; carried_energy [J] and carried_mass [kg]: energy, from the height 0, and mass
    that the skeleton gained as water flowed through it."""

    start: float = 0.0
    drained: float = 0.0
    added: float = 0.0
    work: float = 0.0
    carried_energy: float = 0.0
    carried_mass: float = 0.0

    def state(self):
        """Numbers by name."""
        return asdict(self)

    def residual(self, now, left):
        """|start + added - drained - left - now| over the largest of them; now: in the particles, left: with those
        that are gone [kg]."""
        size = max(abs(self.start), abs(self.added), abs(now), 1e-300)
        return abs(self.start + self.added - self.drained - left - now) / size
