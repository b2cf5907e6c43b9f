"""Tables of numbers in text files, plain or gzipped, read with the line number of every row.

Rows that cannot be used are named in the report and left out; a file that cannot be used at all raises.
Rows are converted in blocks of columns: an hour at 500 Hz needs no more memory than its numbers. Five
megabytes of gzip can hold gigabytes of text, so a larger table than ``MOST_CELLS`` is refused when it is met.
"""

import contextlib
import csv
import gzip
import re
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from datetime import datetime, time
from pathlib import Path
from typing import Final, TextIO

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import RecordingError, suggestion
from vegrip.identification.recording.cell_numbers import (
    NONE,
    is_doubtful,
    plain_number,
    thousands_read,
)
from vegrip.identification.recording.report import Kind, LoadReport
from vegrip.types import Floats
from vegrip.whole_file import reading

BLOCK_ROWS: Final = 20_000
"""Rows converted at once, fewer when they are wide."""

BLOCK_CELLS: Final = 1_000_000
"""Cells split at once, some 60 MB."""

MOST_CELLS: Final = 64_000_000
"""Cells of the wanted columns, and lines: three hours of ten channels at 500 Hz, half a gigabyte."""

MOST_CELLS_ALL: Final = 4 * MOST_CELLS
"""Cells of all columns, also of those that are not wanted."""

LONGEST_LINE: Final = 1_000_000
"""Characters of a line."""

MOST_LOST: Final = 1_000_000
"""Rows that are of no use to a recording; two megabytes of gzip can hold 200 million of one time stamp."""

SECTION_COLUMN: Final = "section"
"""The name of the column with the number of the table."""

Cells = list[str]
Progress = Callable[[int], None]


@dataclass(frozen=True, slots=True)
class Layout:
    """The form of a table."""

    delimiter: str = ","
    decimal: str = "."
    skip: int = 0  # lines before the header
    sealed: bool = False  # a last line without its line end is cut, not only unusual
    encoding: str = "utf-8-sig"
    section: str = ""  # the line above each table, in a file of several
    thousands: str = ""  # what stands between thousands; empty: what can be nothing else, "none": nothing
    units: tuple[str, ...] = ()  # what stands below each column's name, as ``(mm)``


@dataclass(frozen=True, slots=True)
class Table:
    """The wanted columns of a file, and the line each row came from."""

    numbers: dict[str, Floats]
    words: dict[str, list[str]]
    lines: NDArray[np.int64]
    lost_times: Floats = field(default_factory=lambda: np.zeros(0))
    """The time (the first of the numbers) of each row that was left out, NaN where it could not be read."""
    lost_lines: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """The line of each row that was left out."""


def read_header(path: Path, layout: Layout) -> list[str]:
    with _opened(path, layout) as file:
        return _header(path, _texts(path, file, layout), layout)


def read_table(
    path: Path,
    numbers: Sequence[str],
    words: Sequence[str],
    layout: Layout,
    report: LoadReport,
    progress: Progress = lambda _: None,
    *,
    as_written: bool = False,
) -> Table:
    """Read the columns ``numbers`` (as float64; an empty cell is NaN) and ``words`` (as text).

    ``progress`` is called with the number of rows so far, block by block. The first of ``numbers`` is the
    time: rows in which it is not later than in the row before are of no use. ``as_written``: no mark in a
    whole number is looked at twice.

    Raises:
        RecordingError: no such file, not text, damaged, empty, too many rows of no use, or a wanted column is
            missing.

    """
    blocks: list[Table] = []
    of_use, is_marked, mark = 0, False, re.compile(rf"\{layout.decimal}\d{{3}}(?!\d)")
    has_both, other = False, ({".", ","} - {layout.decimal}).pop()
    with _opened(path, layout) as file:
        texts = _texts(path, file, layout)
        header = _header(path, texts, layout)
        wanted = {name: _position(path, header, name) for name in (*numbers, *words)}
        cells = 0
        for block in _blocks(texts, layout.delimiter):
            report.rows_read += len(block)
            is_marked = is_marked or any(mark.search(text) for _, text in block)
            has_both = has_both or (other != layout.delimiter and any(other in text for _, text in block))
            cells += sum(_width(text, layout.delimiter) for _, text in block)
            if report.rows_read * len(wanted) > MOST_CELLS or cells > MOST_CELLS_ALL:
                raise _too_large(path, f"more than {MOST_CELLS} numbers")
            table = _plain_block(block, numbers, words, wanted, len(header), layout)
            if table is None:
                whole = _whole(_rows(path, block, layout), len(header), report)
                _refuse_dates(path, whole, numbers, wanted)
                table = _converted(whole, numbers, words, wanted, layout, report)
            blocks.append(table)
            of_use += (
                int(np.count_nonzero(np.diff(table.numbers[numbers[0]]) > 0)) + 1 if numbers else len(block)
            )
            if report.rows_read - of_use > MOST_LOST:
                raise RecordingError(
                    f"{path}:{block[-1][0]}: more than {MOST_LOST} rows so far are of no use: "
                    f"{numbers[0]!r}, the time, stands still or runs backwards, or they cannot be read; "
                    "give the column that is the time, or cut the file"
                )
            progress(report.rows_read)
    if not report.rows_read:
        raise RecordingError(f"{path}: holds a header and no rows")
    table = _joined(blocks, numbers, words)
    is_asked = is_marked and not layout.thousands and not as_written
    doubtful = [name for name in numbers if is_asked and is_doubtful(table.numbers[name])]
    if doubtful:
        again = read_table(path, numbers, [*words, *doubtful], layout, LoadReport(), as_written=True)
        for name in doubtful:
            is_whole = _decide_thousands(table, name, again.words[name], layout, report)
            if is_whole and has_both:
                report.add(
                    Kind.AMBIGUOUS,
                    f"{layout.decimal!r} stands between thousands in {name!r}, and {other!r} is in other "
                    f"numbers: --decimal {other} reads that as decimal sign, --thousands {NONE} none as mark",
                )
    return table


