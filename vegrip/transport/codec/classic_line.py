"""States and commands of one finger in classic frames, for a program that handles the bytes itself."""

from collections import Counter
from collections.abc import Sequence

from vegrip.transport.codec.decoder import Decoder
from vegrip.transport.codec.encoder import Encoder
from vegrip.transport.codec.line import CLASSIC, Line
from vegrip.transport.codec.part_text import ADJUSTMENT, FORCE, HEAD_BYTES
from vegrip.types import NamedNumbers

CLIPPED = {FORCE: "PARTS_CLIPPED_FORCE", ADJUSTMENT: "PARTS_CLIPPED_ADJUSTMENT"}
"""Signal of a command -> where the memory counts what it could not carry."""


class ClassicLine(Line):
    """Identifiers of a finger's frames, and how far its present state has come.

    Args:
        states: of the parts of a state, in their order.
        commands: of the finger.
        clipped: where values that a command cannot carry are counted, by signal.

    """

    wire: str = CLASSIC

    def __init__(self, states: Sequence[Decoder], commands: Encoder, clipped: Counter[str]) -> None:
        super().__init__(states[0], commands)
        self.state_ids = tuple(decoder.identifier for decoder in states)
        self._decoders, self._assembly = states, states[0].assembly
        self._clipped = clipped

    def can_hand_over(self, memory: NamedNumbers) -> bool:  # noqa: ARG002 (see Line)
        """Return whether no state is half-way: who has begun one goes on with it."""
        return not self._assembly.is_open

    def write_to(self, memory: NamedNumbers, lifetime: float) -> None:
        """Put identifiers, counters and the ``lifetime`` [s] of commands into a memory."""
        super().write_to(memory, lifetime)
        self._assembly.write_to(memory)
        for place in CLIPPED.values():
            memory[place] = 0

    def read_from(self, memory: NamedNumbers) -> None:
        """Take back the counters, and the parts of an open state."""
        super().read_from(memory)
        kept = memory.section("PART_BYTES").tolist()
        cells: tuple[float, ...] = ()
        for decoder in self._decoders[: max(0, int(memory["PARTS_EXPECTED"]) - 1)]:
            size = decoder.length - HEAD_BYTES
            cells += decoder.cells(bytes([*[0] * HEAD_BYTES, *kept[:size]]))
            kept = kept[size:]
        self._assembly.read_from(memory, cells)
        for signal, place in CLIPPED.items():
            if memory[place]:
                self._clipped[signal] += int(memory[place])
                memory[place] = 0
