"""Times that stand, fall or leap, and values that are marks, are asked about or named; nothing is silent."""

from pathlib import Path

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.identification.recording import read_recording
from vegrip.identification.recording.checks import mark_in
from vegrip.identification.recording.report import Kind, LoadReport, gaps_of
from vegrip.messages import FingertipState
from vegrip.transport.codec import CanCodec

T = 0.01 * np.arange(400)
DEPTH = np.interp(T, [0.0, 0.5, 2.0, 3.5, 4.0], [0.0, 0.0, 1.0, 0.0, 0.0])
FORCE = 1200 * DEPTH**1.5 + np.random.default_rng(4).normal(0.0, 2.0, T.size)
MAPPED = ["--map", "t=t", "--map", "displacement=d", "--unit", "displacement=mm"]
MAPPED += ["--map", "normal_force=f", "--unit", "normal_force=mN", "--radius", "8mm"]


def imported(folder: Path, t, capsys, *more: str, force=FORCE, between=","):
    """Import a press; return the exit code and what stderr says."""
    rows = [f"{a:.2f}{between}{b:.4f}{between}{c:.1f}" for a, b, c in zip(t, DEPTH, force, strict=True)]
    (folder / "a.csv").write_text("\n".join([between.join("tdf"), *rows]) + "\n")
    code = main(["import", str(folder / "a.csv"), "-o", str(folder / "r"), "--force", *MAPPED, *more])
    return code, capsys.readouterr().err


@pytest.mark.parametrize("by", [0.3, 1.5, 3600.0])
def test_a_clock_that_is_set_forward_is_told_first_and_by_every_command_that_follows(
    by, tmp_path, capsys, caplog
):
    code, told = imported(tmp_path, np.where(T >= 2.0, T + by, T), capsys)
    assert code == 0
    assert told.startswith(f"vegrip: {tmp_path / 'r'}: nothing came from 1.99 to {2.0 + by:.6g} s")
    read_recording(tmp_path / "r")
    assert "nothing came from 1.99" in caplog.text


def test_what_no_logger_wrote_is_a_gap_but_not_between_trials_nor_where_rows_grow_rare():
    there = np.r_[0:100, 220:400]
    report = LoadReport(rows_read=there.size, rows_kept=there.size)
    report.place_losses(T[there], there, {}, np.zeros(there.size))
    assert "nothing came from 0.99 to 2.2 s" in report.warnings()[0]
    report = LoadReport(rows_read=there.size, rows_kept=there.size)
    report.place_losses(T[there], there, {}, (there > 150).astype(float))
    assert report.warnings() == []
    assert gaps_of(np.geomspace(0.1, 1e4, 80)) == []
    report = LoadReport(rows_read=T.size, rows_kept=T.size - 3)
    kept = np.r_[0:200, 203:400]
    report.add(Kind.NUMBER, "d", [200, 201, 202])
    report.place_losses(np.where(kept > 202, T[kept] + 1.5, T[kept]), kept, {}, np.zeros(kept.size))
    assert "nothing came from 1.99 to 3.53 s" in report.warnings()[0]


@pytest.mark.parametrize(
    ("t", "sentence"),
    [(T[::-1], "the last row stands first"), (0.0 * T, "have the time 0 s"), (0.0 * T + 0.01, "0.01 s")],
)
def test_times_that_are_none_are_asked_about(t, sentence, tmp_path, capsys):
    code, told = imported(tmp_path, t, capsys, "--accept-losses")
    assert code == 3
    assert sentence in told
    assert not (tmp_path / "r").exists()


@pytest.mark.parametrize("mark", [-9999.0, 9999.9, 32767.0])
@pytest.mark.parametrize("where", ["now and then", "at the top", "at first", "for most of it"])
def test_a_mark_for_what_was_not_measured_is_told(mark, where, tmp_path, capsys):
    gone = {
        "now and then": np.arange(T.size) % 40 == 3,
        "at the top": FORCE > 1100,
        "at first": T < 0.3,
        "for most of it": (T > 0.6) & (T < 3.4),
    }[where]
    code, told = imported(tmp_path, T, capsys, force=np.where(gone, mark, FORCE))
    assert code == 0
    assert f"is {1e-3 * mark:.6g} in {gone.sum()} of 400 rows, far from all others" in told.splitlines()[0]