def _decide_thousands(table: Table, name: str, cells: list[str], layout: Layout, report: LoadReport) -> bool:
    """Read the column ``name`` with marks between thousands, and return True, where that is smoother."""
    mark = layout.decimal
    whole, is_sure = thousands_read(cells, table.numbers[name], mark)
    if not is_sure:
        report.add(
            Kind.AMBIGUOUS,
            f"the column {name!r} has whole numbers and numbers like "
            f"{next(cell for cell in cells if mark in cell)!r}: --thousands {mark} reads it as thousands, "
            f"--thousands {NONE} as decimals",
        )
    if whole is not None:
        table.numbers[name][:] = whole
        report.add(Kind.NOTE, f"found by itself: in {name!r} a {mark!r} stands between thousands")
    return whole is not None


def _opened(path: Path, layout: Layout) -> TextIO:
    with reading(path, RecordingError):
        if path.suffix == ".gz":
            return gzip.open(path, "rt", encoding=layout.encoding, newline="")
        return path.open(encoding=layout.encoding, newline="")


def _texts(path: Path, file: TextIO, layout: Layout) -> Iterator[tuple[int, str]]:
    """Yield number and text of every line of the table; damage to the file raises."""
    texts = _filled_lines(path, file, layout)
    return _tables_below(path, texts, layout) if layout.section else texts


def _tables_below(path: Path, texts: Iterator[tuple[int, str]], layout: Layout) -> Iterator[tuple[int, str]]:
    """Yield the tables below the lines ``section`` as one, with the number of each as its first column.

    A table ends with a line that is not divided into cells.
    """
    number, names, above, where = 0, "", "", "elsewhere"
    for line, text in texts:
        if text.strip() == layout.section:
            number, where = number + 1, "above"
            continue
        first, divides, _ = text.partition(layout.delimiter)
        if where == "above" and divides and not _float(first)[1]:
            where = "within"
            if names and above.strip() != names:
                raise RecordingError(f"{path}:{line - 1}: the columns are not those of the first table")
            if not names:
                names = above.strip()
                yield line - 1, f"{SECTION_COLUMN}{layout.delimiter}{above}"
        if where == "within" and divides:
            yield line, f"{number}{layout.delimiter}{text}"
        elif where == "within":
            where = "elsewhere"
        above = text
    if not names:
        raise RecordingError(f"{path}: there is no table below a line {layout.section!r}")


def _filled_lines(path: Path, file: TextIO, layout: Layout) -> Iterator[tuple[int, str]]:
    line = 0
    try:
        for line, text in enumerate(iter(lambda: file.readline(LONGEST_LINE + 1), ""), start=1):
            if len(text) > LONGEST_LINE or line > MOST_CELLS:
                limit = f"{LONGEST_LINE} characters" if line <= MOST_CELLS else f"{MOST_CELLS} lines"
                raise _too_large(f"{path}:{line}", f"more than {limit}")
            if "\0" in text:
                raise RecordingError(f"{path}:{line}: is not a text file; give a table of numbers (CSV)")
            is_table = line > layout.skip and not text.isspace()
            if is_table and not (layout.units and is_units_line(text, layout)):
                yield line, text
    except UnicodeDecodeError:
        name = layout.encoding.removesuffix("-sig").upper()
        at = _first_foreign(path, line + 1) if name == "UTF-8" else line + 1
        raise RecordingError(
            f"{path}:{at}: is not a text file in {name}; give a table of numbers (CSV)"
        ) from None
    except (EOFError, zlib.error, gzip.BadGzipFile) as error:
        raise RecordingError(
            f"{path}:{line + 1}: the compressed file is damaged or cut ({error}); copy it again, "
            f"or save what is left with `zcat {path.name} > {path.stem}`"
        ) from None
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read ({error.strerror or error})") from None


