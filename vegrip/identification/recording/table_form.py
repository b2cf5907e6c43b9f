"""The form of a table from elsewhere, found from its beginning.

A spreadsheet's export has semicolons or tabs between the fields, decimal commas, lines of its own before the
header, UTF-16 or a mark of UTF-8, as its language and its maker want it. What the column map says stands; the
rest is what makes most numbers of the most lines.
"""

import contextlib
import csv
import gzip
import io
import re
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from vegrip.errors import RecordingError
from vegrip.identification.recording.table import Layout, split_line
from vegrip.whole_file import reading

SEEN_BYTES: Final = 2**17  # [bytes] that are looked at
SEEN_LINES: Final = 400
DELIMITERS: Final = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
ENCODINGS: Final = {"utf-8-sig": "UTF-8", "utf-16": "UTF-16", "utf-16-le": "UTF-16", "utf-16-be": "UTF-16"}
EIGHT_BIT: Final = "cp1252"  # what western spreadsheets write that do not write UTF-8
MARKS: Final = {b"\xef\xbb\xbf": "utf-8-sig", b"\xff\xfe": "utf-16", b"\xfe\xff": "utf-16"}
AHEAD: Final = 5  # lines that must go on as numbers where the table begins
NUMBER: Final = re.compile(
    r"[-+]?(?:\d+([.,]?)\d*|([.,])\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf)", re.IGNORECASE
)


def find_layout(
    path: Path, delimiter: str = "", decimal: str = "", skip: int = -1, section: str = ""
) -> tuple[Layout, str]:
    """Return how the table ``path`` is written, and in words what of that is not usual.

    Args:
        path: plain or ``.gz``.
        delimiter: between fields; empty: found.
        decimal: decimal sign; empty: found.
        skip: lines before the header; below 0: found.
        section: the line above each table, in a file of several; empty: it is one.

    """
    head = _head(path)
    encoding, mark = _encoding(head)
    text = head.decode(encoding, errors="replace")
    lines = io.StringIO(text, newline="").readlines()[:SEEN_LINES]
    if len(head) == SEEN_BYTES and len(lines) < SEEN_LINES:
        del lines[-1:]  # it is cut
    begin = max(skip, 0)
    forms = [_Form.of(lines[begin:], each, decimal) for each in ([delimiter] if delimiter else DELIMITERS)]
    best = max(forms, key=lambda form: form.numbers)
    if best.first is None:  # no numbers: what stands most in the first line that could be a header
        top = next((line for line in lines[begin:] if line.strip()), "")
        best = max(forms, key=lambda form: top.count(form.delimiter))
    before = begin if skip >= 0 or section else best.header
    found = Layout(best.delimiter, best.decimal, before, encoding=encoding, section=section)
    said = [
        (f"fields separated by {DELIMITERS.get(found.delimiter)}", not delimiter and found.delimiter != ","),
        ("decimal commas", not decimal and found.decimal == ","),
        (f"{found.skip} line{'s' * (found.skip > 1)} before the header", skip < 0 < found.skip),
        (f"text in {ENCODINGS.get(encoding, 'Windows-1252')}{mark}", bool(mark) or encoding != "utf-8-sig"),
    ]
    return found, ", ".join(words for words, is_so in said if is_so)


def _head(path: Path) -> bytes:
    damage = EOFError, zlib.error, gzip.BadGzipFile  # told when the table is read, with the line
    opened = gzip.open if path.suffix == ".gz" else open
    with reading(path, RecordingError), contextlib.suppress(*damage), opened(path, "rb") as file:
        return file.read(SEEN_BYTES)
    return b""


def _encoding(head: bytes) -> tuple[str, str]:
    for mark, encoding in MARKS.items():
        if head.startswith(mark):
            return encoding, " with a byte order mark"
    for start, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
        if len(head) >= 4 and not any(head[start:200:2]) and all(head[1 - start : 200 : 2]):
            return encoding, ""
    try:
        head.decode()
    except UnicodeDecodeError as error:
        is_cut = len(head) == SEEN_BYTES and error.end == len(head)
        return ("utf-8-sig" if is_cut or b"\0" in head else EIGHT_BIT), ""
    return "utf-8-sig", ""


@dataclass(frozen=True, slots=True)
class _Form:
    delimiter: str
    decimal: str
    numbers: float  # lines of numbers, each counted by its share of cells that are numbers
    first: int | None  # line of numbers
    header: int  # line

    @classmethod
    def of(cls, lines: Sequence[str], delimiter: str, decimal: str) -> "_Form":
        rows = [_split(line, delimiter) for line in lines]
        signs = [sign for row in rows for sign in _signs(row) if sign]
        decimal = decimal or ("," if signs.count(",") > signs.count(".") else ".")
        other = "." if decimal == "," else ","
        shares = [_share(row, other) for row in rows]
        is_data = [share > 0.5 for share in shares]
        first = next(
            (
                i
                for i in range(len(rows))
                if is_data[i] and 2 * sum(ahead := is_data[i : i + AHEAD]) > len(ahead)
            ),
            None,
        )
        header = 0 if first is None else _header(lines, rows, first)
        return cls(delimiter, decimal, sum(shares[first or 0 :]), first, header)


def _split(line: str, delimiter: str) -> list[str]:
    try:
        return [cell.strip() for cell in split_line(line, delimiter)]
    except csv.Error:
        return []


def _signs(row: Sequence[str]) -> Iterator[str]:
    for cell in row if len(row) > 1 else ():
        if found := NUMBER.fullmatch(cell):
            yield found[1] or found[2] or ""


def _share(row: Sequence[str], other: str) -> float:
    filled = [cell for cell in row if cell]
    if len(row) < 2 or not filled:
        return 0.0
    return sum(1 for cell in filled if NUMBER.fullmatch(cell) and other not in cell) / len(filled)


def _header(lines: Sequence[str], rows: Sequence[list[str]], first: int) -> int:
    above = [i for i in range(first) if lines[i].strip()]
    if not above:
        return first
    header = above[-1]
    for i in reversed(above[:-1]):
        is_comment = lines[i].startswith("#")
        if i != header - 1 or is_comment or len(rows[i]) != len(rows[first]) or not all(rows[i]):
            break
        header = i
    return header