@pytest.mark.parametrize(
    "values",
    [
        FORCE,
        np.minimum(FORCE, 900.0),  # saturated
        np.where(T < 1.0, 0.0, 1.0),  # a step
        np.repeat([0.0, 0.3, 0.7, 1.0, 0.6, 0.0], [100, 1, 1, 200, 1, 97]),  # pressed quickly and held
        np.round(DEPTH, 1),
    ],
)
def test_what_is_measured_is_no_mark(values):
    assert mark_in(values) is None


def test_fields_that_stand_below_each_other_are_read_once_that_is_said(tmp_path, capsys):
    code, told = imported(tmp_path, T, capsys, between="   ")
    assert code == 3
    assert told.endswith("say what separates its fields: --delimiter ' '\n")
    assert imported(tmp_path, T, capsys, "--delimiter", " ", between="   ") == (0, "")
    found = read_recording(tmp_path / "r", announce=False)
    np.testing.assert_allclose(found.columns["displacement"], 1e-3 * DEPTH, atol=1e-7)


MS = [f"{k // 100:d}.{10 * (k % 100):03d}" if k >= 100 else f"{10 * k:d}" for k in range(T.size)]


@pytest.mark.parametrize("begin", ["0,", "1,"])
def test_a_comma_beside_points_between_thousands_is_the_decimal_sign(begin, tmp_path):
    rows = [f"{a}\t{begin}{round(999 * b):03d}\t{c:.0f}" for a, b, c in zip(MS, DEPTH, FORCE, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["t\td\tf", *rows]) + "\n")
    command = ["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "r"), *MAPPED, "--unit", "t=ms"]
    for more in ([], ["--decimal", ",", "--force"]):
        assert main([*command, *more]) == 0
        found = read_recording(tmp_path / "r", announce=False)
        expected = 1e-3 * (float(begin[0]) + 0.999 * DEPTH)
        np.testing.assert_allclose(found.columns["displacement"], expected, atol=1e-6)
        np.testing.assert_allclose(found.t, T, atol=1e-9)


def test_points_and_commas_between_thousands_of_one_table_are_asked_about(tmp_path, capsys):
    rows = [f"{a}\t{2000 * b:,.0f}\t{c:.0f}" for a, b, c in zip(MS, DEPTH, FORCE, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["t\td\tf", *rows]) + "\n")
    assert main(["import", str(tmp_path / "a.csv"), "-o", str(tmp_path / "r"), *MAPPED]) == 3
    assert "'.' stands between thousands in 't', and ',' is in other numbers" in capsys.readouterr().err


def states(finger: str, fingers: tuple[str, ...]) -> list[tuple[float, int, bytes]]:
    codec, found = CanCodec(fingers, fd=True), []
    for k, t in enumerate(T.tolist()):
        state = FingertipState(round(1e9 * t) + 1, finger, k, normal_force=1e-3 * FORCE[k])
        found += [(t, frame.arbitration_id, frame.data) for frame in codec.encode(state)]
    return found


def logged(folder: Path, frames, *fingers: str) -> int:
    lines = [f"({1.7e9 + t:.6f}) can0 {i:03X}##1{data.hex().upper()}\n" for t, i, data in frames]
    (folder / "a.log").write_text("".join(lines))
    return main(
        ["import", str(folder / "a.log"), "-o", str(folder / "r"), "--force", "--fingers", ",".join(fingers)]
    )


def test_fingers_that_speak_at_once_keep_their_times(tmp_path):
    both = sorted(states("thumb", ("thumb", "index")) + states("index", ("thumb", "index")))
    assert logged(tmp_path, both, "thumb", "index") == 0
    for finger in ("thumb", "index"):
        found = read_recording(tmp_path / "r" / finger, announce=False)
        np.testing.assert_allclose(found.t, T, atol=1e-6)


def test_frames_out_of_order_are_refused_and_an_echo_is_no_loss(tmp_path, capsys):
    frames = states("thumb", ("thumb",))
    assert logged(tmp_path, frames[::-1], "thumb") == 3
    assert "the last row stands first" in capsys.readouterr().err
    assert logged(tmp_path, [one for one in frames for _ in range(2)], "thumb") == 0
    assert capsys.readouterr().err == ""
    assert len(read_recording(tmp_path / "r" / "thumb", announce=False)) == T.size
    late = [(t, *frames[k - 50 if 200 <= k < 210 else k][1:]) for k, (t, *_) in enumerate(frames)]
    assert logged(tmp_path, late, "thumb") == 0
    assert "frame refused (10 x" in capsys.readouterr().err
