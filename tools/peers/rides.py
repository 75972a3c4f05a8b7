"""The ski jump and the ride on the pump track, by hand: what a user of another program has to write down."""

from dataclasses import dataclass
from math import cos, sin

G = 9.81


@dataclass(frozen=True)
class SkiJump:
    """A point mass that slides off a table, flies and lands on a slope; coordinates (y, z)."""

    study: str
    start: float
    horizon: float = 5.0

    @staticmethod
    def table(y):
        """Height of the table, its slope and its curvature."""
        height = (((-0.0001524 * y - 0.002149) * y + 0.4162) * y - 9.154) * y + 99.15
        slope = ((-4 * 0.0001524 * y - 3 * 0.002149) * y + 2 * 0.4162) * y - 9.154
        return height, slope, (-12 * 0.0001524 * y - 6 * 0.002149) * y + 2 * 0.4162

    @staticmethod
    def slope(y):
        """The same of the slope that the jumper lands on."""
        return 45 - y / 2, -0.5, 0.0


@dataclass(frozen=True)
class PumpTrack:
    """A bike and its rider on a wavy track, no force between them; coordinates (y, s, l), s above the track.

    The track pushes along (-track', 1, 0), as published, so the mass plays no part.
    """

    study: str
    speed: float
    horizon: float = 2.0
    length: float = 0.4368

    @staticmethod
    def track(y):
        """Height of the track, its slope and its curvature."""
        return 0.2 - 0.2 * cos(2 * y), 0.4 * sin(2 * y), 0.8 * cos(2 * y)


SKI_JUMPS = [SkiJump("ski-jump, start 45 m high", 10.2759), SkiJump("ski-jump, start 50 m high", 8.264)]
PUMP_TRACKS = [PumpTrack(f"pump-track, {speed} km/h", speed / 3.6) for speed in (10, 15, 22)]