def is_units_line(text: str, layout: Layout) -> bool:
    return tuple(cell.strip() for cell in split_line(text, layout.delimiter)) == layout.units


def _too_large(where: Path | str, what: str) -> RecordingError:
    return RecordingError(f"{where}: holds {what}; cut it into several recordings")


def _width(text: str, delimiter: str) -> int:
    """Return how many cells ``text`` has at most: in quotes the delimiter is one of a cell."""
    return text.count(delimiter) + 1


def _blocks(texts: Iterator[tuple[int, str]], delimiter: str) -> Iterator[list[tuple[int, str]]]:
    """Yield the lines in blocks of ``BLOCK_ROWS``, or of fewer that have ``BLOCK_CELLS`` together."""
    block: list[tuple[int, str]] = []
    cells = 0
    for line in texts:
        block.append(line)
        cells += _width(line[1], delimiter)
        if len(block) >= BLOCK_ROWS or cells >= BLOCK_CELLS:
            yield block
            block, cells = [], 0
    if block:
        yield block


def _first_foreign(path: Path, otherwise: int) -> int:
    """Return the line that is not UTF-8: text is decoded in chunks, which begin some lines before it."""
    try:
        with gzip.open(path) if path.suffix == ".gz" else path.open("rb") as file:
            for line, text in enumerate(file, start=1):
                try:
                    text.decode("utf-8")
                except UnicodeDecodeError:
                    return line
    except (OSError, EOFError, zlib.error):
        pass
    return otherwise


def _rows(path: Path, block: list[tuple[int, str]], layout: Layout) -> list[tuple[int, Cells, bool]]:
    rows = []
    for line, text in block:
        try:
            cells = split_line(text, layout.delimiter)
        except csv.Error as error:
            raise RecordingError(f"{path}:{line}: cannot be split into fields ({error})") from None
        rows.append((line, cells, layout.sealed and text[-1] not in "\r\n"))
    return rows


def _plain_block(
    block: list[tuple[int, str]],
    numbers: Sequence[str],
    words: Sequence[str],
    at: dict[str, int],
    width: int,
    layout: Layout,
) -> Table | None:
    """Convert a block of plain numbers at once; None where anything in it needs a closer look."""
    lines, texts = zip(*block, strict=True)
    whole = "".join(texts)
    is_odd = layout.decimal != "." or len(layout.delimiter) != 1 or any(c in whole for c in '"_')
    is_odd = is_odd or layout.delimiter == " "
    is_odd = is_odd or layout.thousands not in ("", NONE)
    is_odd = is_odd or (layout.sealed and texts[-1][-1] not in "\r\n") or not numbers
    if is_odd or any(text.count(layout.delimiter) != width - 1 for text in texts):
        return None
    places = [at[name] for name in numbers]
    try:
        values = np.loadtxt(
            [text.rstrip("\r\n") for text in texts] if "\r" in whole else texts,
            delimiter=layout.delimiter,
            comments=None,
            usecols=places,
            ndmin=2,
        )
    except ValueError:  # an empty cell, a word
        return None
    if len(values) != len(lines) or np.isinf(values).any():
        return None
    found = {
        name: [text.rstrip("\r\n").split(layout.delimiter, at[name] + 1)[at[name]].strip() for text in texts]
        for name in words
    }
    return Table(dict(zip(numbers, values.T.copy(), strict=True)), found, np.array(lines, dtype=np.int64))


def split_line(text: str, delimiter: str) -> Cells:
    """Return the cells of a line; raise :class:`csv.Error` where quotes do not fit.

    Between fields that stand below each other there are as many spaces as it takes.
    """
    if delimiter == " " and '"' not in text:
        return text.split()
    if '"' in text and len(delimiter) == 1:
        return next(csv.reader([text], delimiter=delimiter))
    return text.rstrip("\r\n").split(delimiter)


