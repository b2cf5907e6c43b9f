"""Supervision of one finger's input: what arrives must be new, alive, believable and in time.

======================  ====================================================================================
what is seen            condition
======================  ====================================================================================
nothing for `time_out`  STALE (MISSING when there never was anything; CORRUPT while frames come but are bad)
state too late          STALE: it took `time_out` longer than the quickest one; clocks need not agree
counter or stamp        REPLAYED: runs backwards or stands still
a value out of range    OUT_OF_RANGE, infinities included
all values frozen       FROZEN: the counter runs, every mechanical channel repeats itself to the last bit
normal force frozen     FROZEN: the same of the normal force alone, for longer; at once when it has noise,
                        or when the tip is pressed in or let go meanwhile
no force, no position   MISSING
a channel went missing  DEGRADED: it had been there; the rest is good
======================  ====================================================================================

Before a normal force that stands still counts as frozen, it is `doubtful`: it may be a coarse sensor at rest,
so control goes on, but lowers nothing on its word.

A fault is seen at once and left only after `recover_after` good states in a row: hysteresis, so that a loose
plug does not toggle the controller. This protects against faults, not attackers (keys are the transport's).
"""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import compress

from vegrip.clock import NS
from vegrip.config import parameter
from vegrip.estimator.elapsed import elapsed_time
from vegrip.grip.safety.frozen_signal import FrozenSignal
from vegrip.grip.safety.ranges import CHECKED_CHANNELS, Ranges, bounds_of, checked_values
from vegrip.grip.safety.stuck_noise import StuckNoise
from vegrip.grip.safety.travel import Travel
from vegrip.messages import Condition, FingertipState
from vegrip.types import NamedNumbers

