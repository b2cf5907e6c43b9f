"""The frames of a CAN log (.asc, .blf, .trc, .mf4, candump's), of one channel, on a time that grows.

What python-can raises about, or reads wrongly, is looked at before: sizes of objects in a .blf, relative
times in an .asc. A line that cannot be read is left out and counted.
"""

import contextlib
import importlib
import os
import re
import struct
import zlib
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Final, TextIO

import can
import numpy as np
from can.io import blf, mf4
from can.io.blf import BLFParseError

from vegrip.clock import NS
from vegrip.errors import RecordingError, UsageError
from vegrip.identification.recording.mended_times import mended
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.text_encoding import HEAD_BYTES, encoding_of
from vegrip.transport.codec import Frame
from vegrip.transport.codec.frame import EXTENDED
from vegrip.types import Floats

CANDUMP: Final = re.compile(
    r"\s*\((?P<second>-?\d+)(?:\.(?P<rest>\d{1,9}))?\)\s+(?P<channel>\S+)\s+(?P<id>[0-9A-Fa-f]{3,8})"
    r"#(?:#(?P<flags>[0-9A-Fa-f]))?(?P<data>(?:[0-9A-Fa-f]{2})*|[Rr][0-9A-Fa-f]?)(?:\s+[RT])?\s*"
)
CANDUMP_SHOWN: Final = re.compile(r" *(\(.*\) +)?\w+  +[0-9A-F]{3,8} +\[\d+\]")
"""A frame as candump prints it: without the flags of FD, and by default without a time."""
ERROR_FRAME: Final = 0x20000000
ASC_TIME: Final = re.compile(r"(\s*)(-?\d+\.\d+)(\s.*)", re.DOTALL)
ASC_RELATIVE: Final = re.compile(r"\s*base\s+\w+\s+timestamps\s+relative", re.IGNORECASE)

GZIP: Final = b"\x1f\x8b"
TOO_LARGE: Final = (MemoryError, OverflowError)
MAX_CONTAINER_BYTES: Final = 2**26  # [bytes] of an unpacked container; loggers use 128 KiB
BROKEN: Final = (
    OSError,
    ValueError,
    LookupError,
    TypeError,
    struct.error,
    zlib.error,
    can.CanError,
    BLFParseError,
    *TOO_LARGE,
)
"""What python-can's readers raise when a file is not what its name says."""


@dataclass(slots=True)
class Log:
    """The data frames of a log in the order in which they came, and what was left out."""

    frames: list[Frame] = field(default_factory=list)
    report: LoadReport = field(default_factory=LoadReport)
    channels: list[str] = field(default_factory=list)  # of each frame


def read_log(
    path: Path,
    *,
    extended: bool = False,
    channel: str = "",
    wanted: Collection[int] | None = None,
    remedy: str = "--channel {0}",
) -> Log:
    """Return the data frames of a log, stamped with its time.

    Args:
        path: ``.asc``, ``.blf``, ``.trc``, ``.mf4``, or what candump writes.
        extended: also those with 29-bit identifiers, with ``EXTENDED`` set in them.
        channel: the one to read, where the log has several: a name of candump's, or ``can0`` for the first.
        wanted: identifiers that may not come on two channels; None is all.
        remedy: how the user says which channel is meant.

    Raises:
        RecordingError: no such file, no log, or an identifier on two channels.

    """
    log = Log()
    try:
        for message, name in READERS.get(path.suffix.lower(), candump_frames)(path, log.report):
            log.report.rows_read += 1
            if extended or not message.arbitration_id & EXTENDED:
                log.frames.append(message)
                log.channels.append(name)
        bad = next((f for f in log.report.findings if f.kind.lost and f.count), None)
        if bad is not None and not log.report.rows_read:
            raise ValueError(f"line {bad.lines[0] if bad.lines else 1} is no frame")
    except FileNotFoundError:
        raise RecordingError(f"{path}: there is no such file") from None
    except BROKEN as error:
        raise RecordingError(
            f"{path}: is not a CAN log that can be read ({str(error) or type(error).__name__})"
        ) from None
    log.report.rows_kept = log.report.rows_read
    log.report.rows_read += sum(f.count for f in log.report.findings if f.kind.lost)
    _pick(path, log, channel, wanted, remedy)
    stamps = np.array([frame.stamp for frame in log.frames], dtype=np.int64)
    t = (stamps - (stamps[0] if len(stamps) else 0)) / NS
    names = np.array([frame.arbitration_id for frame in log.frames], dtype=np.int64)
    better = _on_one_clock(t, stamps, names, log.report)
    if better is not t:
        begin = int(stamps[0])
        log.frames = [
            frame._replace(stamp=begin + round(each * NS))
            for frame, each in zip(log.frames, better.tolist(), strict=True)
        ]
    return log


