"""Messages <-> frames of ``proto/fingertip.dbc``, on whatever carries them under identifiers of its own.

The decoder of an identifier is one function made of text, the same text for all fingers.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, Final, NamedTuple

from vegrip.clock import NS
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, SlipMargin, make_row
from vegrip.transport.codec.database import Layout, Part, layouts
from vegrip.transport.codec.encoder import MICROSECOND, TIME_MODULUS, Encoder
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.sequence import Sequence as Counted
from vegrip.transport.codec.signals import Cells, Raw, compiled
from vegrip.types import NamedNumbers

HALF: Final = TIME_MODULUS // 2
WINDOW_NS: Final = 5_000_000
"""[ns] All parts arrive within this. It must be shorter than 15 cycles, after which the counter of a classic
frame comes back and a late part could pass for one of the present cycle (15 cycles are 7.5 ms at 2 kHz)."""

HandClock = Callable[[int, int], int]
"""From the hand's stamp and the receive time to the time on our clock, all in ns."""


class Whole(NamedTuple):
    """All cells of a message, its running number, and when its first part arrived."""

    cells: Cells
    seq: int
    stamp: int
    time: int  # the sender's time on the wire


class Assembly:
    """The stream of one kind of message of one finger: parts come in order, of one cycle, or not at all.

    :meth:`put` returns the message when its last part has arrived, None while more must come, or the name of
    the reason for refusing the part.
    """

    __slots__ = ("_absent", "_cells", "_counter", "_expected", "_stamp", "_time", "incomplete", "sequence")

    def __init__(self, parts: tuple[Part, ...], reach: int) -> None:
        self.sequence = Counted(parts[0].modulus, reach if len(parts) == 1 else 0)
        self.incomplete = 0  # messages begun and never finished
        self._absent = [sum((p.absent for p in parts[number:]), ()) for number in range(len(parts) + 1)]
        self._cells: Cells = ()
        self._counter, self._expected = -1, 0  # of the open message; 0 expected: none is open
        self._stamp = self._time = 0

    @property
    def lost(self) -> int:
        """Messages that never arrived, or not whole."""
        return self.sequence.lost + self.incomplete

    def put(
        self, number: int, counter: int, is_last: bool, cells: Cells, stamp: int, time: int
    ) -> Whole | str | None:
        """Take one part that has passed all checks of its own."""
        if number == 1:
            if self.sequence.advance(counter, stamp) is None:
                return "counter"
            self._abandon()
            self._cells, self._counter, self._stamp, self._time = (), counter, stamp, time
        elif counter != self._counter or number != self._expected or stamp - self._stamp > WINDOW_NS:
            return self._refusal(number, counter)
        self._cells += cells
        self._expected = number + 1
        if not is_last and number < len(self._absent) - 1:
            return None
        self._expected = 0
        return Whole(self._cells + self._absent[number], self.sequence.last, self._stamp, self._time)

    def _refusal(self, number: int, counter: int) -> str:
        repeated = counter == self._counter and (number < self._expected or not self._expected)
        if repeated or self.sequence.is_behind(counter):
            return "counter"  # an old part does no harm to the open message
        self._abandon()
        return "incomplete"

    def _abandon(self) -> None:
        self.incomplete += self._expected > 0
        self._expected = 0


class Decoder:
    """Checks and reads the frames of one part of one kind of message of one finger (or node)."""

    def __init__(
        self,
        layout: Layout,
        part: Part,
        assembly: Assembly,
        identifier: int,
        owner: str,
        version: int,
        use_sender_time: bool,
        clock: HandClock | None = None,
    ) -> None:
        self.assembly, self.identifier, self.owner = assembly, identifier, owner
        self.kind: type[Any] = layout.schema.cls
        self.uses_sender_time = (use_sender_time or clock is not None) and part.time is not None
        make = partial(make_row, self.kind) if issubclass(self.kind, tuple) else lambda row: self.kind(*row)
        scope = {"check": part.profile.check, "unpack": part.packer.unpack, "identifier": identifier}
        scope |= {"advance": assembly.sequence.advance, "put": assembly.put, "Whole": Whole, "make": make}
        scope |= {"owner": owner, "version": version % part.version_modulus, "sent": _sent, "clock": clock}
        lines = _lines(layout, part, self.uses_sender_time, clock is not None)
        self.decode: Callable[[Frame], Message | str | None] = compiled(lines, {**layout.scope, **scope})
        """Returns the completed message, None while parts are missing, or the name of the fault."""


def _lines(layout: Layout, part: Part, uses_sender_time: bool, has_clock: bool) -> list[str]:
    """Return the text of :attr:`Decoder.decode`, which is the same for all fingers."""
    time = part.time.text() if uses_sender_time and part.time is not None else "0"
    lines = [
        "def made(frame):",
        " _, data, fd, stamp = frame",
        f" if fd != {part.fd}: return 'layout'",
        f" if len(data) != {part.length}: return 'length'",
        " if not check(data, identifier): return 'checksum'",
        " cells = unpack(data)",
        f" if {part.version.text()} != version: return 'version'",
        f" counter, time = {part.counter.text()}, {time}",
    ]
    if part.last is None:  # the only part: nothing to put together
        lines += [" seq = advance(counter, stamp)", " if seq is None: return 'counter'"]
    else:
        lines += [f" whole = put({part.number}, counter, {part.last.text()} == 1, cells, stamp, time)"]
        lines += [" if whole.__class__ is not Whole: return whole", " cells, seq, stamp, time = whole"]
    stamping = [" received, stamp = stamp, sent(stamp, time)"] if uses_sender_time else []
    lines += [*stamping, *layout.reading, " if None in values: return 'value'"]
    lines += (
        [" stamp = clock(stamp, received)"] if uses_sender_time and has_clock else []
    )  # learns of good ones
    return [*lines, " return make((stamp, owner, seq, *values))"]


