"""Messages <-> frames of ``proto/fingertip.dbc``, on whatever carries them under identifiers of its own."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, Final

from vegrip.clock import NS
from vegrip.messages import ContactEstimate, FingertipState, ForceCommand, Message, SlipMargin
from vegrip.transport.codec.database import Layout, layouts
from vegrip.transport.codec.decoder import Assembly, Decoder, HandClock
from vegrip.transport.codec.encoder import Encoder
from vegrip.transport.codec.frame import Frame
from vegrip.transport.codec.signals import Raw
from vegrip.types import NamedNumbers

WHOLE: Final = frozenset({"counter", "incomplete"})
"""Why a frame is refused that is whole: it is old, or another one is missing."""


class Line:
    """How states and commands of a finger travel in FD frames, for a program that handles the bytes itself.

    Args:
        states: of the finger.
        commands: of the finger.
        reports: of what is told of it: contact and slip margin.

    """

    def __init__(self, states: Decoder, commands: Encoder, reports: Sequence[Encoder]) -> None:
        self.state_id, self.command_id = states.identifier, commands.identifiers[0]
        self.report_ids = tuple(identifier for encoder in reports for identifier in encoder.identifiers)
        """Of the frames of a report, where each is one: both of a contact, and that of a slip margin."""
        self._sender_time = states.uses_sender_time
        self._sequence = states.assembly.sequence
        self._commands = commands

    def carries(self, lifetime: float) -> bool:
        """Return whether a command can say that it lives for ``lifetime`` [s]."""
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

    Args:
        fingers: names in the order of their numbers.

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

    def reset(self) -> None:
        """Forget all counters: what comes next begins new streams (a replay that starts over)."""
        for decoder in self._decoders.values():
            decoder.assembly.reset()

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
