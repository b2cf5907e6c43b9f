"""A table is read as it comes from a spreadsheet or a rig, and what was found of its form is said."""

import gzip
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import RecordingError
from vegrip.identification.recording import Kind, Recording
from vegrip.identification.recording.column_map import ColumnMap, TableMap, read_column_map, with_columns
from vegrip.identification.recording.import_csv import import_csv

T = np.arange(40) / 100.0
FORCE = np.round(np.sin(T) * 3.0, 4)
DEPTH = np.round(T * 1.25, 4)
NAMES = ("time_s", "load [N]", "depth_mm")
MAPS = (["t=time_s", "normal_force=load [N]", "displacement=depth_mm"], ["displacement=mm"])


def written(delimiter: str = ",", decimal: str = ".", end: str = "\n", quoted: bool = False) -> str:
    rows = [
        NAMES,
        *(
            [f"{value:.4f}".replace(".", decimal) for value in row]
            for row in zip(T, FORCE, DEPTH, strict=True)
        ),
    ]
    if quoted:
        rows = [[f'"{cell}"' for cell in row] for row in rows]
    return "".join(delimiter.join(row) + end for row in rows)


def text(content: str, encoding: str = "utf-8") -> bytes:
    return content.encode(encoding)


GERMAN = written(";", ",", "\r\n")
PREAMBLE = "# rig 7, 2024-05-03\n# gain, 2.5\n#\n"
PADDED = "Made by X;;\nDate;3.5.2024;\n\n"
METADATA = "".join(f"Channel {i};{i},5;V\n" for i in range(3)) + "Speed;5\n\n"

TABLES: dict[str, tuple[bytes, str]] = {
    "plain": (text(written()), ""),
    "lines end with CR": (text(written(end="\r")), ""),
    "semicolons": (text(written(";")), "fields separated by semicolons"),
    "tabs": (text(written("\t")), "fields separated by tabs"),
    "bars": (text(written("|")), "fields separated by bars"),
    "semicolons and decimal commas": (text(GERMAN), "fields separated by semicolons, decimal commas"),
    "tabs and decimal commas": (text(written("\t", ",")), "fields separated by tabs, decimal commas"),
    "quoted decimal commas": (text(written(",", ",", quoted=True)), "decimal commas"),
    "comments before the header": (text(PREAMBLE + written()), "3 lines before the header"),
    "a line for the spreadsheet": (text("sep=;\r\n" + GERMAN), "1 line before the header"),
    "padded lines before": (text(PADDED + GERMAN), "3 lines before the header"),
    "numbers before the header": (text(METADATA + GERMAN), "5 lines before the header"),
    "a header that is a comment": (text("# " + written()), ""),
    "the same behind comments": (text(PREAMBLE + "# " + written()), "3 lines before the header"),
    "UTF-8 with a mark": (text(GERMAN, "utf-8-sig"), "text in UTF-8 with a byte order mark"),
    "UTF-16": (text(GERMAN, "utf-16"), "text in UTF-16 with a byte order mark"),
    "UTF-16, big end first": (
        b"\xfe\xff" + text(GERMAN, "utf-16-be"),
        "text in UTF-16 with a byte order mark",
    ),
    "UTF-16 without a mark": (text(written("\t"), "utf-16-le"), "text in UTF-16"),
    "Windows-1252": (text("Gerät: Prüfstand\n" + GERMAN, "cp1252"), "text in Windows-1252"),
    "gzip": (
        gzip.compress(text(PREAMBLE + GERMAN, "utf-16"), mtime=0),
        "3 lines before the header, text in UTF-16",
    ),
}


def imported(content: bytes, folder: Path, table: TableMap | None = None) -> Recording:
    path = folder / ("press.csv.gz" if content[:2] == b"\x1f\x8b" else "press.csv")
    path.write_bytes(content)
    return import_csv(path, with_columns(ColumnMap(table=table or TableMap()), *MAPS), radius=8e-3)


def notes(recording: Recording) -> str:
    return "; ".join(one.what for one in recording.report.findings if one.kind is Kind.NOTE)