def _on_one_clock(t: Floats, stamps: Any, names: Any, report: LoadReport) -> Floats:
    absolute = stamps / NS if len(stamps) and np.abs(stamps).max() < 1e6 * NS else t  # differences are small
    better = mended(absolute, report, is_in_order=True, senders=names)
    return t if better is absolute else better - better[0]


def _pick(path: Path, log: Log, channel: str, wanted: Collection[int] | None, remedy: str) -> None:
    """Leave the frames of ``channel``; without one, raise where an identifier comes on several."""
    there = sorted(set(log.channels))
    if len(there) < 2:
        return
    if channel:
        if channel not in there:
            raise RecordingError(f"{path}: has no channel {channel!r}; it has {', '.join(there)}")
        log.frames = [f for f, name in zip(log.frames, log.channels, strict=True) if name == channel]
        log.channels = [channel] * len(log.frames)
        return
    seen: dict[int, str] = {}
    for frame, name in zip(log.frames, log.channels, strict=True):
        other = seen.setdefault(frame.arbitration_id, name)
        if other != name and (wanted is None or frame.arbitration_id in wanted):
            number = frame.arbitration_id & ~EXTENDED
            raise RecordingError(
                f"{path}: the identifier 0x{number:X} comes on {other} and on {name}; "
                f"say which is meant with {remedy.format(other)}"
            )


ChannelFrame = tuple[Frame, str]
"""A frame and its channel."""


@contextlib.contextmanager
def _text(path: Path) -> Iterator[TextIO]:
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    if head.startswith(GZIP):
        raise ValueError(f"it is compressed; unpack it first: gunzip {path.name}")
    encoding = encoding_of(head, is_cut=len(head) == HEAD_BYTES)
    if b"\0" in head and not encoding.startswith("utf-16"):
        raise ValueError("it is no text")
    with path.open(encoding=encoding, errors="replace") as text:
        yield text


def candump_frames(path: Path, report: LoadReport) -> Iterator[ChannelFrame]:
    with _text(path) as text:
        for number, line in enumerate(text, start=1):
            if number == 1 and CANDUMP_SHOWN.match(line[:200]):
                raise RecordingError(
                    f"{path}: is what candump shows on a screen; have it write a log: candump -L can0 > FILE"
                )
            match = CANDUMP.fullmatch(line)
            if match is None:
                if line.strip():
                    report.add(Kind.DECODE, "no frame of candump", [number])
                continue
            identifier, data = int(match["id"], 16), match["data"]
            if data[:1] in ("R", "r") or identifier & ERROR_FRAME:
                continue
            second, rest = int(match["second"]), int((match["rest"] or "0").ljust(9, "0"))
            stamp = second * NS + (-rest if match["second"].startswith("-") else rest)
            identifier |= EXTENDED if len(match["id"]) > 3 else 0
            yield Frame(identifier, bytes.fromhex(data), match["flags"] is not None, stamp), match["channel"]


