"""A recording in memory: what is refused, and how it turns into messages."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vegrip.cli import main
from vegrip.errors import InputError, RecordingError, UsageError
from vegrip.identification.recording import Fingertip, Recording, read_recording
from vegrip.identification.recording.checks import longest_increasing
from vegrip.identification.recording.data import (
    episodes_text,
    join_recordings,
    parse_episodes,
    select_episodes,
)


def press(**changed: object) -> Recording:
    fields: dict[str, object] = {
        "name": "press",
        "t": np.array([0.0, 0.1, 0.3]),
        "episode": np.array([0, 0, 4]),
        "columns": {"normal_force": np.array([0.0, 1.0, math.nan])},
    }
    return Recording(**(fields | changed))  # type: ignore[arg-type]


def test_rows_become_messages_with_integer_stamps() -> None:
    states = list(press().states("thumb", start=7))
    assert [s.stamp for s in states] == [7, 100_000_007, 300_000_007]
    assert [s.seq for s in states] == [0, 1, 2]
    assert states[1].normal_force == 1.0
    assert math.isnan(states[2].normal_force)
    assert math.isnan(states[0].torque_z)  # not measured is never zero


@given(st.integers(0, 10**15))
def test_a_nanosecond_stamp_survives_seconds_as_float(stamp: int) -> None:
    one = press(t=np.array([stamp / 1e9]), episode=np.zeros(1, int), columns={"slip": np.zeros(1)})
    assert one.stamps.tolist() == [stamp]


def test_episodes_are_recordings_of_their_own() -> None:
    first, second = press().episodes()
    assert (len(first), len(second), second.name) == (2, 1, "press episode 4")
    assert press().duration == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"columns": {}}, "the columns are none"),
        ({"columns": {"force": np.zeros(3)}}, "must be some of"),
        ({"sensors": {"force": 1.0}}, "unknown sensor"),
        ({"columns": {"slip": np.zeros(2)}}, "differ in length"),
        ({"t": np.array([0.0, 0.2, 0.2])}, "time does not increase"),
    ],
)
def test_what_is_not_a_recording_is_refused(changed: dict[str, object], sentence: str) -> None:
    with pytest.raises(RecordingError, match=sentence):
        press(**changed)


@given(st.lists(st.integers(-20, 20).map(float), min_size=1, max_size=12))
def test_the_longest_increasing_run_is_longest(values: list[float]) -> None:
    kept = longest_increasing(np.array(values))
    chosen = np.array(values)[kept]
    assert np.all(np.diff(kept) > 0)
    assert np.all(np.diff(chosen) > 0)
    ends = [1] * len(values)  # quadratic textbook recursion: longest run that ends at i
    for i in range(len(values)):
        ends[i] += max((ends[j] for j in range(i) if values[j] < values[i]), default=0)
    assert len(kept) == max(ends)


@pytest.fixture
def recording() -> Recording:
    t = np.arange(12.0)
    return Recording("press", t, np.repeat([0, 1, 2, 5], 3), {"normal_force": t})


@pytest.mark.parametrize(
    ("text", "numbers"), [("", []), ("3", [3]), ("2,5..7", [2, 5, 6, 7]), (" 7 , 5..6,5", [5, 6, 7])]
)
def test_lists_and_ranges_are_read(text: str, numbers: list[int]) -> None:
    assert parse_episodes(text, "--episodes") == numbers
    assert parse_episodes(episodes_text(numbers), "--episodes") == numbers


@pytest.mark.parametrize("text", ["a", "3..", "..3", "5..2", "1-3", "0..9999999"])
def test_what_is_no_list_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(UsageError, match=r"--hold-back has .*2,5\.\.7"):
        parse_episodes(text, "--hold-back")


def test_the_rows_of_the_chosen_episodes_are_left(recording: Recording) -> None:
    assert set(select_episodes(recording, only="1,5").episode) == {1, 5}
    assert set(select_episodes(recording, without="1,5").episode) == {0, 2}
    assert select_episodes(recording) is recording


def test_an_episode_that_is_not_there_is_said_with_those_that_are(recording: Recording) -> None:
    with pytest.raises(InputError, match=r"has no episode 3; its episodes are 0\.\.2,5"):
        select_episodes(recording, without="1..3")
    with pytest.raises(InputError, match="no episode of press is left"):
        select_episodes(recording, without="0..2,5")


def pressed(name: str, top: float, radius: float = 0.01) -> Recording:
    t = np.arange(0.0, 1.0, 0.01)
    columns = {"displacement": 1e-3 * t, "normal_force": top * t}
    return Recording(name, t, np.zeros(t.size, dtype=np.int64), columns, Fingertip(radius))


def test_each_becomes_an_episode_and_time_goes_on() -> None:
    both = join_recordings([pressed("a", 1.0), pressed("b", 2.0)], "both")
    assert len(both) == 200
    assert np.unique(both.episode).tolist() == [0, 1]
    assert both.t[100] - both.t[99] == pytest.approx(60.0)
    assert np.array_equal(both.columns["normal_force"][100:], pressed("b", 2.0).columns["normal_force"])


def test_episodes_of_a_recording_stay_apart() -> None:
    two = join_recordings([pressed("a", 1.0), pressed("b", 2.0)], "two")
    assert np.unique(join_recordings([two, pressed("c", 3.0)], "three").episode).tolist() == [0, 1, 2]


def test_what_does_not_go_together_is_refused() -> None:
    bare = pressed("bare", 1.0)
    bare = Recording(
        "bare", bare.t, bare.episode, {"normal_force": bare.columns["normal_force"]}, bare.fingertip
    )
    with pytest.raises(RecordingError, match="only one has displacement"):
        join_recordings([pressed("a", 1.0), bare], "x")
    with pytest.raises(RecordingError, match="radius"):
        join_recordings([pressed("a", 1.0), pressed("b", 1.0, 0.02)], "x")


def test_command_joins_tables(tmp_path, capsys) -> None:
    for name, top in (("a", 1.0), ("b", 2.0)):
        one = pressed(name, top)
        rows = np.stack([one.t, one.columns["displacement"], one.columns["normal_force"]], axis=1)
        np.savetxt(
            tmp_path / f"{name}.csv", rows, delimiter=",", header="t,displacement,normal_force", comments=""
        )
    files = [str(tmp_path / f"{name}.csv") for name in "ab"]
    assert main(["import", *files, "-o", str(tmp_path / "both"), "--radius", "10 mm"]) == 0
    found = read_recording(tmp_path / "both")
    assert found.name == "both"
    assert np.unique(found.episode).tolist() == [0, 1]
    assert main(["import", *files, "-o", str(tmp_path / "both.mcap")]) == 2
    assert "one by one" in capsys.readouterr().err
