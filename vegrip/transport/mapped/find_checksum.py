"""Which checksum a message has, found by trying the usual ones on frames that came."""

from collections.abc import Iterator, Sequence
from typing import Any, Final

from vegrip.config import build
from vegrip.errors import ConfigError
from vegrip.transport.mapped.checksums import ChecksumMap, protection
from vegrip.transport.mapped.database import ForeignMessage

MAX_CHECKSUM_FRAMES: Final = 64  # of different content that it must fit
MIN_CHECKSUM_FRAMES: Final = 4  # fewer tell nothing
POLYNOMIALS: Final = {
    8: (0x1D, 0x2F, 0x07, 0x31, 0x9B, 0x39, 0xD5, 0x49, 0xA7),
    16: (0x1021, 0x8005, 0x8BB7, 0x3D65, 0xA097, 0xC867),
    32: (0x04C11DB7, 0xF4ACFB13, 0x1EDC6F41),
}


def find_checksum(message: ForeignMessage, signal: str, frames: Sequence[bytes]) -> dict[str, Any] | None:
    """Return the table ``checksum`` of the map that fits all ``frames``, None when none of the usual does."""
    length = message.signals[signal].length
    whole = [data[: message.length] for data in frames if len(data) >= message.length]
    different = list(dict.fromkeys(whole))[:MAX_CHECKSUM_FRAMES]
    if len(different) < MIN_CHECKSUM_FRAMES:
        return None
    for candidate in _candidates(message, signal, length):
        try:
            guard = protection(build(ChecksumMap, candidate, "checksum"), message, "checksum")
        except ConfigError:
            continue
        if guard is not None and all(guard.check(data) for data in different):
            return {key: value for key, value in candidate.items() if value not in (False, 0)}
    return None


def _candidates(message: ForeignMessage, signal: str, length: int) -> Iterator[dict[str, Any]]:
    base = {"signal": signal}
    identifier = (message.identifier & 0x7FF, message.identifier >> 8 & 0x7, 0)
    for own in ("left out", "zero"):
        more = {"own": own} if own == "zero" else {}
        for start in (0, 1, 0xFF, sum(identifier[:1]) & 0xFF, (message.identifier & 0xFF) + identifier[1]):
            for final in (0, 0xFF):
                for kind in ("sum", "xor"):
                    yield {**base, **more, "kind": kind, "start": start, "final": final}
    if length not in POLYNOMIALS:
        return
    ones = (1 << length) - 1
    for polynomial in POLYNOMIALS[length]:
        for start in (0, ones):
            for final in (0, ones):
                for reflected in (False, True):
                    crc = {
                        "kind": f"crc{length}",
                        "polynomial": polynomial,
                        "start": start,
                        "final": final,
                        "reflected": reflected,
                    }
                    yield {**base, **crc}
                    for where in ("before", "after"):
                        yield {**base, **crc, "data_id": [message.identifier & 0x7FF], "id_bytes": where}
