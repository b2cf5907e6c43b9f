"""The numbers of one estimator: one flat array that the kernels work on, and its numbers by name.

:mod:`vegrip.estimator.layout` says where everything lies.
"""

import math

import numpy as np

from vegrip.estimator.layout import (
    CHANNELS,
    COUNTS,
    FRICTION,
    MODE,
    PER_CHANNEL,
    PER_PART,
    REPORT,
    Layout,
)
from vegrip.messages import Channel, FingertipState
from vegrip.types import Floats

REPORT_PLACE = {name: i for i, name in enumerate(REPORT)}
CHANNEL_BITS = (int(Channel.POSITION), int(Channel.FORCE), int(Channel.RADIUS))
"""Bit of each of :data:`~vegrip.estimator.layout.CHANNELS`."""
FRICTION_BELIEF = FRICTION.index("LN_MU"), FRICTION.index("BASE_VAR") + 1
"""Where mean and variance of ln mu lie, now and before the present loading."""

assert len(CHANNEL_BITS) == len(CHANNELS)  # noqa: S101


class EstimatorMemory:
    """Everything an estimator knows, packed.

    Args:
        layout: places of the numbers.
        blank: the numbers before the first sample, shape (layout.size,).

    """

    def __init__(self, layout: Layout, blank: Floats) -> None:
        self.layout = layout
        self.blank = blank
        self.numbers: Floats = blank.copy()
        """What the kernels take, shape (layout.size,)."""
        places = layout.places()
        self._sections = {name: slice(*place) for name, place in places.items()}
        self._report, self._exogenous = places["REPORT"][0], places["EXOGENOUS"][0]
        self._mode, self._counts = places["MODE"][0], places["COUNTS"][0]
        friction = places["FRICTION"][0]
        self._friction = slice(friction + FRICTION_BELIEF[0], friction + FRICTION_BELIEF[1])
        self._used = tuple(layout.channel_place(i, "USED") for i in range(len(CHANNELS)))

    def reset(self) -> None:
        """Forget everything but the prior."""
        self.numbers[:] = self.blank

    def move_to(self, place: Floats) -> None:
        """Lie in ``place`` from now on, shape (layout.size,)."""
        place[:] = self.numbers
        self.numbers = place

    def section(self, name: str) -> Floats:
        """Return the numbers of a section of the layout, to read and to write."""
        return self.numbers[self._sections[name]]

    def report(self, name: str) -> float:
        """Return one of :data:`~vegrip.estimator.layout.REPORT`."""
        return float(self.numbers[self._report + REPORT_PLACE[name]])

    def reports(self) -> list[float]:
        """Return all of :data:`~vegrip.estimator.layout.REPORT`; :data:`REPORT_PLACE` finds a name.

        A list, because a dict of them would cost a fifth of a contact estimate.
        """
        reports: list[float] = self.section("REPORT").tolist()
        return reports

    def mode(self, name: str) -> float:
        """Return one of :data:`~vegrip.estimator.layout.MODE`."""
        return float(self.numbers[self._mode + MODE.index(name)])

    def count(self, name: str) -> int:
        """Return one of :data:`~vegrip.estimator.layout.COUNTS`."""
        return int(self.numbers[self._counts + COUNTS.index(name)])

    @property
    def friction(self) -> tuple[float, float, float, float]:
        """Mean and variance of ln mu: now, and before the present loading."""
        mean, variance, mean_before, variance_before = self.numbers[self._friction].tolist()
        return mean, variance, mean_before, variance_before

    @friction.setter
    def friction(self, belief: tuple[float, float, float, float]) -> None:
        self.numbers[self._friction] = belief

    @property
    def means(self) -> Floats:
        """The filter's state, shape (layout.n,); a copy."""
        return self.section("Y").copy()

    @property
    def covariance(self) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
        """Its covariance, shape (layout.n, layout.n); a copy."""
        n = self.layout.n
        return self.section("P").reshape(n, n).copy()

    @property
    def has_contact(self) -> bool:
        """Whether the fingertip touches; made at two standard deviations, broken at half of one."""
        return self.report("CONTACT") > 0.5

    @property
    def is_load_doubted(self) -> bool:
        """Whether a part of the load is gone that may still be there."""
        parts = self.section("PART")[PER_PART.index("LOST") :: len(PER_PART)]
        return bool(parts.max() > 0.0)

    @property
    def is_sound(self) -> bool:
        """Whether the last samples were not all refused."""
        return self.report("SOUND") > 0.5

    @property
    def is_informed(self) -> bool:
        """Whether force or displacement of the last sample was used."""
        displacement, force, _ = self._used
        return bool(self.numbers[displacement] > 0.0 or self.numbers[force] > 0.0)

    def used_bits(self) -> int:
        """Return which of :data:`CHANNELS` the last sample gave, as bits of :class:`Channel`."""
        used = zip(self._used, CHANNEL_BITS, strict=True)
        return sum(bit for place, bit in used if self.numbers[place] > 0.0)

    def is_refused(self, channel: str) -> bool:
        """Whether the last values of one of :data:`CHANNELS` were refused."""
        place = self.layout.channel_place(CHANNELS.index(channel), "STREAK")
        return bool(self.numbers[place] > 0.0)

    def set_exogenous(self, state: FingertipState, load: float, torque: float) -> None:
        """Pass on what effects may feel; a value that is not measured stays as it was."""
        speed = 0.0 if state.slip == 0.0 else state.slip_speed  # noise is not sliding
        x, y = state.tangential_force_x, state.tangential_force_y
        for place, value in enumerate((state.temperature, load, torque, speed, x, y), self._exogenous):
            if math.isfinite(value):
                self.numbers[place] = value

    def reset_health(self) -> None:
        """Forget how well the model explained what was felt so far."""
        self.section("HEALTH")[:] = 0.0
        self.section("CHANNEL").reshape(len(CHANNELS), -1)[:, PER_CHANNEL.index("REJECTED")] = 0.0
