"""The endpoint of a hand in parts, each a map at a transport of its own; a hand of one map is one part.

States go up under the names of the hand, commands go to the part that presses with their finger. One drive
of several fingers gets the largest force that any of them needs, of those that it can make.
"""

import math
import select
import time
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Any, Final

from vegrip.clock import NOT_YET, NS
from vegrip.grip.safety.drive import DriveLimits
from vegrip.messages import DeviceReport, FingertipState, ForceCommand, Message, make_row
from vegrip.transport.endpoint import PART_BACK, PART_GONE, Endpoint
from vegrip.transport.hands.drive_steps import OPEN_N, Commanded, least_force_sentence, next_force
from vegrip.transport.hands.jaw_balance import JawBalance
from vegrip.transport.hands.wrist_load import WristLoad
from vegrip.transport.sender_clock import ClockEstimate

ROUND_NS: Final = 2 * NS // 1000  # [ns] after which each part is asked again: it may have something to say
LOOK_NS: Final = NS // 5  # [ns] between two looks at how the parts are
SILENT_NS: Final = NS  # [ns] without a word of a part that had spoken
FIRST_WORD_NS: Final = 3 * NS  # [ns] for its first: an opening takes its time
LOST: Final = ("link_lost", "silent", "bus_lost", "no_traffic")
"""What an endpoint counts when its device has gone."""
HOLDING: Final = "holding"
"""What a gripper says that is not empty: a node that starts anew while it holds must not weigh the object."""
NOT_EMPTY: Final = (
    "holds something, and the load is known once it was weighed empty: bear the object by hand, `vegrip "
    "lifecycle set NODE inactive`, `vegrip zero NODE`, and a second later set it active"
)


def times_lost(endpoint: Endpoint) -> int:
    return sum(endpoint.rejected.get(name, 0) for name in LOST)


@dataclass(slots=True)
class Part:
    """One device, or bus, of a hand."""

    name: str
    where: str  # its map and port
    endpoint: Endpoint
    names: Mapping[str, str]  # its finger -> that of the hand
    role: str = "sensor"  # or drive, or wrist
    received: int = 0  # [ns] when it last said something
    lost: int = 0  # of its counts
    lost_at: int = 0  # [ns] 0: it is there


@dataclass(slots=True)
class Drive:
    """A drive that presses with some fingers at once."""

    part: Part
    fingers: tuple[str, ...]  # as its map calls them
    serves: tuple[str, ...]
    limits: DriveLimits
    commanded: Commanded = field(default_factory=Commanded)
    felt: float = math.nan  # [N] as it says itself
    known: float = 0.0  # [N] the least that it presses with by what it surely took
    _needs: dict[str, float] = field(default_factory=dict)
    _sent: int = NOT_YET

    @property
    def need(self) -> float:
        return max(self._needs.values(), default=0.0)

    def take(self, command: ForceCommand) -> None:
        """Take the command of a finger; command the drive, no sooner than it can take it."""
        if not 0.0 <= command.normal_force < math.inf:
            return
        self._needs[command.finger] = command.normal_force
        before, now, need = self.commanded, command.stamp, self.need
        if not self.takes_commands and need >= OPEN_N:
            need = max(need, self.known)  # what is needed of a force that may be another lowers none
        self._note_taken(now)
        self.commanded = next_force(self.limits, before, need, now)
        if self.takes_commands:
            self.known = min(self.known, self.commanded.force)
        is_new = self.commanded.force != before.force
        if not is_new and self.limits.rate > 0.0 and now - self._sent < NS / self.limits.rate:
            return
        self._sent = now
        change = self.commanded.force - before.force
        for finger in self.fingers:
            values = (now, finger, command.seq, self.commanded.force, change, command.reason, command.expires)
            self.part.endpoint.send(make_row(ForceCommand, values))

    def pressing(self, now: int) -> float:
        """Return what it surely presses with [N]: what it says, else what it took less hysteresis."""
        if not (math.isnan(self.felt) or self.part.lost_at):
            return self.felt
        self._note_taken(now)
        return max(self.known - self.limits.hysteresis, 0.0)

    @property
    def takes_commands(self) -> bool:
        """Whether it is there and ready; one that is not holds what it took before."""
        endpoint = self.part.endpoint
        return not self.part.lost_at and times_lost(endpoint) <= self.part.lost and endpoint.obeys

    def _note_taken(self, now: int) -> None:
        """See whether it has answered since the last command had its time."""
        answered = self.part.endpoint.heard or now
        if answered - self.commanded.at >= self.limits.delay * NS and self.takes_commands:
            self.known = self.commanded.force


