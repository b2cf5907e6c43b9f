"""What attacks on readers have found, one case of each kind."""

import json
import shutil
from pathlib import Path

import cantools
import numpy as np
import pytest

import vegrip
from vegrip.cli import main
from vegrip.config import read_toml
from vegrip.errors import ConfigError, InputError, RecordingError
from vegrip.estimator.learning import restored
from vegrip.identification.calibration.session import CALIBRATION_FILE
from vegrip.identification.calibration.session import load as load_calibration
from vegrip.identification.recording import Recording, read_recording, write_recording
from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.mcap import from_json, write_mcap
from vegrip.identification.recording.rosbag import BagField
from vegrip.identification.recording.units import to_si
from vegrip.identification.recording.writer import RecordingWriter
from vegrip.model import paper_model
from vegrip.transport.codec.database import build_layouts
from vegrip.transport.codec.schema import read_proto
from vegrip.transport.key_files import make_keys, read_keys
from vegrip.transport.maps.database import read_dbc
from vegrip.web.check.session import CHECK_FILE
from vegrip.web.check.session import load as load_check

HUGE = "0x" + "f" * 5000


@pytest.fixture
def press(tmp_path: Path) -> Path:
    t = np.arange(9) / 100.0
    write_recording(Recording("press", t, np.zeros(9, int), {"normal_force": t}), tmp_path / "press")
    return tmp_path / "press"