@pytest.mark.parametrize("name", TABLES)
def test_a_table_is_read_whatever_its_form_and_the_form_is_said(name: str, tmp_path: Path) -> None:
    content, said = TABLES[name]
    recording = imported(content, tmp_path)
    np.testing.assert_allclose(recording.t, T, atol=1e-12)
    np.testing.assert_allclose(recording.columns["normal_force"], FORCE, atol=1e-12)
    np.testing.assert_allclose(recording.columns["displacement"], 1e-3 * DEPTH, atol=1e-12)
    assert recording.report.rows_lost == 0
    assert said in notes(recording)
    assert ("found by itself" in notes(recording)) == bool(said)


def test_a_line_of_units_is_no_row_that_is_lost(tmp_path: Path) -> None:
    header, _, rest = GERMAN.partition("\r\n")
    recording = imported(text(f"{header}\r\ns;N;mm\r\n{rest}"), tmp_path)
    np.testing.assert_allclose(recording.columns["normal_force"], FORCE)
    assert recording.report.rows_lost == 0


@pytest.mark.parametrize(
    "table", [TableMap(delimiter=";"), TableMap(decimal=","), TableMap(skip=3), TableMap(";", ",", 3)]
)
def test_what_the_map_says_of_the_form_stands(table: TableMap, tmp_path: Path) -> None:
    recording = imported(text(PADDED + GERMAN), tmp_path, table)
    np.testing.assert_allclose(recording.columns["normal_force"], FORCE)
    with pytest.raises(RecordingError, match="has only the column"):
        imported(text(PADDED + GERMAN), tmp_path, replace(table, delimiter="\t"))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is empty"),
        (b"\xff\xfe", "is empty"),
        (b"time_s F\n0 1\n", "has only the column 'time_s F'; say what separates its fields"),
        (b"a;b\n", "there is no time column 'time_s'"),
        (text(GERMAN, "utf-16")[:-1], "is not a text file in UTF-16"),
        (b"\xff\xfe\x00\x00", "is not a text file"),
        (text(written().replace(" [N]", " [N]\0")), "is not a text file"),
        (gzip.compress(text(GERMAN), mtime=0)[:40], "damaged or cut"),
    ],
)
def test_what_is_no_table_is_refused_in_a_sentence(content: bytes, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=sentence) as refused:
        imported(content, tmp_path)
    assert "\n" not in str(refused.value)


OWN = "t;normal_force;depth_mm;episode;temperature\n" + "".join(
    f"{i};{i}.5;1;{i // 5};20\n" for i in range(10)
)


@pytest.mark.parametrize("stamp", ["2026-03-01T10:00:00.005", "2026-03-01 10:00:00+01:00"])
def test_a_date_as_the_time_is_refused_with_the_remedy(stamp: str, tmp_path: Path) -> None:
    rows = "".join(f"{stamp},{force},{depth}\n" for force, depth in zip(FORCE, DEPTH, strict=True))
    (tmp_path / "t.csv").write_text(",".join(NAMES) + "\n" + rows)
    chart = with_columns(ColumnMap(), *MAPS)
    with pytest.raises(RecordingError, match=r"t\.csv:2: the time 'time_s' is a date.* seconds"):
        import_csv(tmp_path / "t.csv", chart)


def test_columns_with_our_names_are_taken_beside_those_that_are_mapped(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(OWN)
    chart = with_columns(ColumnMap(), ["displacement=depth_mm"], ["displacement=mm", "normal_force=mN"])
    recording = import_csv(tmp_path / "a.csv", chart)
    assert list(recording.columns) == ["displacement", "normal_force", "temperature"]
    assert recording.columns["normal_force"][3] == pytest.approx(3.5e-3)
    assert list(np.unique(recording.episode)) == [0, 1]
    assert "taken by their names: temperature" in notes(recording)


def test_a_column_that_is_mapped_to_something_else_is_not_taken_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(OWN)
    (tmp_path / "map.toml").write_text("[channels.tangential_force_x]\ncolumn = 'normal_force'\n")
    recording = import_csv(tmp_path / "a.csv", read_column_map(tmp_path / "map.toml"))
    assert list(recording.columns) == ["tangential_force_x", "temperature"]


def test_the_command_says_what_it_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.csv").write_bytes(text(GERMAN, "utf-16"))
    maps = [part for one in MAPS[0] for part in ("--map", one)] + ["--unit", MAPS[1][0]]
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "r"), *maps, "--json"]) == 0
    (told,) = json.loads(capsys.readouterr().out)["recordings"]
    assert "fields separated by semicolons, decimal commas, text in UTF-16" in str(told["report"]["findings"])