def _header(path: Path, texts: Iterator[tuple[int, str]], layout: Layout) -> list[str]:
    top = next(texts, None)
    if top is None:
        raise RecordingError(f"{path}: is empty; the first line must name the columns")
    first = _rows(path, [top], layout)[0]
    header = [cell.strip() for cell in first[1]]
    header[0] = header[0].removeprefix("#").strip() or header[0]  # a header that is a comment
    if all(cell and not _float(cell)[1] for cell in header):
        raise RecordingError(
            f"{path}:{first[0]}: the table has no header; write the names of the columns above the numbers"
        )
    return header


def _position(path: Path, header: list[str], name: str) -> int:
    if name not in header:
        raise RecordingError(f"{path}: there is no column {name!r}; {suggestion(name, header)}")
    if header.count(name) > 1:
        raise RecordingError(f"{path}: the column {name!r} stands twice; rename one")
    return header.index(name)


def _whole(
    block: list[tuple[int, Cells, bool]], width: int, report: LoadReport
) -> list[tuple[int, Cells, bool]]:
    report_if(report, Kind.CUT, "", [line for line, _, cut in block if cut])
    uncut = [row for row in block if not row[2]]
    report_if(report, Kind.FIELDS, "", [line for line, cells, _ in uncut if len(cells) != width])
    return [row for row in uncut if len(row[1]) == width]


def _refuse_dates(
    path: Path, block: list[tuple[int, Cells, bool]], numbers: Sequence[str], at: dict[str, int]
) -> None:
    """Raise where the first of ``numbers``, the time, is a calendar's."""
    for line, cells, _ in block[:1] if numbers else ():
        cell = cells[at[numbers[0]]].strip()
        if not _float(cell)[1]:
            return
        for kind, parse in (("a date", datetime.fromisoformat), ("a time of day", time.fromisoformat)):
            with contextlib.suppress(ValueError):
                parse(cell.replace(",", "."))
                raise RecordingError(
                    f"{path}:{line}: the time {numbers[0]!r} is {kind}, {cell!r}; write it as a number, "
                    "such as the seconds since the first row"
                )


def _converted(
    block: list[tuple[int, Cells, bool]],
    numbers: Sequence[str],
    words: Sequence[str],
    at: dict[str, int],
    layout: Layout,
    report: LoadReport,
) -> Table:
    """Convert a block; rows with something that is not a number, or infinite, are left out."""
    lines = np.array([line for line, _, _ in block], dtype=np.int64)
    columns = {name: [cells[at[name]].strip() for _, cells, _ in block] for name in (*numbers, *words)}
    keep = np.ones(len(block), dtype=bool)
    values: dict[str, Floats] = {}
    for name in numbers:
        values[name], bad = _floats(columns[name], layout)
        infinite = np.isinf(values[name])
        report_if(report, Kind.NUMBER, name, lines[bad])
        report_if(report, Kind.INFINITE, name, lines[infinite])
        keep &= ~(bad | infinite)
    kept = np.flatnonzero(keep)
    texts = {name: [columns[name][i] for i in kept] for name in words}
    lost = values[numbers[0]][~keep] if numbers else np.zeros(0)
    return Table({name: values[name][keep] for name in numbers}, texts, lines[keep], lost, lines[~keep])


def _floats(cells: list[str], layout: Layout) -> tuple[Floats, NDArray[np.bool_]]:
    """Convert a column at once, or cell by cell when something in it is not a plain number."""
    is_plain = layout.decimal == "." and layout.thousands in ("", NONE)
    try:
        if is_plain and not any("_" in cell for cell in cells):
            return np.array(cells, dtype=np.float64), np.zeros(len(cells), dtype=bool)
    except ValueError:
        pass
    pairs = [_float(plain_number(cell, layout.decimal, layout.thousands)) for cell in cells]
    return np.array([value for value, _ in pairs]), np.array([bad for _, bad in pairs])


def _float(cell: str) -> tuple[float, bool]:
    if not cell:
        return np.nan, False
    try:
        return float(cell), "_" in cell  # Python reads 1_0 as ten; no instrument means that
    except ValueError:
        return np.nan, True


def _joined(blocks: list[Table], numbers: Sequence[str], words: Sequence[str]) -> Table:
    return Table(
        {name: np.concatenate([block.numbers[name] for block in blocks]) for name in numbers},
        {name: [word for block in blocks for word in block.words[name]] for name in words},
        np.concatenate([block.lines for block in blocks]),
        np.concatenate([block.lost_times for block in blocks]),
        np.concatenate([block.lost_lines for block in blocks]),
    )


def report_if(report: LoadReport, kind: Kind, what: str, lines: Sequence[int] | NDArray[np.int64]) -> None:
    if len(lines):
        report.add(kind, what, map(int, lines))
