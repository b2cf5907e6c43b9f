"""The clock of an estimator: in which order its samples come, and how old the last one that counted is.

Stamps are those of the sender. A stamp that does not advance is either a late sample, which still finds its
place (:mod:`vegrip.estimator.rewind_buffer`), or refused; after some refusals in a row the sender's clock is
taken to have started anew.
"""

import math
from dataclasses import replace
from enum import Enum

from vegrip.clock import NS
from vegrip.estimator.elapsed import elapsed_time
from vegrip.estimator.settings import EstimatorSettings
from vegrip.messages import NAN, FingertipState
from vegrip.types import NamedNumbers

SAMPLE_COUNTS = (
    "BEGUN", "STAMP", "INFORMED", "IS_INFORMED", "SHOWN", "TRUSTED", "SEQ", "RESUMED", "REFUSED", "BACKWARDS",
    "REWIND_NEXT", "KEPT", "LATE", "FOLLOWED",
)  # fmt: skip
"""Names of the section SAMPLE of a finger's memory (:mod:`vegrip.grip.layout`)."""


KEPT_CHANNELS, SLIP_AT = 10, 6
"""Columns of the section HISTORY, and where slip stands in them."""


class Turn(Enum):
    """When a sample comes, measured at the last one that was taken."""

    NEXT = "after it"
    BEHIND = "not after it: late, repeated, or by a clock that was set back"
    RESUMED = "first after the memory was resumed, so that the time between is unknown"


class SampleClock:
    """Stamps, counts and ages of the samples of one estimator.

    Args:
        settings: of the estimator; ``recovery`` and ``longest_gap`` count here.

    """

    def __init__(self, settings: EstimatorSettings) -> None:
        self._recovery = settings.recovery
        self._unknown_gap = round(settings.longest_gap * NS) + 1  # [ns] after which the motion is unknown
        self.reset()

    def reset(self) -> None:
        """Begin before the first sample."""
        self.taken: FingertipState | None = None
        """The last sample that was taken."""
        self.offered: FingertipState | None = None
        """The last sample, taken or not."""
        self.is_trusted = False
        """Whether the last sample offered was taken."""
        self.seq = 0
        """Samples taken."""
        self.refused = 0
        """Samples refused because their stamp did not advance."""
        self.late = 0
        """Samples that came late and were put in their place."""
        self.followed = 0
        """How often the sender's clock had started anew."""
        self.offers = 0
        """Samples offered, taken or not."""
        self.load = self.torque = NAN
        """Tangential force [N] and torque [N m] of the last sample taken."""
        self._informed = NAN  # [ns] stamp of the last sample that said something about the contact
        self._refused_in_a_row = 0
        self._is_resumed = False

    def resume(self) -> None:
        """Begin with a memory that was kept: when the next sample comes, an unknown time has passed."""
        self.reset()
        self._is_resumed = True

    def turn(self, sample: FingertipState) -> Turn:
        """Take note that ``sample`` is offered; return whether it is its turn."""
        self.offered, self.is_trusted = sample, False
        self.offers += 1
        if self._is_resumed:
            return Turn.RESUMED
        if self.taken is not None and sample.stamp <= self.taken.stamp:
            return Turn.BEHIND
        self._refused_in_a_row = 0
        return Turn.NEXT

    def refuse(self) -> bool:
        """Count the sample offered as refused; return whether the sender's clock has started anew."""
        self.refused += 1
        self._refused_in_a_row += 1
        return self._refused_in_a_row >= self._recovery

    def follow(self, sample: FingertipState) -> None:
        """Go on by the clock of ``sample``, the next one.

        The silence before it has an unknown length: it is taken as the time after which the motion counts as
        unknown.
        """
        self._is_resumed, self._refused_in_a_row = False, 0
        self.followed += 1
        self.taken = replace(self.taken or sample, stamp=sample.stamp - self._unknown_gap)
        self._informed = self.taken.stamp

    def rewind(self, before: FingertipState | None, samples: int) -> None:
        """Go back by ``samples`` to the sample ``before``."""
        self.taken = before
        self.seq -= samples
        self.late += 1

    def since_last(self, sample: FingertipState) -> float:
        """Return the time [s] from the last sample taken to ``sample``; -1 when that is the first."""
        return -1.0 if self.taken is None else elapsed_time(sample.stamp, self.taken.stamp) / NS

    def take(self, sample: FingertipState, *, informs: bool) -> None:
        """Take note that ``sample`` was taken, and whether it ``informs``: says something of the contact."""
        self.taken, self.is_trusted = sample, True
        if informs:
            self._informed = sample.stamp
        self.seq += 1

    def age(self, sample: FingertipState) -> float:
        """Return how old [s] the last sample that informed is at ``sample``; inf when there was none."""
        return (sample.stamp - self._informed) / NS if self._informed == self._informed else math.inf

    def write_to(self, memory: NamedNumbers) -> None:
        """Hand everything to the compiled finger step."""
        taken, offered = self.taken, self.offered
        is_informed = self._informed == self._informed
        memory["SAMPLE_BEGUN"], memory["SAMPLE_STAMP"] = taken is not None, taken.stamp if taken else 0
        memory["SAMPLE_IS_INFORMED"], memory["SAMPLE_INFORMED"] = (
            is_informed,
            self._informed if is_informed else 0,
        )
        memory["SAMPLE_SHOWN"], memory["SAMPLE_TRUSTED"] = offered.stamp if offered else 0, self.is_trusted
        memory["SAMPLE_SEQ"], memory["SAMPLE_RESUMED"] = self.seq, self._is_resumed
        memory["SAMPLE_REFUSED"], memory["SAMPLE_BACKWARDS"] = self.refused, self._refused_in_a_row
        memory["SAMPLE_LATE"], memory["SAMPLE_FOLLOWED"] = self.late, self.followed
        memory["TAKEN_LOAD"], memory["TAKEN_TORQUE"] = self.load, self.torque
        memory["SETUP_RECOVERY"], memory["SETUP_GAP"] = self._recovery, self._unknown_gap


