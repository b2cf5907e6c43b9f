"""Counter and checksum of the messages of a foreign hand, by their names and by trials on its frames."""

import itertools
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import Any, Final

from vegrip.config import build
from vegrip.connect.drafts import Draft
from vegrip.connect.guess import Guess
from vegrip.connect.traffic import Traffic
from vegrip.errors import ConfigError
from vegrip.transport.mapped.compiled import compile_raw
from vegrip.transport.maps.checksums import ChecksumMap, protection
from vegrip.transport.maps.database import Database
from vegrip.transport.maps.signals import ForeignMessage

MOST_REPEATS: Final = 0.02  # of the frames: a frame repeated now and then is what a counter is for
MIN_TURNS: Final = 3  # that a counter must have made before its end is known
MIN_COUNTER_FRAMES: Final = 10  # frames that prove nothing
MAX_CHECKSUM_FRAMES: Final = 64  # of different content that it must fit
MIN_CHECKSUM_FRAMES: Final = 4  # fewer prove nothing
MOST_START: Final = 0x108  # of a sum: any byte, or both bytes of an identifier together
POLYNOMIALS: Final = {
    8: (0x1D, 0x2F, 0x07, 0x31, 0x9B, 0x39, 0xD5, 0x49, 0xA7),
    16: (0x1021, 0x8005, 0x8BB7, 0x3D65, 0xA097, 0xC867),
    32: (0x04C11DB7, 0xF4ACFB13, 0x1EDC6F41),
}


def find_protection(
    database: Database,
    used: Sequence[str],
    found: Sequence[Guess],
    traffic: Traffic | None,
    said: Collection[str] = (),
) -> tuple[dict[str, Draft], list[str]]:
    """Return the tables of the messages with the signals ``used``, and what remains open.

    Of the messages in ``said`` the user has said the checksum.
    """
    drafts: dict[str, Draft] = {}
    doubts: list[str] = []
    unknown: dict[tuple[str, bool], list[str]] = {}  # checksum, and whether there is traffic -> messages
    came = traffic.frames if traffic is not None else {}
    declared = list(database.messages)
    names = {name.partition(".")[0] for name in used} & database.messages.keys()
    # messages that came first: what is found there is the proposal for those that did not come
    for name in sorted(names, key=lambda n: (database.messages[n].identifier not in came, declared.index(n))):
        message, draft = database.messages[name], Draft({})
        data = [frame.data for frame in came.get(message.identifier, [])]
        named = {one.channel: one.signal for one in reversed(found) if one.message == name}
        counter = named.get("counter") or _rolling(message, used, data)
        why = "its name" if "counter" in named else "it goes up by one from frame to frame"
        if counter and not _counter(draft, message, counter, why, data, drafts.values()):
            doubts.append(
                f"{name}.{counter} does not go up by one from frame to frame (one count for several "
                "pages?), so it is not used, and repeated frames are not seen"
            )
        checksum = named.get("checksum") if name not in said else None
        if checksum and not _checksum(draft, message, checksum, data, drafts.values()):
            unknown.setdefault((checksum, bool(data)), []).append(name)
        if draft.keys:
            drafts[name] = draft
    for (checksum, came_with), (name, *alike) in unknown.items():
        more = f" (and {len(alike)} alike)" if alike else ""
        doubts.append(
            f"{name}.{checksum}{more} looks like a checksum of a kind that is not known "
            f"{'from its' if came_with else 'without'} traffic: frames go unchecked, and commands with a "
            f"wrong one may be refused by the hand; say it{' of each' if alike else ''}: "
            f"--set messages.{name}.checksum='{{ kind = ..., signal = \"{checksum}\" }}'"
        )
    return drafts, doubts


def _rolling(message: ForeignMessage, used: Sequence[str], data: Sequence[bytes]) -> str:
    """Return the signal that counts the frames of ``message``, whatever its name; "" where none does."""
    if len(data) < MIN_COUNTER_FRAMES:
        return ""
    pages = {one.selected_by for one in message.signals.values()}
    unused = [
        name
        for name, one in message.signals.items()
        if f"{message.name}.{name}" not in used and not (one.is_float or one.selected_by or name in pages)
    ]
    return next((name for name in unused if find_modulus(message, name, data) is not None), "")


def _counter(
    draft: Draft,
    message: ForeignMessage,
    signal: str,
    why: str,
    data: Sequence[bytes],
    known: Iterable[Draft],
) -> bool:
    modulus = find_modulus(message, signal, data)
    if modulus is None:
        return False
    draft.set("counter", signal, why)
    if not data:
        alike = (one.keys for one in known if one.keys.get("counter") == signal)
        modulus = next((keys["modulus"] for keys in alike if "modulus" in keys), 0)
    if modulus:
        draft.set("modulus", modulus, "as it came" if data else "as in the messages that came; try it")
    return True


def _checksum(
    draft: Draft, message: ForeignMessage, signal: str, data: Sequence[bytes], known: Iterable[Draft]
) -> bool:
    found = find_checksum(message, signal, data)
    if found is not None:
        draft.set("checksum", found, f"found by trying: it fits {len(data)} frames")
        return True
    alike = (one.keys["checksum"] for one in known if "checksum" in one.keys)
    same = next((one for one in alike if one["signal"] == signal and "data_id" not in one), None)
    if data or same is None:
        return False
    draft.set("checksum", dict(same), "as the messages that came have it; try it")
    return True


def find_modulus(message: ForeignMessage, signal: str, frames: Sequence[bytes]) -> int | None:
    """Return where the counter ``signal`` begins again, 0 where its bits or the frames end it.

    None: it does not count frames. It stands still from one to the next, as one that counts cycles of
    several frames, or each page of a multiplexed message by itself; or it is a time.
    """
    place = message.signals[signal]
    raw = compile_raw(message, place)
    counts = [raw(data[: message.length]) for data in frames if len(data) >= message.length]
    if len(counts) < MIN_COUNTER_FRAMES:
        return 0
    end = max(counts) + 1
    steps = [(other - one) % end for one, other in itertools.pairwise(counts)]
    if steps.count(0) > MOST_REPEATS * len(counts) or 2 * steps.count(1) < len(steps):
        return None
    return end if end < 1 << place.length and len(counts) >= MIN_TURNS * end else 0


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
    for own in ("left out", "zero"):
        more = {"own": own} if own == "zero" else {}
        for start in range(MOST_START):
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
