"""The states of all fingers of a hand -> their FD frames, in one compiled call and without messages."""

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np

from vegrip.errors import ConfigError
from vegrip.hand_sample import HandSample
from vegrip.transport.codec.convert import Converter, Real
from vegrip.transport.codec.database import database
from vegrip.transport.codec.layout import Layout
from vegrip.transport.codec.row_kernels import CRC_TABLE, Bytes, pack_states


class StateRows:
    """Frames of states, packed into the rows of an array; the bytes are those of the encoder.

    Args:
        layout: of states in FD frames.
        offsets: added to the base identifier, one for each finger.
        version: of the message set.
        clipped: where values that float32 cannot hold are counted, by field; they go out as "not measured".

    Raises:
        ConfigError: the layout is not one frame of float32 that all may be missing.

    """

    def __init__(self, layout: Layout, offsets: Sequence[int], version: int, clipped: Counter[str]) -> None:
        (part,) = layout.parts
        if part.time is None or not all(_may_be_missing(slot.convert) for slot in part.slots):
            raise ConfigError(f"fingertip.dbc: {part.name} must have a time and float32 that may be missing")
        signals = {s.name: s.start // 8 for s in database().get_message_by_name(part.name).signals}
        self.identifiers = tuple(part.base + offset for offset in offsets)
        self.length = part.length
        self._names = [slot.name for slot in part.slots]
        self._places = np.array([signals[name] for name in ("seq", "time", *self._names)])
        self._ids = np.array(self.identifiers)
        self._version_at, self._version = signals["version"], version % part.version_modulus
        self._modulus = part.modulus
        self._clipped = clipped
        self._clips = np.zeros(len(self._names), np.int64)

    def prepare(self, rows: Bytes) -> None:
        """Write what is the same in all frames into the first bytes of ``rows``, (n, ``length`` or more)."""
        rows[:, self._version_at] = self._version

    def pack(self, rows: Bytes, sample: HandSample) -> None:
        """Write the frames of ``sample`` into the first bytes of prepared ``rows``, but for what is lost."""
        counter = sample.seq % self._modulus
        found = pack_states(
            rows, self.length, sample.values, sample.stamps, counter, sample.lost, self._ids, self._places,
            CRC_TABLE, self._clips,
        )  # fmt: skip
        if found:
            self._clipped.update(
                {name: int(n) for name, n in zip(self._names, self._clips, strict=True) if n}
            )
            self._clips[:] = 0


def _may_be_missing(convert: Converter) -> bool:
    real = isinstance(convert, Real) and not (convert.required or convert.infinite)
    return real and math.isnan(convert.absent)