class MemoryClock:
    """The clock of an estimator whose samples the finger step takes: what is read of its memory.

    Args:
        memory: of the finger.
        finger: its name.

    """

    def __init__(self, memory: NamedNumbers, finger: str) -> None:
        self._memory, self._finger = memory, finger

    def reset(self) -> None:
        """Begin before the first sample."""
        for name in SAMPLE_COUNTS:
            self._memory[f"SAMPLE_{name}"] = 0
        self._memory["TAKEN_LOAD"] = self._memory["TAKEN_TORQUE"] = NAN

    def resume(self) -> None:
        """As :meth:`SampleClock.resume`."""
        self.reset()
        self._memory["SAMPLE_RESUMED"] = 1

    @property
    def taken(self) -> FingertipState | None:
        """The last sample that was taken: its stamp, and whether slip was felt in the last one offered."""
        memory = self._memory
        if not memory["SAMPLE_BEGUN"]:
            return None
        rows = memory.section("HISTORY").reshape(-1, KEPT_CHANNELS)
        slip = float(rows[(memory["TURN_NOTED"] - 1) % len(rows), SLIP_AT]) if len(rows) else NAN
        return FingertipState(memory["SAMPLE_STAMP"], self._finger, 0, slip=slip)

    @property
    def offered(self) -> FingertipState | None:
        """The last sample, taken or not."""
        stamp = self._memory["SAMPLE_SHOWN"]
        return FingertipState(stamp, self._finger, 0) if stamp or self._memory["SAMPLE_BEGUN"] else None

    @property
    def is_trusted(self) -> bool:
        """Whether the last sample offered was taken."""
        return bool(self._memory["SAMPLE_TRUSTED"])

    @property
    def seq(self) -> int:
        """Samples taken."""
        return int(self._memory["SAMPLE_SEQ"])

    @property
    def refused(self) -> int:
        """Samples refused because their stamp did not advance."""
        return int(self._memory["SAMPLE_REFUSED"])

    @property
    def late(self) -> int:
        """Samples that came late and were put in their place."""
        return int(self._memory["SAMPLE_LATE"])

    @property
    def followed(self) -> int:
        """How often the sender's clock had started anew."""
        return int(self._memory["SAMPLE_FOLLOWED"])

    @property
    def offers(self) -> int:
        """Samples offered, taken or not."""
        return int(self._memory["TURN_NOTED"])

    @property
    def load(self) -> float:
        """Tangential force of the last sample taken [N]."""
        return float(self._memory["TAKEN_LOAD"])

    @property
    def torque(self) -> float:
        """Torque of the last sample taken [N m]."""
        return float(self._memory["TAKEN_TORQUE"])

    def age(self, sample: FingertipState) -> float:
        """Return how old [s] the last sample that informed is at ``sample``; inf when there was none."""
        memory = self._memory
        is_informed = memory["SAMPLE_IS_INFORMED"]
        return (sample.stamp - memory["SAMPLE_INFORMED"]) / NS if is_informed else math.inf
