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
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from vegrip.errors import RecordingError
from vegrip.identification.recording.cell_numbers import MINUS, SPACES
from vegrip.identification.recording.column_map import TableMap
from vegrip.identification.recording.table import Layout, split_line
from vegrip.identification.recording.units import is_unit
from vegrip.text_encoding import MARKS, encoding_of
from vegrip.whole_file import reading

SEEN_BYTES: Final = 2**17  # [bytes] that are looked at
SEEN_LINES: Final = 400
DELIMITERS: Final = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars"}
ENCODINGS: Final = {"utf-8-sig": "UTF-8", "utf-16": "UTF-16", "utf-16-le": "UTF-16", "utf-16-be": "UTF-16"}
OTHER_KINDS: Final = {
    b"TDSm": ("LabVIEW's TDMS", "export it as text (.csv), for instance with the package npTDMS"),
    b"PK\x03\x04": ("a workbook or archive", "save the sheet as .csv"),
    b"\xd0\xcf\x11\xe0": ("a workbook", "save the sheet as .csv"),
    b"MDF ": ("a measurement in MDF", "name it .mf4 to read its frames, or export its channels as .csv"),
    b"\x89HDF": ("HDF5", "name it .h5 to read its arrays by --map, or export them as .csv"),
    b"MATLAB": ("MATLAB's", "export the measurements with writetable"),
    b"PAR1": ("Parquet", "export it as .csv"),
    b"LOGG": ("a CAN log of Vector's", "name it .blf"),
    b"***BUSMASTER": ("BUSMASTER's log", "convert it to .asc with its format converters"),
    b"SQLite format 3": ("a database, as of a rosbag 2", "give the folder of the bag, or name it .db3"),
}
OF_FRAMES: Final = (
    re.compile(rb"(?i)\b(id|identifier|arbitration_id|can_?id|message_?id)\b"),
    re.compile(rb"(?i)\b(dlc|len|length|data|d0|d1|data ?0|data ?1|data bytes)\b"),
)
"""What the header of a table of CAN frames names, as python-can, SavvyCAN and Kvaser write it."""
AHEAD: Final = 5  # lines that must go on as numbers where the table begins
NUMBER: Final = re.compile(
    r"[-+]?(?:\d+([.,]?)\d*|([.,])\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf)", re.IGNORECASE
)
GROUPED: Final = re.compile(rf"[-+]?[1-9]\d{{0,2}}(?:[.,{SPACES}]\d{{3}})+(?:([.,])\d*)?")
"""A number with marks between thousands."""
UNIT_CELL: Final = re.compile(r"[\[(<{]\s*[^\]\[)(]{0,20}\s*[\])>}]|[-/]?")


def find_layout(path: Path, said: TableMap) -> tuple[Layout, str]:
    """Return how the table ``path``, plain or ``.gz``, is written, and in words what of that is not usual.

    What ``said`` leaves open is found.
    """
    head = _head(path)
    _refuse_other_kinds(path, head)
    encoding = encoding_of(head, is_cut=len(head) == SEEN_BYTES)
    mark = " with a byte order mark" if head.startswith(tuple(MARKS)) else ""
    text = head.decode(encoding, errors="replace")
    lines = io.StringIO(text, newline="").readlines()[:SEEN_LINES]
    if len(head) == SEEN_BYTES and len(lines) < SEEN_LINES:
        del lines[-1:]  # it is cut
    begin = max(said.skip, 0)
    forms = [
        _Form.of(lines[begin:], each, said.decimal)
        for each in ([said.delimiter] if said.delimiter else DELIMITERS)
    ]
    best = max(forms, key=lambda form: form.numbers)
    if best.first is None:  # no numbers: what stands most in the first line that could be a header
        top = next((line for line in lines[begin:] if line.strip()), "")
        best = max(forms, key=lambda form: top.count(form.delimiter))
    before = begin if said.skip >= 0 or said.section else best.header
    _refuse_commas(path, lines, best, said.delimiter)
    is_mark = said.thousands == best.decimal and not said.decimal
    sign = best.decimal if not is_mark else {".": ",", ",": "."}[best.decimal]
    found = Layout(
        best.delimiter, sign, before, encoding=encoding, section=said.section, thousands=said.thousands
    )
    found = replace(found, units=_units(lines, found, best.first))
    _check_sections(path, lines, found)
    unusual = [
        (
            f"fields separated by {DELIMITERS.get(found.delimiter)}",
            not said.delimiter and found.delimiter != ",",
        ),
        ("decimal commas", not said.decimal and found.decimal == ","),
        (f"{found.skip} line{'s' * (found.skip > 1)} before the header", said.skip < 0 < found.skip),
        (f"text in {ENCODINGS.get(encoding, 'Windows-1252')}{mark}", bool(mark) or encoding != "utf-8-sig"),
    ]
    return found, ", ".join(words for words, is_so in unusual if is_so)


def _refuse_other_kinds(path: Path, head: bytes) -> None:
    for mark, (kind, remedy) in OTHER_KINDS.items():
        if head.startswith(mark):
            raise RecordingError(f"{path}: is {kind}, which is not read; {remedy}")
    top = head.split(b"\n", 1)[0]
    if all(word.search(top) for word in OF_FRAMES):
        convert = f": python -m can.logconvert {path.name} {path.stem}.blf"
        how = convert if top.startswith(b"timestamp,") else ""
        raise RecordingError(
            f"{path}: is a table of CAN frames; make a log of it, .asc, .blf or candump's{how}"
        )


