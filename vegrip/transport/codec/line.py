"""Messages of one finger in FD frames, for a program that reads and writes the bytes itself."""

from collections.abc import Sequence

from vegrip.clock import NS
from vegrip.transport.codec.cells import Raw
from vegrip.transport.codec.decoder import Decoder
from vegrip.transport.codec.encoder import Encoder
from vegrip.types import NamedNumbers


class Line:
    """Identifiers of a finger's frames, and the counter of its states.

    Args:
        states: of the finger.
        commands: of the finger.
        reports: of what is told of it: contact and slip margin.

    """

    def __init__(self, states: Decoder, commands: Encoder, reports: Sequence[Encoder] = ()) -> None:
        self.state_id, self.command_id = states.identifier, commands.identifier
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
        """Take the counter back."""
        self._sequence.read_from(memory)

    def _raw(self, lifetime: float) -> Raw | None:
        return self._commands.raw("expires", round(lifetime * NS) / NS)