@pytest.mark.parametrize(
    "text", [f"x = {HUGE}", f"x = [{{ y = [{HUGE}] }}]", "x = " + "9" * 5000, "x = " + "[" * 5000]
)
def test_a_number_or_nesting_without_bounds_is_no_toml(text: str, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(ConfigError, match=r"x\.toml: is not valid TOML"):
        read_toml(tmp_path / "x.toml")


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (".".join(["a"] * 20_000) + " = 1", "more than 16 parts"),
        (" . ".join(["'a.b'", '"c"'] * 10) + " = 1", "more than 16 parts"),
        ("[" + ".".join(["a"] * 17) + "]", "more than 16 parts"),
        ("x = { " + ".".join(["a"] * 17) + " = 1 }", "more than 16 parts"),
        ("x = 1\n" * 200_000, "more than 1000000 characters"),
    ],
    ids=["key", "quoted", "heading", "inline", "long"],
)
def test_toml_is_bounded_before_it_is_parsed(
    text: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vegrip.config.tomllib.loads", lambda _: pytest.fail("it was parsed"))
    (tmp_path / "x.toml").write_text(text)
    with pytest.raises(ConfigError, match=sentence):
        read_toml(tmp_path / "x.toml")


DEEP = "[" * 9000
READERS = {
    "learned parameters": lambda file: restored(paper_model(8e-3), file),
    "check": lambda file: load_check(file.parent, "press"),
    "calibration": lambda file: load_calibration(file.parent),
    "message of an MCAP file": lambda file: from_json(file.read_bytes(), ["t"]),
}


@pytest.mark.parametrize("reader", READERS)
def test_brackets_in_thousands_of_brackets_are_refused_in_a_sentence(reader: str, tmp_path: Path) -> None:
    for name in (CHECK_FILE, CALIBRATION_FILE):
        (tmp_path / name).write_text(DEEP)
    with pytest.raises(InputError):
        READERS[reader](tmp_path / CHECK_FILE)


def test_dots_in_strings_and_comments_are_no_deep_key(tmp_path: Path) -> None:
    dots = ".".join(["a"] * 40)
    text = f'# {dots}\nx = \'{dots}\'\ny = "\\"{dots}"\nz = """\'\n{dots}"""\n{".".join(["k"] * 16)} = 1.5\n'
    (tmp_path / "x.toml").write_text(text)
    assert read_toml(tmp_path / "x.toml")["x"] == dots


def test_toml_is_read_in_one_place() -> None:
    sources = Path(vegrip.__file__).parent.rglob("*.py")
    assert [path.name for path in sources if "tomllib.load" in path.read_text()] == ["config.py"]


@pytest.mark.parametrize(
    ("text", "limit"),
    [
        (' SG_ S : 0|8@1+ (1,0) [0|255] "" A\n' * 20_001, "20000 signals"),
        ('CM_ SG_ 1 S "x";\n' * 250_000, "4 MiB"),
        ("<Signal name='s' offset='0'/>" * 20_001, "20000 signals"),
    ],
)
def test_a_database_of_more_than_a_hand_is_refused_before_it_is_parsed(
    text: str, limit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cantools.database.load_file", lambda *_, **__: pytest.fail("it was parsed"))
    (tmp_path / "x.dbc").write_text(text)
    with pytest.raises(ConfigError, match=f"has more than {limit}; give the part of it that is the hand"):
        read_dbc(tmp_path / "x.dbc")


def test_dates_and_tables_in_the_source_of_a_recording_come_back(press: Path) -> None:
    text = (
        'date = 2024-02-03\nat = 2024-02-03T04:05:06Z\ntags = ["a", "b"]\nrig = { name = "x", volts = 3.5 }\n'
    )
    (press / "recording.toml").write_text(f"[source]\n{text}")
    once = read_recording(press)
    write_recording(once, press.with_name("again"))
    assert read_recording(press.with_name("again")).source == once.source


def test_an_age_without_end_is_refused_in_the_map_of_a_bag(tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text("[bag]\nlargest_age = inf\n")
    with pytest.raises(RecordingError, match="'largest_age' is inf"):
        read_column_map(tmp_path / "map.toml")


def test_a_session_that_is_no_text_is_refused_on_the_way_to_mcap(press: Path) -> None:
    pytest.importorskip("mcap", reason="the extra `bags` is not installed")
    with RecordingWriter(press.with_name("session")):
        pass
    shutil.copytree(press, press.with_name("session") / "thumb")
    press.with_name("session").joinpath("session.toml").write_bytes(b"\xff\xfe")
    with pytest.raises(RecordingError, match="is not a text file"):
        write_mcap(press.with_name("session"), press.with_name("x.mcap"))


@pytest.mark.parametrize("line", ["secret-key", 'secret-key = ""', 'public-key = "abc"', "public-key = ' '"])
def test_a_key_file_without_its_key_is_refused(line: str, tmp_path: Path) -> None:
    _, secret = make_keys(tmp_path, "x")
    kept = [text for text in secret.read_text().splitlines() if line.partition(" ")[0] not in text]
    secret.write_text("\n".join([*kept, line]))
    with pytest.raises(ConfigError, match="is no key file"):
        read_keys(secret)


@pytest.mark.parametrize("gone", ["MessageSetVersion", "MessageName", "E2EProfile", "MessagePart"])
def test_a_database_without_an_attribute_is_refused_by_its_name(gone: str) -> None:
    text = read_proto("fingertip.dbc").replace(f'"{gone}"', '"Gone"')
    with pytest.raises(ConfigError, match=gone):
        build_layouts(cantools.database.load_string(text, "dbc"))


def test_no_control_character_of_a_file_reaches_the_terminal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "x.csv").write_text("t,\x1b]0;title\x07\n1,2\n")
    assert main(["import", str(tmp_path / "x.csv"), "-o", str(tmp_path / "out")]) == 3
    said = capsys.readouterr().err
    assert r"\x1b]0;title\x07" in said
    assert "\x1b" not in said


@pytest.mark.parametrize(
    "unit",
    [
        *("m**9**9**9**9", "9**9**9**9 m", "9^9^9^9 m", "9**(9*9)**9 m", "m**99999999999999", "9⁹⁹⁹⁹⁹⁹⁹⁹⁹ m"),
        *("((((9**9)**9)**9)**9)**9 m", "m/0", "1" * 400 + "*m", "N" * 5000, "(" * 500, "m**1e9", "0*m**-1"),
    ],
)
def test_a_unit_that_takes_for_ever_or_has_no_value_is_refused(unit: str) -> None:
    with pytest.raises(RecordingError, match=r"there is no unit|is not a unit of this quantity"):
        to_si(unit, "m", "column 'x'")


@pytest.mark.parametrize(
    ("unit", "wanted", "scale"),
    [
        ("mm", "m", 1e-3),
        ("kg*m/s**2", "N", 1.0),
        ("kg m^2 s^-2 / m", "N", 1.0),
        ("(mm/s)**2", "m^2/s^2", 1e-6),
        ("m²", "m^2", 1.0),
    ],
)
def test_units_with_powers_are_still_understood(unit: str, wanted: str, scale: float) -> None:
    assert to_si(unit, wanted, "column 'x'") == (pytest.approx(scale), 0.0)


@pytest.mark.parametrize("index", ["9" * 5000, "²"])
def test_an_index_that_no_array_has_is_refused(index: str) -> None:
    with pytest.raises(RecordingError):
        BagField.parse(f"/joints:effort[{index}]", "normal_force")


@pytest.mark.parametrize("name", ["\x1b[31m", "[/]", "[red]x", ":b:"])
def test_names_in_a_recording_are_printed_as_they_are_and_change_nothing_in_the_terminal(
    name: str, press: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("mcap", reason="the extra `bags` is not installed")
    (press / "recording.toml").write_text(f"[fingertip]\nname = {json.dumps(name)}\n")
    assert main(["import", str(press), "-o", str(press.with_name("x.mcap"))]) == 0
    said = capsys.readouterr().out.replace("\n", "")
    assert repr(name)[1:-1] in said
    assert "\x1b" not in said