class _Lines:
    """The lines of an open log for python-can, which reads on after one that it could not."""

    def __init__(self, file: TextIO, change: Callable[[str], str] = str) -> None:
        self.number = 0
        self._file, self._change, self._first = file, change, ""

    def __iter__(self) -> "_Lines":
        return self

    def __next__(self) -> str:
        if self._first:
            first, self._first = self._first, ""
            return first
        self.number += 1
        return self._change(next(self._file))

    def resume(self, first: str) -> None:
        """Give ``first`` before the next line: what python-can takes for the end of the header."""
        self._first = first

    def close(self) -> None:
        """python-can closes what it has read."""


def _asc(path: Path, report: LoadReport) -> Iterator[ChannelFrame]:
    with _text(path) as text:
        lines = _Lines(text, _AscTimes())
        reader: Any = can.ASCReader(lines)  # type: ignore[arg-type]
        yield from _resumed(reader, lines, "no internal events logged\n", report)


class _AscTimes:
    """Makes times of an .asc absolute that are relative to the line before, or negative."""

    def __init__(self) -> None:
        self._is_relative = False
        self._sum = 0.0
        self._shift: float | None = None

    def __call__(self, line: str) -> str:
        self._is_relative = self._is_relative or ASC_RELATIVE.match(line) is not None
        if (match := ASC_TIME.fullmatch(line)) is None:
            return line
        t = float(match[2])
        if self._is_relative:
            self._sum += t
            return f"{match[1]}{self._sum:.9f}{match[3]}"
        if self._shift is None:
            self._shift = max(-t, 0.0)
        return f"{match[1]}{t + self._shift:.9f}{match[3]}" if self._shift else line


class _TrcReader(can.TRCReader):
    def _parse_line(self, line: str) -> can.Message | None:
        return self._parse_cols(tuple(line.split(maxsplit=self._num_columns)))  # raises, to be counted


def _trc(path: Path, report: LoadReport) -> Iterator[ChannelFrame]:
    with _text(path) as text:
        lines = _Lines(text)
        yield from _resumed(_TrcReader(lines), lines, "", report)  # type: ignore[arg-type]


def _resumed(reader: Any, lines: _Lines, first: str, report: LoadReport) -> Iterator[ChannelFrame]:
    while True:
        try:
            for message in reader:
                yield from _data_frame(message, report, lines.number)
        except BROKEN:
            report.add(Kind.DECODE, "no frame", [lines.number])
            lines.resume(first)
        else:
            return


def _data_frame(message: can.Message, report: LoadReport, place: int) -> Iterator[ChannelFrame]:
    """Yield the frame of a message, or nothing."""
    if message.is_error_frame or message.is_remote_frame:
        return
    if len(message.data) < (message.dlc if message.is_fd else min(message.dlc, 8)):
        report.add(Kind.DECODE, "cut within its data", [place])
        return
    identifier = message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
    channel = message.channel
    name = str(channel) if isinstance(channel, str) else f"can{channel if channel is not None else 0}"
    yield Frame(identifier, bytes(message.data), message.is_fd, round(message.timestamp * NS)), name


class _BlfReader(can.BLFReader):
    """That of python-can, which goes round for ever at an object of size 0."""

    def _parse_container(self, data: bytes) -> Iterator[can.Message]:
        broken = _broken_object(self._tail + data if self._tail else data)
        if broken:
            raise BLFParseError(broken)
        yield from super()._parse_container(data)


def _broken_object(data: bytes) -> str:
    """Return what is wrong with the first object in ``data`` that cannot be, "" where all can."""
    head, at = blf.OBJ_HEADER_BASE_STRUCT, 0
    while (at := data.find(b"LOBJ", at, at + 8)) >= 0 and at + head.size <= len(data):
        _, size, version, whole, kind = head.unpack_from(data, at)
        if whole < head.size or size > whole:
            return f"an object of type {kind} in it has {whole} bytes, less than its own header"
        if version not in (1, 2):
            return f"an object of type {kind} in it has a header of the unknown version {version}"
        at += whole
    return ""