class Joined(Endpoint):
    """Several endpoints as one; they are closed with it."""

    def __init__(self, parts: Sequence[Part]) -> None:
        self._parts = tuple(parts)
        self._counts: Counter[str] = Counter()

    @property
    def rejected(self) -> Mapping[str, int]:
        found = Counter(self._counts)
        for part in self._parts:
            found.update(part.endpoint.rejected)
        return dict(found)

    def close(self) -> None:
        for part in self._parts:
            part.endpoint.close()


class BenchEndpoint(Joined):
    """All parts of a hand as one.

    Besides what the parts count, ``rejected`` has ``lost_NAME`` of a part that has gone, ``back_NAME`` of one
    that has come back, ``uneven_jaws`` of states in which two opposed fingers felt too unlike forces,
    ``not_empty`` of readings of the wrist that cannot be weighed, ``impossible_force`` of looks at a pad that
    feels twice what the drive can, and ``more_than_needed`` of looks at a drive whose least force is far
    above what is needed; :attr:`hints` says which, in its words.

    Args:
        parts: of the hand.
        drives: of which each presses with some fingers; with others the part presses that has them.
        wrist: the load of the fingers of the first drive, felt by a part.
        sentences: what their owner must know.

    """

    def __init__(
        self,
        parts: Sequence[Part],
        drives: Sequence[Drive] = (),
        wrist: WristLoad | None = None,
        sentences: Callable[[], Sequence[str]] = tuple,
    ) -> None:
        super().__init__(parts)
        self._wrist, self._sentences = wrist, sentences
        self._drives = {finger: drive for drive in drives for finger in drive.serves}
        self._drive = drive = next(iter(drives), None)
        self._of = {ours: part for part in parts if part.role == "sensor" for ours in part.names.values()}
        served = drive.serves if drive is not None else ()
        self._shared = served if wrist is not None else ()
        self._blind = tuple(finger for finger in self._shared if finger not in self._of)
        self._sharing = set(self._blind)  # whose load is felt at the wrist alone
        is_pair = len(served) == 2 and not self._blind
        self._balance = JawBalance(served[0], served[1]) if is_pair else None
        self._hints: dict[str, str] = {}
        self._looked, self._seq = time.monotonic_ns(), 0
        self._uneven = 0  # of its counts, at the last look
        self._round_at = 0  # [ns] when each part is asked
        self._opened = self._looked
        self.broken: dict[str, int] = {}

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s] for a state of any part, then take what is there."""
        deadline = time.monotonic_ns() + round(timeout * NS)
        messages: list[Message] = []
        arrivals: list[int] = []
        is_alone = len(self._parts) == 1
        while True:
            for part in self._parts if is_alone else self._ready(deadline):
                self._take(part, timeout if is_alone else 0.0, messages, arrivals)
            now = time.monotonic_ns()
            if messages or is_alone or now >= deadline:
                break
        if now - self._looked >= LOOK_NS:
            self._look(now)
        self.arrivals = arrivals
        return messages

    def send(self, message: Message) -> None:
        """Send a command to what presses with its finger; other messages are not for a foreign hand."""
        if not isinstance(message, ForceCommand):
            return
        if (drive := self._drives.get(message.finger)) is not None:
            drive.take(message)
        elif (part := self._of.get(message.finger)) is not None:
            part.endpoint.send(message)

    @property
    def conditions(self) -> Set[str]:
        return frozenset().union(*(part.endpoint.conditions for part in self._parts))

    @property
    def device_faults(self) -> Set[tuple[str, str]]:
        return {(part.where, name) for part in self._parts for _, name in part.endpoint.device_faults}

    @property
    def hints(self) -> Mapping[str, str]:  # type: ignore[override]
        return {name: one for part in self._parts for name, one in part.endpoint.hints.items()} | self._hints

    @property
    def sentences(self) -> Sequence[str]:
        return self._sentences()

    @property
    def clock(self) -> ClockEstimate | None:
        return next((part.endpoint.clock for part in self._parts if part.endpoint.clock is not None), None)

    @property
    def in_trouble(self) -> bool:
        return any(part.endpoint.in_trouble for part in self._parts)

    def bus_load(self) -> float:
        """Return that of the only part, NaN where there are several."""
        return self._parts[0].endpoint.bus_load() if len(self._parts) == 1 else math.nan

    def select(self, kinds: Collection[type[Message]]) -> None:
        for part in self._parts:
            part.endpoint.select(kinds)

    def zero(self) -> bool:
        asked = [part.endpoint.zero() for part in self._parts]
        if self._wrist is not None:
            self._wrist.take_tare()
        return any(asked) or self._wrist is not None

    def _take(self, part: Part, timeout: float, messages: list[Message], arrivals: list[int]) -> None:
        received = part.endpoint.receive(timeout)
        if part.endpoint.broken:
            self.broken |= {part.names.get(name, name): count for name, count in part.endpoint.broken.items()}
        if not received:
            return
        part.received = part.endpoint.arrivals[-1]
        for message, arrival in zip(received, part.endpoint.arrivals, strict=True):
            for each in self._as_ours(part, message):
                messages.append(each)
                arrivals.append(arrival)

    def _as_ours(self, part: Part, message: Message) -> Sequence[Message]:
        """Return the states of our fingers that ``message`` of a part makes."""
        if part.role == "sensor":
            felt = self._felt(part, message)
            return () if felt is None else (felt,)
        if not isinstance(message, FingertipState):
            return ()
        if part.role == "drive" and self._drive is not None:
            self._drive.felt = message.normal_force
        if part.role != "wrist" or self._wrist is None or self._drive is None:
            return ()
        if not self._wrist.is_begun and HOLDING in self._drive.part.endpoint.conditions:
            self._tell("not_empty", f"{self._drive.part.where} {NOT_EMPTY}")
            return ()
        self._wrist.note(message)
        self._seq += 1
        force, (share, torque) = self._drive.pressing(message.stamp), self._wrist.share(message.stamp)
        if not self._wrist.is_known:  # it is being weighed: a finger without a load would count as frozen
            return ()
        return [
            FingertipState(message.stamp, finger, self._seq, force, share, share * 0.0, torque)
            for finger in self._blind
        ]

    def _felt(self, part: Part, message: Message) -> Message | None:
        """Return ``message`` under our name of its finger, with the load that only the wrist feels.

        None while the gripper has to be weighed for it: nothing may be commanded that closes the jaws.
        """
        if not isinstance(message, (DeviceReport, FingertipState)):
            return message
        ours = part.names.get(message.finger, message.finger)
        changes: dict[str, Any] = {"finger": ours} if ours != message.finger else {}
        if isinstance(message, FingertipState):
            if self._wrist is not None and ours in self._shared and math.isnan(message.tangential_force_x):
                self._sharing.add(ours)
                if not self._wrist.is_known:
                    return None
                share, torque = self._wrist.share(message.stamp)
                changes |= {"tangential_force_x": share, "tangential_force_y": share * 0.0}
                changes |= {"torque_z": torque} if math.isnan(message.torque_z) else {}
            if self._balance is not None and self._balance.note(ours, message.normal_force, message.stamp):
                self._counts["uneven_jaws"] += 1
        return replace(message, **changes) if changes else message

    def _ready(self, deadline: int) -> Sequence[Part]:
        """Wait up to ``deadline`` [ns]; return the parts to which something has come, all of them in turn."""
        now = time.monotonic_ns()
        if now >= self._round_at:
            self._round_at = now + ROUND_NS
            return self._parts
        seconds = max(min(deadline, self._round_at) - now, 0) / NS
        of = {number: part for part in self._parts for number in part.endpoint.descriptors}
        found = select.select(list(of), [], [], seconds)[0]
        return [part for part in self._parts if any(of[number] is part for number in found)]

    def _look(self, now: int) -> None:
        """See which part has gone, and put what is wrong into words."""
        is_listening, self._looked = now - self._looked < SILENT_NS, now
        if not is_listening:  # the node did not receive meanwhile, as while it compiles
            self._begin_anew(now)
        gone = []
        for part in self._parts if len(self._parts) > 1 else ():
            lost, heard = times_lost(part.endpoint), max(part.received, part.endpoint.heard)
            last = part.received + SILENT_NS if part.received else self._opened + FIRST_WORD_NS
            is_mute = part.role != "drive" and now > last
            if is_mute or lost > part.lost:
                part.lost_at = part.lost_at or now
                gone.append(part)
            elif (heard if part.role == "drive" else part.received) > part.lost_at > 0:
                part.lost_at = 0
                self._tell(f"{PART_BACK}{part.name}", f"{part.where} is received again")
            part.lost = lost
        for part in gone:  # once it is known of all
            self._tell(f"{PART_GONE}{part.name}", self._of_loss(part))
        if self._balance is not None and self._drive is not None:
            self._look_at_jaws(self._balance, self._drive.limits.maximum)
        for drive in self._drives.values():
            if said := drive.part.endpoint.hints.get("not_ready"):
                self._hints["not_ready"] = (
                    f"{said}; it counts as pressing {drive.known:.1f} N, what it took last"
                )
            if drive.commanded.force > 0.0 and (said := least_force_sentence(drive.limits, drive.need)):
                self._tell("more_than_needed", f"{said} ({drive.need:.1f} N)")

    def _tell(self, name: str, hint: str) -> None:
        self._counts[name] += 1
        self._hints[name] = hint

    def _begin_anew(self, now: int) -> None:
        self._opened = now
        for part in self._parts:
            part.received = now if part.received else 0
            part.lost = times_lost(part.endpoint)

    def _look_at_jaws(self, balance: JawBalance, most: float) -> None:
        felt = balance.means
        if beyond := [f"{name} {force:.0f} N" for name, force in felt.items() if abs(force) > 2.0 * most]:
            said = f"{', '.join(beyond)} is felt, and the gripper is commanded {most:g} N at most"
            self._tell("impossible_force", f"{said}: 'unit' or 'scale' in the map of that pad is wrong")
        before, self._uneven = self._uneven, self._counts["uneven_jaws"]
        if beyond or self._uneven == before:
            return
        told = ", ".join(f"{name} {force:.1f} N" for name, force in felt.items())
        self._hints["uneven_jaws"] = (
            f"the jaws feel different forces ({told}), more than noise and gains allow: one touches "
            "something else, or carries weight along the closing direction, or has lost its zero "
            "(`vegrip zero`)"
        )

    def _of_loss(self, part: Part) -> str:
        """Return which part has gone, and what is left."""
        if part.role == "drive" and self._drive is not None:
            force = self._drive.known
            held = f"{force:.1f} N" if force else "what it was commanded before"
            return (
                f"the drive {part.where} does not answer, so the force cannot change: it holds {held}, if it "
                "holds by itself; it is opened again each second, and margins are still estimated"
            )
        fingers = sorted(self._sharing) if part.role == "wrist" else list(part.names.values())
        rest = [name for name, of in self._of.items() if name not in fingers and not of.lost_at]
        goes_on = f"; {', '.join(rest)}{self._and_the_drive(len(rest))}" if rest else ""
        if not fingers:
            return f"{part.where} is silent: all fingers feel their load themselves"
        whose = ", ".join(fingers)
        return f"{part.where} is silent: {whose} held, then at the fail-safe force, no lower{goes_on}"

    def _and_the_drive(self, others: int) -> str:
        """Return the end of a sentence on ``others`` that go on, and the drive, if it is there."""
        is_there = self._drive is not None and not self._drive.part.lost_at
        return " and the drive go on" if is_there else " go on" if others > 1 else " goes on"
