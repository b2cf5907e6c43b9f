"""Many recordings: hands, pads and dates, a table, runs that go on, and a cluster."""

import json
from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import DeviceError, RecordingError
from vegrip.identification.fleet import Found, Row, examine_recording, find_recordings, run, summarize_rows
from vegrip.identification.fleet.row import Ledger, csv_text
from vegrip.identification.recording import Recording, write_recording
from vegrip.identification.simulate import simulate
from vegrip.identification.simulate.protocol import standard
from vegrip.model import paper_model, write_model

MODEL = paper_model(8e-3)


def pressed(rate: float = 50.0) -> Recording:
    """Return a short recording with nothing hidden."""
    whole = standard(MODEL)
    protocol = replace(whole, episodes=(whole.episodes[1], whole.episodes[6], whole.episodes[1]), notes=())
    return simulate(MODEL, protocol, sensors={"normal_force": 0.01, "displacement": 5e-6}, rate=rate)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Two hands, three pads, one of them broken."""
    root = tmp_path_factory.mktemp("fleet")
    recording = pressed()
    source = {"hand": "left", "pad": "index", "date": "2026-01-05"}
    write_recording(replace(recording, source=source), root / "a" / "one")
    write_recording(replace(recording, source={"began": "2026-02-01T10:00:00+00:00"}), root / "b" / "thumb")
    broken = root / "b" / "cut"
    broken.mkdir()
    (broken / "recording.toml").write_text('[fingertip]\nname = "cut"\nradius = 0.008\n')
    (broken / "recording.csv").write_text("t,normal_force\n0,1\n1,2\n")
    return root


def test_hand_pad_and_date_are_read_or_guessed(folder) -> None:
    found = {one.path.removeprefix(f"{folder}/"): one for one in find_recordings(folder)}
    assert (found["a/one"].hand, found["a/one"].pad, found["a/one"].date) == (
        "left",
        "index",
        "2026-01-05T00:00:00",
    )
    assert (found["b/thumb"].hand, found["b/thumb"].pad) == ("b", "index")
    assert found["b/thumb"].date.startswith("2026-02-01")
    assert found["b/cut"].dated_by == "file"
    assert found["b/cut"].date[:4] >= str(date.today().year)


@pytest.mark.long
def test_recordings_that_say_nothing_of_their_pad_are_not_put_together(tmp_path, capsys) -> None:
    for name in ("a", "b"):
        write_recording(pressed(), tmp_path / name)
    write_recording(replace(pressed(), source={"pad": "ring"}), tmp_path / "c")
    found = find_recordings(tmp_path)
    assert sorted((one.pad, one.is_alone) for one in found) == [("a", True), ("b", True), ("ring", False)]
    assert main(["fleet", str(tmp_path), "-j", "1"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert (
        "2 recordings do not say of which hand and pad they are, and each counts as a pad of its own" in told
    )
    assert "of 3 pads" in told


def test_an_empty_folder_is_refused(tmp_path) -> None:
    with pytest.raises(RecordingError, match="no recording in it"):
        find_recordings(tmp_path)
    with pytest.raises(RecordingError, match="no such folder"):
        find_recordings(tmp_path / "absent")


def test_a_bad_recording_is_a_row_that_says_why(folder) -> None:
    row = examine_recording(str(folder / "b" / "cut"))
    assert row.verdict == "failed"
    assert "no displacement" in row.note
    assert examine_recording(str(folder / "absent")).verdict == "failed"


@pytest.mark.slow
def test_what_cannot_carry_an_answer_is_not_judged_and_lost_rows_are_told(tmp_path) -> None:
    quick = pressed(200.0)
    touched = np.cumsum(quick.columns["normal_force"] > 0.05)
    write_recording(quick.select(touched <= 120), tmp_path / "brief")  # 0.6 s
    row = examine_recording(str(tmp_path / "brief"))
    assert row.verdict == "failed"
    assert "in contact" in row.note
    write_recording(pressed(), tmp_path / "cut")
    text = (tmp_path / "cut" / "recording.csv").read_text()
    (tmp_path / "cut" / "recording.csv").write_text(text[: text.rindex(",")])
    row = examine_recording(str(tmp_path / "cut"))
    assert row.verdict == "adequate"
    assert "the last line is cut" in row.lost
    assert "\n" not in row.lost


def found(when: str, pad: str = "index", path: str = "") -> Found:
    return Found(path or f"{pad}-{when}", "left", pad, when, "recording", "f")


def named(*effects: str) -> Row:
    return Row("", "named" if effects else "adequate", effects, dict.fromkeys(effects, 0.1), 2.0, 1.0)


def test_since_is_the_first_day_of_the_last_unbroken_run() -> None:
    days = ["2026-01", "2026-02", "2026-03", "2026-04", "2026-05"]
    rows = [named("adhesion"), named(), named("adhesion"), named("adhesion", "sensor_lag"), named("adhesion")]
    table = {
        one.effect: one
        for one in summarize_rows([(found(d), r) for d, r in zip(days, rows, strict=True)][::-1])
    }
    assert set(table) == {"adhesion", "sensor_lag"}
    sticky, late = table["adhesion"], table["sensor_lag"]
    assert (sticky.since, sticky.present, sticky.shown, sticky.judged) == ("2026-03", True, 4, 5)
    assert (late.since, late.until, late.present, late.shown) == ("2026-04", "2026-04", False, 1)


def test_failures_do_not_break_a_run_and_pads_are_told_apart() -> None:
    failed = Row("x", "failed", note="no displacement")
    rows = [
        (found("2026-01"), named("adhesion")),
        (found("2026-02"), failed),
        (found("2026-03"), named("adhesion")),
        (found("2026-03", "thumb"), named()),
        (found("2026-04", "ring"), Row("", "unexplained", (), {}, 2.0, 2.0, "depends on speed")),
        (found("2026-05", "ring"), Row("", "ambiguous", ("a or b",), {"a": 1.0}, 2.0, 1.0)),
    ]
    table = [(one.pad, one.effect, one.since, one.present) for one in summarize_rows(rows)]
    assert table == [
        ("index", "adhesion", "2026-01", True),
        ("index", "failed", "2026-02", False),
        ("ring", "unexplained", "2026-04", False),
        ("ring", "a or b", "2026-05", True),
        ("thumb", "none", "2026-03", True),
    ]
    assert csv_text(summarize_rows(rows)).count("\n") == 6


def test_what_else_may_have_caused_an_effect_is_told_beside_it() -> None:
    row = replace(named("sensor_lag"), doubts=("a clock that is late would show the same",))
    (one,) = summarize_rows([(found("2026-01"), row)])
    assert one.note == "a clock that is late would show the same"


def test_the_ledger_knows_a_recording_until_it_or_the_model_changes(tmp_path) -> None:
    one = found("2026-01")
    ledger = Ledger(tmp_path / "l.jsonl", "model")
    assert ledger.row(one) is None
    ledger.add(one, named("adhesion"))
    ledger.add(found("2026-02"), Row("x", "failed", note="why"))
    with (tmp_path / "l.jsonl").open("a") as stream:
        stream.write('{"key": "cut off')
    again = Ledger(tmp_path / "l.jsonl", "model")
    assert again.row(one) == named("adhesion")
    assert np.isnan(again.row(found("2026-02")).before)
    assert again.row(replace(one, fingerprint="g")) is None
    assert Ledger(tmp_path / "l.jsonl", "other").row(one) is None


def test_the_table_names_pad_effect_and_date_in_full_and_what_was_not_judged(
    tmp_path, capsys, monkeypatch
) -> None:
    rows = {
        "index-2026-03-01": replace(named("second_relaxation"), lost="9 of 10 rows kept"),
        "thumb-2026-02-01": named(),
        "ring-2026-01-01": Row("", "failed", note="no displacement"),
    }
    there = [found(path.partition("-")[2], path.partition("-")[0], path) for path in rows]
    monkeypatch.setattr("vegrip.identification.fleet.find_recordings", lambda _: there)
    monkeypatch.setattr(
        "vegrip.identification.fleet.run", lambda left, *_, **__: ((one, rows[one.path]) for one in left)
    )
    assert main(["fleet", str(tmp_path)]) == 0
    told = capsys.readouterr().out
    assert "left  index  second_relaxation  2026-03-01  1 of 1   yes  second_relaxation 0.1" in told
    assert "left  thumb  nothing missing" in told
    assert "- not judged: ring-2026-01-01: no displacement" in told
    assert "- index-2026-03-01: 9 of 10 rows kept" in told
    assert "3 recordings, 1 of them not judged; the others are of 2 pads of 1 hands" in told


@pytest.mark.long
@pytest.mark.slow
def test_the_command_fills_the_table_and_a_second_run_has_nothing_to_do(folder, tmp_path, capsys) -> None:
    out, ledger = tmp_path / "t.csv", tmp_path / "l.jsonl"
    given = ["fleet", str(folder), "-o", str(out), "--ledger", str(ledger), "-j", "1", "--json"]
    assert main(given) == 0
    streams = capsys.readouterr()
    told = json.loads(streams.out)
    assert {one["effect"] for one in told["findings"]} == {"none", "failed"}
    assert len(told["recordings"]) == 3
    assert "3 of 3" in streams.err
    lines = ledger.read_text().splitlines()
    ledger.write_text("\n".join(lines[:2]) + "\n" + lines[2][:20])  # as if killed while it wrote
    assert main(given) == 3  # the table is there
    assert main([*given, "--force"]) == 0
    again = capsys.readouterr()
    assert "3 recordings, 2 of them known" in again.err
    assert json.loads(again.out)["findings"] == told["findings"]
    assert out.read_text().startswith("hand,pad,effect,since")


def test_what_cannot_be_is_told_before_anything_is_examined(folder, tmp_path, capsys) -> None:
    assert main(["fleet", str(tmp_path / "absent")]) == 3
    assert main(["fleet", str(folder), "--model", str(tmp_path / "absent.toml")]) == 3
    write_model(MODEL, tmp_path / "m.toml")
    assert "Traceback" not in capsys.readouterr().err


@pytest.fixture
def deadly(monkeypatch, tmp_path) -> None:
    """Let processes that are started from here on kill themselves when they read the recording ``one``."""
    (tmp_path / "sitecustomize.py").write_text(
        "import os, signal, vegrip.identification.recording as r\n"
        "read = r.read_recording\n"
        "def dying(path, **options):\n"
        "    if str(path).endswith('one'):\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
        "    return read(path, **options)\n"
        "r.read_recording = dying\n"
    )
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))


@pytest.mark.long
@pytest.mark.slow
def test_a_process_that_dies_costs_only_its_own_recording(folder, deadly) -> None:
    """What it was at work on is tried once more alone, and is then a row."""
    rows = {one.path.rpartition("/")[2]: row for one, row in run(find_recordings(folder), processes=2)}
    assert rows["one"].verdict == "failed"
    assert "died" in rows["one"].note
    assert rows["thumb"].verdict == "adequate"
    assert rows["cut"].verdict == "failed"
    assert [name for name, row in rows.items() if row.is_machine_failure] == ["one"]


@pytest.mark.long
def test_a_worker_of_a_cluster_that_dies_costs_only_its_own_recording_and_that_is_tried_again(
    tmp_path, deadly, capsys
) -> None:
    """Dask holds a death against all tasks of the worker: it has two threads, so that there are others."""
    distributed = pytest.importorskip("distributed")
    for name in ("zero", "one", "two", "three", "four", "five"):
        write_recording(pressed(), tmp_path / "hand" / name)
    ledger = tmp_path / "l.jsonl"
    pieces = {"n_workers": 2, "threads_per_worker": 2, "processes": True, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(host="127.0.0.1", protocol="tcp", silence_logs=50, **pieces) as cluster:
        given = [str(tmp_path / "hand"), "--ledger", str(ledger), "--scheduler", cluster.scheduler_address]
        assert main(["fleet", *given, "--json"]) == 0
    rows = {Path(row["path"]).name: row for row in json.loads(capsys.readouterr().out)["recordings"]}
    assert {name: row["verdict"] for name, row in rows.items() if name != "one"} == dict.fromkeys(
        ("zero", "two", "three", "four", "five"), "adequate"
    )
    assert "died" in rows["one"]["note"]
    known = [Path(json.loads(line)["path"]).name for line in ledger.read_text().splitlines()]
    assert sorted(known) == ["five", "four", "three", "two", "zero"]


def test_what_failed_for_a_reason_of_the_machine_is_not_kept(tmp_path, folder, monkeypatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise MemoryError

    unseen = examine_recording(str(tmp_path / "drive" / "one"))
    modelless = examine_recording(str(folder / "b" / "cut"), str(tmp_path / "drive" / "m.toml"))
    monkeypatch.setattr("vegrip.identification.recording.read_recording", full)
    rows = (unseen, modelless, examine_recording(str(folder / "b" / "cut")))
    ledger = Ledger(tmp_path / "l.jsonl")
    for row in rows:
        assert row.verdict == "failed"
        ledger.add(found("2026-01"), row)
    assert ledger.row(found("2026-01")) is None
    assert not ledger.path.exists()


def test_a_cluster_gives_the_same_rows(folder) -> None:
    distributed = pytest.importorskip("distributed")
    pieces = {"n_workers": 1, "threads_per_worker": 1, "processes": False, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(host="127.0.0.1", protocol="tcp", **pieces) as cluster:
        rows = {
            one.path: row for one, row in run(find_recordings(folder), scheduler=cluster.scheduler_address)
        }
    verdicts = {path.rpartition("/")[2]: row.verdict for path, row in rows.items()}
    assert verdicts == {"one": "adequate", "thumb": "adequate", "cut": "failed"}


def test_a_scheduler_that_is_not_there_is_said(folder, monkeypatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("vegrip.identification.fleet.workers.CONNECT", 0.5)
    with pytest.raises(DeviceError, match="does not answer"):
        list(run(find_recordings(folder), scheduler="tcp://127.0.0.1:1"))