def _blf(path: Path, report: LoadReport) -> Iterator[ChannelFrame]:
    with path.open("rb") as file:
        said, there = _check_containers(path, file), os.fstat(file.fileno()).st_size
        file.seek(0)
        frames = 0
        try:
            for message in _BlfReader(file):
                for found in _data_frame(message, report, frames):
                    frames += 1
                    yield found
        except BROKEN:
            if there == said or not frames:
                raise
            is_broken = True
        else:
            is_broken = False
        if there < said or is_broken:
            is_closed = said > blf.FILE_HEADER_STRUCT.size + 72  # else the logger had no time to write it
            lost = round(frames * abs(said - there) / min(said, there)) if is_closed else 0
            of = f"the file has {there} of the {said} bytes that its header says"
            beyond = f"what stands beyond the {said} bytes that its header says cannot be read"
            report.add(Kind.CUT, of if there < said else beyond, count=max(lost, 1))


def _check_containers(path: Path, file: BinaryIO) -> int:
    """Refuse a container that unpacks to more than ``MAX_CONTAINER_BYTES``; return the size the file says."""
    first = file.read(blf.FILE_HEADER_STRUCT.size)
    whole = os.fstat(file.fileno()).st_size
    if not whole:
        raise ValueError("it is empty")
    if (
        whole < max(blf.FILE_HEADER_STRUCT.size, int.from_bytes(first[4:8], "little"))
        and first[:4] == b"LOGG"
    ):
        raise ValueError("it ends within its own header")
    said = int(blf.FILE_HEADER_STRUCT.unpack(first)[10])
    file.seek(4)
    file.seek(int.from_bytes(file.read(4), "little"))  # the length of the header stands behind the signature
    head = blf.OBJ_HEADER_BASE_STRUCT
    while len(data := file.read(head.size)) == head.size:
        _, _, _, size, kind = head.unpack(data)
        if kind != blf.LOG_CONTAINER or size > MAX_CONTAINER_BYTES:
            file.seek(max(size - head.size, 0) + size % 4, os.SEEK_CUR)
            continue
        content = file.read(max(size - head.size, 0))
        file.seek(size % 4, os.SEEK_CUR)
        if content[:2] != blf.ZLIB_DEFLATE.to_bytes(2, "little"):
            continue
        unpacking = zlib.decompressobj()
        try:
            unpacking.decompress(content[blf.LOG_CONTAINER_STRUCT.size :], MAX_CONTAINER_BYTES)
        except zlib.error:
            continue  # damaged: the reader says so
        if unpacking.unconsumed_tail:
            raise RecordingError(
                f"{path}: a container in it unpacks to more than {MAX_CONTAINER_BYTES} bytes"
            )
    return said


def _mf4(path: Path, report: LoadReport) -> Iterator[ChannelFrame]:
    with path.open("rb") as file:
        if not file.read(8).startswith((b"MDF", b"UnFinMF")):
            raise ValueError("it does not begin like MDF")
    try:
        from asammdf.blocks.mdf_v4 import MDF4  # noqa: PLC0415 (an extra: 15 packages)
    except ImportError:
        raise UsageError(
            f"{path}: is a measurement in MDF 4, and asammdf, which reads it, is missing: "
            "pip install 'vegrip[mdf]', or have the logger export .asc or .blf"
        ) from None
    MDF4.__del__ = _close_quietly
    if vars(mf4)["asammdf"] is None:  # the command line keeps it out of the start of its programs
        importlib.reload(mf4)
    try:
        for number, message in enumerate(mf4.MF4Reader(path)):
            yield from _data_frame(message, report, number)
    except Exception as error:  # noqa: BLE001 (asammdf raises whatever its parser meets in a damaged file)
        why = re.sub(r"'<mmap[^>]*>'", "it", str(error))
        raise ValueError(f"asammdf cannot read it: {why}") from None


def _close_quietly(measurement: Any) -> None:
    """Close what asammdf could not open whole; its own way raises outside of any call."""
    with contextlib.suppress(Exception):
        measurement.close()


Reader = Callable[[Path, LoadReport], Iterator[ChannelFrame]]
READERS: Final[dict[str, Reader]] = {".asc": _asc, ".blf": _blf, ".trc": _trc, ".mf4": _mf4, ".mdf": _mf4}
