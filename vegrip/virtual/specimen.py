"""One fingertip with hidden effects: what the plain one solves in closed form is searched for here."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from vegrip.types import Floats
from vegrip.virtual import profile
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.hidden import Hidden
from vegrip.virtual.history import History
from vegrip.virtual.settings import FingertipSettings

MAX_ROUNDS = 100
NEARBY = 2e-3  # of the radius, within which the next step ends as a rule


class Specimen(Fingertips):
    """A fingertip whose elastic law, relaxation, mount and adhesion may be anything."""

    def __init__(
        self, tip: FingertipSettings, step: float, hidden: Sequence[Hidden], fine: int = 1024
    ) -> None:
        self._hidden, self._changes = tuple(hidden), False
        super().__init__([tip], step, fine)
        self._g = tip.relaxing()
        for one in hidden:
            self._g = one.relaxation(self._g)
        self.follow(History([self._g], step, fine))
        self._changes = bool(overridden(hidden, "warmed"))
        self._indented, self._stressed = overridden(hidden, "indentation"), overridden(hidden, "elastic")
        self._more, self._pulls = overridden(hidden, "more"), overridden(hidden, "pull")
        self._moves, self._drives = overridden(hidden, "moved"), overridden(hidden, "drive")[::-1]
        self._radii, self._flattens = overridden(hidden, "radius"), overridden(hidden, "flattened")
        self._remembers, self._strains = overridden(hidden, "remember"), overridden(hidden, "strained")
        self._plain = not self._indented and not self._stressed
        self._x = 0.0  # [m] where the last search ended
        self._compliance = sum(one.compliance for one in hidden)
        self._law = (tip.reference_force, tip.reference_indentation, tip.exponent)

    def reset(self) -> None:
        """Make the material recovered and out of contact; what lasts is with the hidden effects."""
        super().reset()
        if self._changes:
            self.history.reweigh([self._g])
            self.follow(self.history)
        self.position = 0.0
        """Where the drive stands [m]."""
        self._pressed = 0.0

    def elastic_force(self, indentation: Floats) -> Floats:
        """Return N_e [N] with all that the material has been through."""
        return np.array([self._elastic(float(x)) for x in indentation])

    def elastic_indentation(self, force: Floats) -> Floats:
        """Return the indentation that gives N_e [m]."""
        if self._plain:
            return super().elastic_indentation(force)
        R = float(self.radius[0])
        return np.array(
            [
                _root(partial(self._excess, N), *_about(partial(self._excess, N), self._x, 0.0, R))
                if N > 0.0
                else 0.0
                for N in force.tolist()
            ]
        )

    def press(self, indentation: Floats) -> Floats:
        """Put the drive at a position [m]; return the normal force [N]."""
        self.position = mount = float(indentation[0])
        for moved in self._moves:
            mount = moved(mount)
        self._recall()
        C, x = self._compliance, mount
        if C > 0.0:
            strongest = self._pull(1e-300)
            x = _root(
                lambda x: x + C * (max(self._response(x), 0.0) - self._pull(x)) - mount,
                mount - C * max(self._response(mount), 0.0),
                mount + C * strongest,
            )
        self._settle(x, max(self._response(x), 0.0))
        return self.force

    def load(self, force: Floats) -> Floats:
        """Impose a normal force [N]; return where the drive stands [m]."""
        wanted = max(float(force[0]), 0.0)
        self._recall()
        x = 0.0
        if self._plain and not self._more and not self._pulls:
            surface = self.before + (wanted - self.past) / self.instant
            x = float(super().elastic_indentation(surface)[0])
        elif self._response(0.0) - self._pull(1e-300) < wanted:

            def excess(x: float) -> float:
                return self._response(x) - self._pull(x) - wanted

            x = _root(excess, *_about(excess, self._x, 1e-300, float(self.radius[0])))
        mount = x + self._compliance * wanted
        for drive in self._drives:
            mount = drive(mount)
        self.position = mount
        self._settle(x, wanted + self._pull(x))
        return np.array([mount])

    @property
    def contact_radius(self) -> Floats:
        x = float(self.indentation[0])
        for indented in self._indented:  # a dented surface touches less
            x = indented(x)
        R = float(self.radius[0])
        a = float(np.sqrt(2.0 * R * x)) if self._pressed > 0.0 and x > 0.0 else 0.0
        for radius in self._radii:
            a = radius(a, x, R)
        return np.array([a])

    @property
    def pressure_exponent(self) -> Floats:
        x, fresh = float(self.indentation[0]), float(self.elastic_indentation(self.reference)[0])
        creep = max(x / fresh, 1.0) if fresh > 0.0 else 1.0
        k = profile.exponent(float(self.records["C_fresh"][0]) / creep)
        for flattened in self._flattens:
            k = flattened(k)
        return np.array([k])

    def _elastic(self, x: float) -> float:
        for indented in self._indented:
            x = indented(x)
        F0, d0, p = self._law
        force = float(F0 * (x / d0) ** p) if x > 0.0 else 0.0
        for stressed in self._stressed:
            force = stressed(force, x)
        return force

    def _excess(self, wanted: float, x: float) -> float:
        return self._elastic(x) - wanted

    def _recall(self) -> None:
        """Take the numbers of this step out of the records, which a search would read many times."""
        self._was, self._share, self._last = (
            float(self.past[0]),
            float(self.instant[0]),
            float(self.before[0]),
        )

    def _response(self, x: float) -> float:
        """Return what the material would push with [N] at the end of this step; below zero it lifts off."""
        elastic = self._elastic(x)
        return self._was + self._share * (elastic - self._last) + self._added(x, elastic)

    def _added(self, x: float, elastic: float) -> float:
        force = 0.0
        for more in self._more:
            force += more(x, elastic)
        return force

    def _pull(self, x: float) -> float:
        force = 0.0
        for pull in self._pulls:
            force += pull(x)
        return force

    def _settle(self, x: float, pressed: float) -> None:
        """Close the step: the history keeps what the material feels, the sensor what is left of it."""
        force = pressed - self._pull(x)
        elastic = self._elastic(x) if pressed > 0.0 else self._last
        more = self._added(x, elastic)
        self._x = x
        largest = max(float(self.reference[0]), pressed) if pressed > 0.0 else 0.0
        self._close(np.array([x]), np.array([pressed - more]))
        self._pressed, self.reference[:], self.force[:] = pressed, largest, force
        for remember in self._remembers:
            remember(x, force, self.step)
        for strained in self._strains:
            strained(float(self.before[0]), x, self.step)


def overridden(hidden: Sequence[Hidden], name: str) -> list[Callable[..., Any]]:
    """Return this method of those that have one of their own: the others would leave things as they are."""
    plain = getattr(Hidden, name)
    return [getattr(one, name) for one in hidden if getattr(type(one), name) is not plain]


def _about(f: Callable[[float], float], x: float, low: float, high: float) -> tuple[float, float]:
    reach = NEARBY * high
    below, above = max(x - reach, low), min(x + reach, high)
    if f(below) > 0.0:
        return low, below
    return (below, above) if f(above) > 0.0 else (above, high)


def _root(f: Callable[[float], float], low: float, high: float) -> float:
    """Return where the growing f is zero in ``low`` .. ``high``: regula falsi, now and then halving."""
    f_low, f_high = f(low), f(high)
    if f_low >= 0.0 or f_high <= 0.0:
        return low if f_low >= 0.0 else high
    x = low
    for i in range(MAX_ROUNDS):
        x = 0.5 * (low + high) if i % 3 == 2 else low - f_low * (high - low) / (f_high - f_low)
        if not low < x < high:
            break
        f_x = f(x)
        if f_x == 0.0:
            break
        if f_x < 0.0:
            low, f_low = x, f_x
        else:
            high, f_high = x, f_x
        if high - low <= 1e-14 * abs(x):
            break
    return x
