"""Slow warming of the fingertips, and what it does to their material."""

import math

from vegrip.virtual.settings import ThermalSettings


class Warming:
    """Temperature of the tips: ``T = T0 + rise (1 - e^{-t/tau})``; softer and quicker when warm."""

    def __init__(self, settings: ThermalSettings) -> None:
        self.settings = settings
        self._applied = settings.start  # temperature the material was last set to

    def temperature(self, time: float) -> float:
        """Return the temperature at ``time`` [s] in degrees Celsius."""
        s = self.settings
        return s.start + (s.rise * -math.expm1(-time / s.time) if s.warming else 0.0)

    def material(self, time: float) -> tuple[float, float] | None:
        """Return factors of stiffness and relaxation rates [-] when they have changed noticeably, else None.

        The rates are taken as those of the present temperature for the whole history: right for warming that
        is slow against the relaxation, and renewed every 0.1 degrees.
        """
        warmth = self.temperature(time)
        if abs(warmth - self._applied) < 0.1:
            return None
        self._applied = warmth
        s, above = self.settings, warmth - self.settings.start
        return math.exp(-s.softening * above), math.exp(s.quickening * above)