def _sent(received: int, time: int) -> int:
    """Return the instant nearest to ``received`` [ns] whose microseconds end in the bits ``time``."""
    now = received // MICROSECOND
    return (now + (time - now + HALF) % TIME_MODULUS - HALF) * MICROSECOND


WHOLE: Final = frozenset({"counter", "incomplete"})
"""Why a frame is refused that is whole: it is old, or another one is missing."""


class Line:
    """How states and commands of a finger travel in FD frames, for who handles the bytes without messages."""

    def __init__(self, states: Decoder, commands: Encoder, reports: Sequence[Encoder]) -> None:
        self.state_id, self.command_id = states.identifier, commands.identifiers[0]
        self.report_ids = tuple(identifier for encoder in reports for identifier in encoder.identifiers)
        """Of the frames of a report, where each is one: both of a contact, and that of a slip margin."""
        self._sender_time = states.uses_sender_time
        self._sequence = states.assembly.sequence
        self._commands = commands

    def carries(self, lifetime: float) -> bool:
        return self._raw(lifetime) is not None

    def write_to(self, memory: NamedNumbers, lifetime: float) -> None:
        """Put identifiers, counter and the ``lifetime`` [s] of commands into a memory."""
        memory["SETUP_STATE_ID"], memory["SETUP_COMMAND_ID"] = self.state_id, self.command_id
        names = ("SETUP_CONTACT1_ID", "SETUP_CONTACT2_ID", "SETUP_MARGIN_ID")
        for name, identifier in zip(names, self.report_ids, strict=False):
            memory[name] = identifier
        memory["SETUP_SENDER_TIME"] = self._sender_time
        memory["SETUP_EXPIRES"] = self._raw(lifetime) or 0
        self._sequence.write_to(memory)

    def read_from(self, memory: NamedNumbers) -> None:
        self._sequence.read_from(memory)

    def _raw(self, lifetime: float) -> Raw | None:
        return self._commands.raw("expires", round(lifetime * NS) / NS)


class FrameCodec:
    """The decoders and encoders of one hand, and the counts of what they refuse.

    ``rejected`` counts refusals by their name, ``broken`` by finger the frames of its states that could not
    be understood, ``clipped``, by field, values that the layout cannot carry.
    """

    def __init__(self, fingers: Sequence[str]) -> None:
        self.fingers = tuple(fingers)
        self.rejected: Counter[str] = Counter()
        self.broken: Counter[str] = Counter()
        self.clipped: Counter[str] = Counter()
        self._encoders: dict[tuple[type[Any], str], Encoder] = {}
        self._decoders: dict[int, Decoder] = {}
        self._version = layouts().version

    @property
    def lost(self) -> int:
        """Messages that never arrived or not whole, over all streams."""
        return sum({id(d.assembly): d.assembly.lost for d in self._decoders.values()}.values())

    def line(self, finger: str) -> Line | None:
        """Return how the bytes of ``finger`` travel; None: not in FD frames of ours."""
        if finger not in self.fingers:
            return None
        states = next(d for d in self._decoders.values() if d.owner == finger and d.kind is FingertipState)
        reports = [self._encoders[kind, finger] for kind in (ContactEstimate, SlipMargin)]
        return Line(states, self._encoders[ForceCommand, finger], reports)

    def add_stream(
        self,
        layout: Layout,
        owner: str,
        offset: int,
        use_sender_time: bool,
        clock: HandClock | None = None,
        reach: int = 0,
    ) -> None:
        """Read and write the messages of ``layout`` of ``owner``, ``offset`` above their base identifiers."""
        self._encoders[layout.schema.cls, owner] = Encoder(layout, offset, self._version, self.clipped)
        assembly = Assembly(layout.parts, reach)
        for part in layout.parts:
            identifier = part.base + offset
            self._decoders[identifier] = Decoder(
                layout, part, assembly, identifier, owner, self._version, use_sender_time, clock
            )

    def encode_as(self, message: Message, owner: str) -> list[Frame]:
        """Return the frames of a message of ``owner``; none, and counted, where it is not configured."""
        encoder = self._encoders.get((type(message), owner))
        if encoder is None:
            self.clipped["finger"] += 1
            return []
        return encoder.encode(message)

    def decode_as(self, identifier: int, frame: Frame, otherwise: str) -> Message | None:
        """Return the message that a frame known as ``identifier`` completes.

        None: there is none (yet), or it is refused, as ``otherwise`` where no message has this identifier.
        """
        decoder = self._decoders.get(identifier)
        result = otherwise if decoder is None else decoder.decode(frame)
        if result.__class__ is not str:
            return result  # type: ignore[return-value]
        self.rejected[result] += 1
        if decoder is not None and decoder.kind is FingertipState and result not in WHOLE:
            self.broken[decoder.owner] += 1
        return None