def _refuse_commas(path: Path, lines: Sequence[str], form: "_Form", delimiter: str) -> None:
    """Raise where rows of whole numbers between commas have more fields than the header: decimal commas."""
    if delimiter or form.delimiter != "," or form.first is None or form.first == form.header:
        return
    names, row = _split(lines[form.header], ","), _split(lines[form.first], ",")
    if len(names) > 1 and len(names) < len(row) and row[-1] and all(re.fullmatch(r"[-+\d]+", c) for c in row):
        raise RecordingError(
            f"{path}:{form.first + 1}: has {len(row)} fields below {len(names)} names: decimal commas "
            "between commas cannot be separated; save the table with semicolons or tabs between the fields"
        )


def _units(lines: Sequence[str], layout: Layout, first: int | None) -> tuple[str, ...]:
    """Return the cells of the line of units between the header and the numbers, none where there is none."""
    begin = layout.skip
    if layout.section:
        below = (i for i, line in enumerate(lines) if line.strip() == layout.section)
        first = _first_numbers(lines, next(below, len(lines)), layout)
        begin = (first or 0) - 2
    if first is None or first < begin + 2 or not lines[first - 1].strip():
        return ()
    cells = _split(lines[first - 1], layout.delimiter)
    if len(cells) != len(_split(lines[first], layout.delimiter)) or not any(cells):
        return ()
    in_brackets = all(UNIT_CELL.fullmatch(cell) for cell in cells)
    return tuple(cells) if in_brackets or all(is_unit(cell) for cell in cells if cell) else ()


def _first_numbers(lines: Sequence[str], begin: int, layout: Layout) -> int | None:
    rows = range(begin, len(lines))
    return next((i for i in rows if _share(_split(lines[i], layout.delimiter), "") > 0.5), None)


def _check_sections(path: Path, lines: Sequence[str], layout: Layout) -> None:
    """Raise where the tables below the lines ``section`` have different columns: they are not one table."""
    first = ""
    for begin in [i for i, line in enumerate(lines) if layout.section and line.strip() == layout.section]:
        at = _first_numbers(lines, begin, layout)
        if at is None:
            return
        header = at - 1 - bool(layout.units)
        names = ", ".join(_split(lines[header], layout.delimiter))
        first = first or names
        if names != first:
            raise RecordingError(
                f"{path}:{header + 1}: the columns are not those of the first table ({names} after {first}); "
                "give each kind of table as a file of its own"
            )


def _head(path: Path) -> bytes:
    damage = EOFError, zlib.error, gzip.BadGzipFile  # reported when the table is read, with the line
    opened = gzip.open if path.suffix == ".gz" else open
    with reading(path, RecordingError), contextlib.suppress(*damage), opened(path, "rb") as file:
        return file.read(SEEN_BYTES)
    return b""


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
        found = [(sign, is_sure) for row in rows for sign, is_sure in _signs(row) if sign]
        signs = [sign for sign, is_sure in found if is_sure] or [sign for sign, _ in found]
        decimal = decimal or ("," if signs.count(",") > signs.count(".") else ".")
        other = "." if decimal == "," else ","
        shares = [_share(row, other) for row in rows]
        is_data = [share > 0.5 for share in shares]
        first = next(
            (
                i
                for i in range(len(rows))
                if is_data[i]
                and 2 * sum(ahead := is_data[i : i + AHEAD]) > len(ahead)
                and not _is_named(rows[i], rows[i + 1 : i + 4 * AHEAD])
            ),
            None,
        )
        header = 0 if first is None else _header(lines, rows, first)
        return cls(delimiter, decimal, sum(shares[first or 0 :]), first, header)


def _is_named(row: Sequence[str], ahead: Sequence[Sequence[str]]) -> bool:
    """Whether ``row`` begins with a word, where most rows ``ahead`` begin with a number."""
    starts = [each[0] for each in ahead if each and each[0]]
    return not _is_number(row[0]) and 2 * sum(map(_is_number, starts)) > len(starts)


def _is_number(cell: str) -> bool:
    cell = cell.translate(MINUS)
    return bool(NUMBER.fullmatch(cell) or GROUPED.fullmatch(cell))


def _split(line: str, delimiter: str) -> list[str]:
    try:
        return [cell.strip() for cell in split_line(line, delimiter)]
    except csv.Error:
        return []


def _signs(row: Sequence[str]) -> Iterator[tuple[str, bool]]:
    """Yield what may be the decimal sign of each number, and whether it can be no mark between thousands."""
    for cell in row if len(row) > 1 else ():
        plain = cell.translate(MINUS)
        if grouped := GROUPED.fullmatch(plain):
            marks = set(re.findall("[.,]", plain)) - {grouped[1]}
            yield (
                grouped[1] or ("" if plain.count(".") + plain.count(",") != 1 else marks.pop()),
                bool(grouped[1]),
            )
        elif found := NUMBER.fullmatch(plain):
            yield found[1] or found[2] or "", True


def _share(row: Sequence[str], other: str) -> float:
    """Return the share of ``row`` that are numbers; ``other`` is not their decimal sign."""
    filled = [cell.translate(MINUS) for cell in row if cell]
    if len(row) < 2 or not filled:
        return 0.0
    numbers = [cell for cell in filled if _is_number(cell)]
    return sum(1 for c in numbers if not other or other not in c or GROUPED.fullmatch(c)) / len(filled)


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
