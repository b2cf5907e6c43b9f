"""CAN logs (Vector's, candump's) become recordings: frames through the same codec as on the bus."""

import contextlib
import math
import os
import re
import struct
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Final

import can
import numpy as np
from can.io import blf
from can.io.blf import BLFParseError

from vegrip.clock import NS
from vegrip.errors import RecordingError
from vegrip.identification.recording.channels import CHANNELS
from vegrip.identification.recording.checks import kept_rows
from vegrip.identification.recording.data import Fingertip, Recording
from vegrip.identification.recording.report import MISSING, Kind, LoadReport, MissingStates, told
from vegrip.messages import FingertipState
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.codec.frame import EXTENDED

CANDUMP_SHOWN: Final = re.compile(r" *(\(.*\) +)?\w+  +[0-9A-F]{3,8} +\[\d+\]")
"""A frame as candump prints it: without the flags of FD, and by default without a time."""

TOO_LARGE: Final = (MemoryError, OverflowError)
MAX_CONTAINER_BYTES: Final = 2**26  # [bytes] of an unpacked container; loggers use 128 KiB
BROKEN: Final = (
    OSError,
    ValueError,
    LookupError,
    struct.error,
    zlib.error,
    can.CanError,
    BLFParseError,
    *TOO_LARGE,
)
"""What python-can's readers raise when a file is not what its name says."""


def read_can_log(
    path: Path | str, fingers: Sequence[str], *, radius: float = math.nan
) -> dict[str, Recording]:
    """Return the recording of every finger that speaks in the log, by finger.

    Args:
        path: ``.asc``, ``.blf`` or what candump writes.
        fingers: names in the order of the bus.
        radius: of the fingertips [m]; a log does not hold it.

    Raises:
        RecordingError: not a log, or no frame of a fingertip in it.

    """
    path, refused = Path(path), Counter[str]()
    states: dict[str, list[FingertipState]] = defaultdict(list)
    frames = 0
    codecs = {fd: CanCodec(fingers, fd=fd) for fd in (False, True)}
    for frames, frame in enumerate(frames_of(path), start=1):  # noqa: B007
        message = codecs[frame.fd].decode(frame)
        if isinstance(message, FingertipState):
            states[message.finger].append(message)
    for codec in codecs.values():
        refused.update(codec.rejected)
    if not states:
        causes = ", ".join(f"{count} {cause}" for cause, count in sorted(refused.items()))
        remedy = f"refused: {causes}" if causes else "for a hand of another make see vegrip connect -h"
        raise RecordingError(f"{path}: none of its {frames} frames is a fingertip's state ({remedy})")
    start = min(found[0].stamp for found in states.values())
    return {f: _recording(path, f, states[f], start, refused, radius) for f in fingers if f in states}


def frames_of(path: Path, *, extended: bool = False) -> Iterator[Frame]:
    """Yield the data frames of a log (.asc, .blf, or .log of candump), stamped with its time.

    Those with 29-bit identifiers come only if ``extended``, with ``EXTENDED`` set in the identifier.

    Raises:
        RecordingError: no such file, or no log.

    """
    try:
        with _opened(path) as reader:
            for message in reader:
                if message.is_error_frame or message.is_remote_frame:
                    continue
                if extended or not message.is_extended_id:
                    identifier = message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
                    stamp = round(message.timestamp * NS)
                    yield Frame(identifier, bytes(message.data), message.is_fd, stamp)
    except FileNotFoundError:
        raise RecordingError(f"{path}: there is no such file") from None
    except BROKEN as error:
        raise RecordingError(f"{path}: is not a CAN log that can be read ({error})") from None


@contextmanager
def _opened(path: Path) -> Iterator[Iterable[can.Message]]:
    """Open the file here: python-can leaves it open when it finds the file broken."""
    if path.suffix.lower() == ".blf":
        with path.open("rb") as binary:
            _check_containers(path, binary)
            binary.seek(0)
            yield can.BLFReader(binary)
    else:
        reader = can.ASCReader if path.suffix.lower() == ".asc" else can.CanutilsLogReader
        with path.open() as text:
            if reader is can.CanutilsLogReader and CANDUMP_SHOWN.match(text.readline(200)):
                raise RecordingError(
                    f"{path}: is what candump shows on a screen; have it write a log: candump -L can0 > FILE"
                )
            text.seek(0)
            yield reader(text)


def _check_containers(path: Path, file: BinaryIO) -> None:
    """Refuse a container that unpacks to more than ``MAX_CONTAINER_BYTES``: python-can unpacks it whole."""
    blf.FILE_HEADER_STRUCT.unpack(file.read(blf.FILE_HEADER_STRUCT.size))
    file.seek(4)
    file.seek(int.from_bytes(file.read(4), "little"))  # the length of the header stands behind the signature
    head = blf.OBJ_HEADER_BASE_STRUCT
    while len(data := file.read(head.size)) == head.size:
        _, _, _, size, kind = head.unpack(data)
        if kind != blf.LOG_CONTAINER or size > MAX_CONTAINER_BYTES:
            file.seek(max(size - head.size, 0) + size % 4, os.SEEK_CUR)
            continue
        packed = file.read(max(size - head.size, 0))[blf.LOG_CONTAINER_STRUCT.size :]
        file.seek(size % 4, os.SEEK_CUR)
        unpacking = zlib.decompressobj()
        with contextlib.suppress(zlib.error):  # not compressed, or damaged: the reader says so
            unpacking.decompress(packed, MAX_CONTAINER_BYTES)
        if unpacking.unconsumed_tail:
            raise RecordingError(
                f"{path}: a container in it unpacks to more than {MAX_CONTAINER_BYTES} bytes"
            )


def _recording(
    path: Path,
    finger: str,
    states: list[FingertipState],
    start: int,
    refused: Counter[str],
    radius: float,
) -> Recording:
    report = LoadReport(rows_read=len(states))
    for cause, count in sorted(refused.items()):
        report.add(Kind.NOTE, f"{count} frames refused: {cause}")
    missing = MissingStates()
    for state in states:
        missing.take(state)
    source: dict[str, str | int | float | bool] = {"file": path.name}
    if missing.count:
        source[MISSING] = missing.count
        report.add(Kind.NOTE, told(missing.count))
    t = np.array([(state.stamp - start) / NS for state in states])
    columns = {name: np.array([getattr(s, name) for s in states]) for name in CHANNELS}
    lines, one_trial = np.arange(1, len(states) + 1), np.zeros(len(states), dtype=np.int64)
    kept = kept_rows(path, t, one_trial, columns, radius, lines, report)
    return Recording(f"{path.stem} {finger}", *kept, Fingertip(radius, finger), {}, source, start, report)