MECHANICAL = ("normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "displacement")
LEAP = 86_400  # [s] by which a stamp may be ahead of the sender's clock as it was; more is no clock of a hand
DRIFT_PART = 5000  # two quartz clocks part by less than one part in so many, with a wide berth
NO_QUICKEST = 1 << 62  # [ns] nothing has come yet


@dataclass(frozen=True)
class WatchdogSettings:
    """When input stops being believed."""

    time_out: float = parameter(0.05, unit="s", low=0.001, high=10.0, doc="input older than this is stale")
    frozen_after: float = parameter(
        0.25, unit="s", low=0.01, high=3600.0, doc="all values the same for so long: frozen"
    )
    force_frozen_after: float = parameter(
        2.0, unit="s", low=0.01, high=3600.0, doc="the same of the normal force alone"
    )
    frozen_chance: float = parameter(
        1e-7,
        unit="1",
        low=0.0,
        high=0.01,
        doc="frozen at once when a noisy normal force repeats itself more often than with this chance",
    )
    doubt_after: float = parameter(
        0.05,
        unit="s",
        low=0.001,
        high=3600.0,
        doc="normal force the same for so long: not lowered on its word",
    )
    stuck_travel: float = parameter(
        3e-4,
        unit="m",
        low=1e-6,
        high=1.0,
        doc="frozen when the normal force stands still while the tip is pressed in or let go by more",
    )
    recover_after: int = parameter(5, unit="states", low=1, high=1000, doc="good states that end a fault")
    ranges: Ranges = field(default_factory=Ranges)


class InputWatchdog:
    """Judge every state of one finger, and the silence between them."""

    def __init__(self, settings: WatchdogSettings) -> None:
        self.settings = settings
        self.reset()

    def reset(self) -> None:
        """Forget the past; time begins with the next state or tick."""
        self.condition = Condition.MISSING
        self.faults: Counter[Condition] = Counter()
        self.doubtful = False  # the normal force stands still; too early to call it frozen
        self._good = 0  # good states in a row
        self.lost: frozenset[str] = frozenset()  # channels that had been there and now are not
        self._seen: frozenset[str] = frozenset()  # channels that were measured at least once
        self._present: tuple[bool, ...] = ()  # which channels the last state had
        self._usable = False  # and whether they suffice
        self._last: FingertipState | None = None
        self._heard: int | None = None  # [ns] when something last arrived, or the first tick
        self._corrupt: int | None = None  # [ns] when something last arrived broken
        self._quickest = NO_QUICKEST  # [ns] least difference between arrival and stamp
        self._leaps = 0  # states in a row whose stamp is far ahead
        self._all_still = FrozenSignal(*MECHANICAL)
        self._force_still = FrozenSignal("normal_force")
        self._force_noise = StuckNoise("normal_force")
        self._travel = Travel(self.settings.stuck_travel, self.settings.doubt_after * NS)

    def accept(self, state: FingertipState, now: int) -> bool:
        """Judge ``state`` arriving at ``now`` [ns]; tell whether the estimator may use it."""
        found = max(
            self._order(state),
            self._lateness(state, now),
            self._believable(state) or self._alive(state, now),
            self._complete(state),
        )
        self._last, self._heard = state, now
        replayed = self.condition == Condition.REPLAYED  # until it is over, a good one may be an old one
        self._judge(found)
        return found <= Condition.DEGRADED and (not replayed or self.condition <= Condition.DEGRADED)

    def write_to(self, memory: NamedNumbers) -> None:
        """Put settings and all that is known into a memory (:mod:`vegrip.grip.layout` has the names)."""
        settings, last = self.settings, self._last
        memory["RULE_TIME_OUT"] = settings.time_out * NS
        memory["RULE_FROZEN_AFTER"] = settings.frozen_after * NS
        memory["RULE_FORCE_FROZEN_AFTER"] = settings.force_frozen_after * NS
        memory["RULE_DOUBT_AFTER"] = settings.doubt_after * NS
        memory["RULE_FROZEN_CHANCE"] = settings.frozen_chance
        memory["RULE_STUCK_TRAVEL"] = settings.stuck_travel
        memory["SETUP_RECOVER_AFTER"] = settings.recover_after
        bounds = bounds_of(settings.ranges)
        memory.section("LOWEST")[:] = [low for low, _ in bounds]
        memory.section("HIGHEST")[:] = [high for _, high in bounds]
        memory["INPUT_CONDITION"], memory["INPUT_GOOD"] = self.condition, self._good
        memory["INPUT_DOUBTFUL"], memory["INPUT_USABLE"] = self.doubtful, self._usable
        memory["INPUT_LOST"], memory["INPUT_SEEN"] = _bits(self.lost), _bits(self._seen)
        memory["INPUT_PRESENT"] = _bits(compress(CHECKED_CHANNELS, self._present))
        memory["INPUT_IS_HEARD"], memory["INPUT_HEARD"] = self._heard is not None, self._heard or 0
        memory["INPUT_IS_CORRUPT"], memory["INPUT_CORRUPT"] = self._corrupt is not None, self._corrupt or 0
        memory["INPUT_IS_KNOWN"] = last is not None
        memory["INPUT_SEQ"], memory["INPUT_STAMP"] = (0, 0) if last is None else (last.seq, last.stamp)
        memory["INPUT_LEAPS"], memory["INPUT_QUICKEST"] = self._leaps, self._quickest
        memory.section("FAULTS")[:] = [self.faults[condition] for condition in Condition]
        self._all_still.write_to(memory, "REPEATED", "INPUT_STILL_SINCE")
        self._force_still.write_to(memory, "REPEATED_FORCE", "INPUT_FORCE_STILL_SINCE")
        self._force_noise.write_to(memory)
        self._travel.write_to(memory)

    def read_from(self, memory: NamedNumbers, last: FingertipState) -> None:
        """Take all that is known from where :meth:`write_to` puts it; ``last`` is the last state, if any."""
        self.condition, self._good = Condition(int(memory["INPUT_CONDITION"])), int(memory["INPUT_GOOD"])
        self.doubtful, self._usable = bool(memory["INPUT_DOUBTFUL"]), bool(memory["INPUT_USABLE"])
        self.lost, self._seen = _channels(memory["INPUT_LOST"]), _channels(memory["INPUT_SEEN"])
        present = _channels(memory["INPUT_PRESENT"])
        self._present = tuple([name in present for name in CHECKED_CHANNELS])
        self._heard = int(memory["INPUT_HEARD"]) if memory["INPUT_IS_HEARD"] else None
        self._corrupt = int(memory["INPUT_CORRUPT"]) if memory["INPUT_IS_CORRUPT"] else None
        self._last = last if memory["INPUT_IS_KNOWN"] else None
        self._leaps, self._quickest = int(memory["INPUT_LEAPS"]), int(memory["INPUT_QUICKEST"])
        counts = zip(Condition, memory.section("FAULTS").tolist(), strict=True)
        self.faults = Counter({condition: count for condition, count in counts if count})
        self._all_still.read_from(memory, "REPEATED", "INPUT_STILL_SINCE")
        self._force_still.read_from(memory, "REPEATED_FORCE", "INPUT_FORCE_STILL_SINCE")
        self._force_noise.read_from(memory)
        self._travel.read_from(memory)

    def corrupt(self, now: int) -> None:
        """Note that a frame of this finger arrived broken at ``now`` [ns]."""
        self._corrupt = now

    def tick(self, now: int) -> Condition:
        """Look at the clock: silence beyond the time-out is a fault."""
        if self._heard is None:
            self._heard = now
        if elapsed_time(now, self._heard) > self.settings.time_out * NS:
            self._judge(self._silence(now))
        return self.condition

    def _silence(self, now: int) -> Condition:
        if self._corrupt is not None and elapsed_time(now, self._corrupt) <= self.settings.time_out * NS:
            return Condition.CORRUPT
        return Condition.MISSING if self._last is None else Condition.STALE

    def _judge(self, found: Condition) -> None:
        if found > Condition.DEGRADED:
            if found != self.condition:
                self.faults[found] += 1
            self.condition, self._good = found, 0
            return
        self._good += 1
        if self.condition <= Condition.DEGRADED or self._good >= self.settings.recover_after:
            self.condition = found

    def _order(self, state: FingertipState) -> Condition:
        last = self._last
        if last is None or (state.seq > last.seq and state.stamp > last.stamp):
            return Condition.OK
        self._quickest = NO_QUICKEST  # should the sender have started anew, so has its clock
        return Condition.REPLAYED

    def _lateness(self, state: FingertipState, now: int) -> Condition:
        took = elapsed_time(now, state.stamp)
        if self._leapt(took):
            return Condition.REPLAYED
        since = 0 if self._heard is None else elapsed_time(now, self._heard)
        self._quickest = min(max(self._quickest + since // DRIFT_PART, -NO_QUICKEST), took)
        late = elapsed_time(took, self._quickest) > self.settings.time_out * NS
        return Condition.STALE if late else Condition.OK

    def _leapt(self, took: int) -> bool:
        """Whether a stamp is far ahead; a sender that goes on so has another clock, and is believed then."""
        ahead = self._quickest < NO_QUICKEST and took < self._quickest - LEAP * NS
        self._leaps = self._leaps + 1 if ahead else 0
        if self._leaps > self.settings.recover_after:
            self._leaps, self._quickest = 0, NO_QUICKEST
        return self._leaps > 0

    def _believable(self, state: FingertipState) -> Condition:
        outside = self.settings.ranges.first_outside(state)
        return Condition.OUT_OF_RANGE if outside else Condition.OK

    def _alive(self, state: FingertipState, now: int) -> Condition:
        all_still, force_still = self._all_still.duration(state, now), self._force_still.duration(state, now)
        self.doubtful = force_still > self.settings.doubt_after * NS
        passed = 0 if self._heard is None else elapsed_time(now, self._heard)
        travelled = self._travel.is_proven(state, now, passed, force_still)
        frozen = (
            self._force_noise.vanished(state, self.settings.frozen_chance)
            or travelled
            or all_still > self.settings.frozen_after * NS
            or force_still > self.settings.force_frozen_after * NS
        )
        return Condition.FROZEN if frozen else Condition.OK

    def _complete(self, state: FingertipState) -> Condition:
        present = tuple([value == value for value in checked_values(state)])  # noqa: PLR0124 (NaN is not itself)
        if present != self._present:  # seldom, so what follows may take its time
            self._present = present
            measured = frozenset(compress(CHECKED_CHANNELS, present))
            self._usable = bool(measured & {"normal_force", "displacement"})
            self._seen |= measured
            self.lost = self._seen - measured
        if not self._usable:
            return Condition.MISSING
        return Condition.DEGRADED if self.lost else Condition.OK


def _bits(channels: Iterable[str]) -> int:
    """Return a set of channels, bit by bit."""
    return sum(1 << CHECKED_CHANNELS.index(name) for name in channels)


def _channels(bits: float) -> frozenset[str]:
    """Return the set of channels of its bits."""
    return frozenset(name for i, name in enumerate(CHECKED_CHANNELS) if int(bits) >> i & 1)
