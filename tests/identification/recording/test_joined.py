"""Several tables as one recording."""

import numpy as np
import pytest

from vegrip.cli import main
from vegrip.errors import RecordingError
from vegrip.identification.recording import Fingertip, Recording, read_recording
from vegrip.identification.recording.data import join_recordings


def press(name: str, top: float, radius: float = 0.01) -> Recording:
    t = np.arange(0.0, 1.0, 0.01)
    columns = {"displacement": 1e-3 * t, "normal_force": top * t}
    return Recording(name, t, np.zeros(t.size, dtype=np.int64), columns, Fingertip(radius))


def test_each_becomes_an_episode_and_time_goes_on() -> None:
    both = join_recordings([press("a", 1.0), press("b", 2.0)], "both")
    assert len(both) == 200
    assert np.unique(both.episode).tolist() == [0, 1]
    assert both.t[100] - both.t[99] == pytest.approx(60.0)
    assert np.array_equal(both.columns["normal_force"][100:], press("b", 2.0).columns["normal_force"])


def test_episodes_of_a_recording_stay_apart() -> None:
    two = join_recordings([press("a", 1.0), press("b", 2.0)], "two")
    assert np.unique(join_recordings([two, press("c", 3.0)], "three").episode).tolist() == [0, 1, 2]


def test_what_does_not_go_together_is_refused() -> None:
    bare = press("bare", 1.0)
    bare = Recording(
        "bare", bare.t, bare.episode, {"normal_force": bare.columns["normal_force"]}, bare.fingertip
    )
    with pytest.raises(RecordingError, match="only one has displacement"):
        join_recordings([press("a", 1.0), bare], "x")
    with pytest.raises(RecordingError, match="radius"):
        join_recordings([press("a", 1.0), press("b", 1.0, 0.02)], "x")


def test_command_joins_tables(tmp_path, capsys) -> None:
    for name, top in (("a", 1.0), ("b", 2.0)):
        one = press(name, top)
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
