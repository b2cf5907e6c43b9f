"""A recording as a data set of LeRobot is read by pyarrow alone, and comes back; open tactile data too."""

import json
from pathlib import Path

import numpy as np
import pytest

from vegrip import Fingertip, Recording, read_recording, write_recording
from vegrip.cli import main

pytest.importorskip("pyarrow")
import pyarrow as pa
import pyarrow.parquet as pq

DATA = "data/chunk-000/file-000.parquet"


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    """Two episodes of 50 and 30 rows at 100 Hz, and a margin every 50 ms of the first."""
    t = np.concatenate([np.arange(50), 200 + np.arange(30)]) / 100.0
    columns = {
        "normal_force": 1.0 + t, "tangential_force_x": 0.1 * t, "torque_z": -1e-3 * t,
        "displacement": np.where(t < 0.1, np.nan, 1e-4 * t),
    }  # fmt: skip
    episode = np.repeat([0, 1], [50, 30])
    write_recording(Recording("pull", t, episode, columns, Fingertip(8e-3, name="thumb")), tmp_path / "pull")
    rows = [f"{0.05 * n:g},{n},0.{n},0.1,1,0,0.{n}5,0.95,1,inf,inf" for n in range(1, 9)]
    header = "t,seq,margin,margin_std,margin_valid,margin_age,lower_bound,confidence,force_reserve"
    text = "\n".join([f"{header},time_to_slip,earliest_slip", *rows]) + "\n"
    (tmp_path / "pull" / "slip_margin.csv").write_text(text)
    return tmp_path / "pull"


@pytest.fixture
def made(recorded: Path, tmp_path: Path) -> Path:
    assert main(["export", "lerobot", str(recorded), "-o", str(tmp_path / "set"), "--task", "pull"]) == 0
    return tmp_path / "set"


def test_the_layout_is_that_of_version_3(made: Path) -> None:
    info = json.loads((made / "meta/info.json").read_text())
    assert (info["codebase_version"], info["fps"], info["total_frames"]) == ("v3.0", 100, 80)
    assert info["data_path"].format(chunk_index=0, file_index=0) == DATA
    table = pq.read_table(made / DATA)
    assert set(info["features"]) == set(table.column_names)
    for name, feature in info["features"].items():
        kind = table.schema.field(name).type
        width = kind.list_size if pa.types.is_fixed_size_list(kind) else 1
        assert feature["shape"] == [width]
        leaf = kind.value_type if width > 1 else kind
        assert feature["dtype"] == str(leaf).replace("float", "float32").replace("double", "float64")
    assert set(json.loads((made / "meta/stats.json").read_text())) == set(info["features"])
    assert json.loads((made / "meta/vegrip.json").read_text())["schema"].startswith("observation.tactile")


def test_episodes_are_where_the_table_of_episodes_says(made: Path) -> None:
    table = pq.read_table(made / DATA)
    episodes = pq.read_table(made / "meta/episodes/chunk-000/file-000.parquet").to_pylist()
    assert [one["length"] for one in episodes] == [50, 30]
    for one in episodes:
        rows = table.slice(one["dataset_from_index"], one["length"])
        assert set(rows["episode_index"].to_pylist()) == {one["episode_index"]}
        assert rows["frame_index"].to_pylist() == list(range(one["length"]))
        times = np.array(rows["timestamp"].to_pylist())
        assert times == pytest.approx(np.arange(one["length"]) / 100.0, abs=1e-6)  # 1e-4 is LeRobot's limit
        assert one["tasks"] == ["pull"]


def test_a_frame_has_what_was_known_last_and_nothing_before(made: Path) -> None:
    table = pq.read_table(made / DATA)
    margin = np.array(table["observation.tactile.thumb.margin"].to_pylist())
    bound = np.array(table["observation.tactile.thumb.lower_bound"].to_pylist())
    assert np.isnan(margin[:5]).all()  # the first is said at 50 ms
    assert margin[5:15] == pytest.approx([0.1] * 5 + [0.2] * 5)
    assert bound[12] == pytest.approx(0.25)
    wrench = np.array(table["observation.tactile.thumb.wrench"].to_pylist())
    assert wrench[20] == pytest.approx([0.02, np.nan, 1.2, 0.0, 0.0, -2e-4], nan_ok=True)


def test_a_set_comes_back_as_the_recording_in_single_precision(
    made: Path, recorded: Path, tmp_path: Path
) -> None:
    assert main(["import", str(made), "-o", str(tmp_path / "back")]) == 0
    was, back = read_recording(recorded), read_recording(tmp_path / "back")
    assert (back.fingertip.name, back.fingertip.radius) == ("thumb", 8e-3)
    assert np.array_equal(back.episode, was.episode)
    assert back.t[:50] == pytest.approx(was.t[:50], abs=1e-6)
    assert back.columns.keys() == was.columns.keys()
    for name, values in was.columns.items():
        assert back.columns[name] == pytest.approx(values, rel=1e-6, nan_ok=True), name


def test_fewer_frames_are_those_of_their_instants(recorded: Path, tmp_path: Path) -> None:
    assert main(["export", "lerobot", str(recorded), "-o", str(tmp_path / "slow"), "--fps", "25"]) == 0
    wrench = np.array(pq.read_table(tmp_path / "slow" / DATA)["observation.tactile.thumb.wrench"].to_pylist())
    assert wrench[:13, 2] == pytest.approx(1.0 + np.arange(13) * 0.04)


def test_every_row_of_a_set_counts_as_read_and_as_kept(made: Path, tmp_path: Path, capsys) -> None:
    capsys.readouterr()
    assert main(["import", str(made), "-o", str(tmp_path / "back"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rows"] == {"in": 80, "used": 80, "left_out": {}}


def test_more_frames_than_memory_holds_are_refused_before_any_work(recorded: Path, tmp_path, capsys) -> None:
    assert main(["export", "lerobot", str(recorded), "-o", str(tmp_path / "set"), "--fps", "100000000"]) == 2
    assert "--fps is '100000000'" in capsys.readouterr().err
    assert not (tmp_path / "set").exists()


def test_a_gap_is_not_filled_with_what_was_before(tmp_path: Path, capsys) -> None:
    """100 Hz, nothing from 0.5 to 2.5 s: a state is held for ten steps, not for two seconds."""
    t = np.concatenate([np.arange(50), np.arange(250, 300)]) / 100.0
    force = {"normal_force": 1.0 + t}
    gapped = Recording("gap", t, np.zeros(100), force, Fingertip(8e-3, name="thumb"))
    write_recording(gapped, tmp_path / "gap")
    assert main(["export", "lerobot", str(tmp_path / "gap"), "-o", str(tmp_path / "set"), "--json"]) == 0
    out = capsys.readouterr()
    normal = np.array(pq.read_table(tmp_path / "set" / DATA)["observation.tactile.thumb.wrench"].to_pylist())
    assert np.isnan(normal[60:250, 2]).all()
    assert np.isfinite(normal[:60, 2]).all()
    assert np.isfinite(normal[250:, 2]).all()
    assert json.loads(out.out)["gap_frames"] == {"thumb": int(np.isnan(normal[:, 2]).sum())}
    assert "frames lie in gaps of thumb" in out.err
    assert "nothing came from 0.49 to 2.5 s" in out.err


def test_rows_of_a_damaged_recording_are_counted_in_the_set(recorded: Path, tmp_path: Path, capsys) -> None:
    lines = (recorded / "recording.csv").read_text().splitlines()
    lines[10], lines[-1] = "nothing", lines[-1][:8]
    (recorded / "recording.csv").write_text("\n".join(lines))
    assert main(["export", "lerobot", str(recorded), "-o", str(tmp_path / "set"), "--json"]) == 0
    out = capsys.readouterr()
    rows = json.loads(out.out)["rows"]
    assert (rows["in"], rows["used"]) == (80, 78)
    assert "2 of 80 rows are left out" in out.err


def test_rows_between_fewer_frames_are_counted(recorded: Path, tmp_path: Path, capsys) -> None:
    words = ["export", "lerobot", str(recorded), "-o", str(tmp_path / "slow"), "--fps", "25"]
    assert main([*words, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows_between"] == 80 - told["total_frames"]


def test_a_set_replaces_one_of_ours_alone_and_whole(
    made: Path, recorded: Path, tmp_path: Path, capsys
) -> None:
    words = ["export", "lerobot", str(recorded), "-o"]
    stale = made / "data/chunk-000/file-001.parquet"
    stale.write_bytes((made / DATA).read_bytes())
    assert main([*words, str(made)]) == 3
    assert main([*words, str(made), "--force"]) == 0
    assert not stale.exists()
    before = sorted(recorded.iterdir())
    (tmp_path / "other/data").mkdir(parents=True)
    (tmp_path / "other/data/theirs.bin").write_bytes(b"x")
    for taken in (recorded, tmp_path / "other"):
        capsys.readouterr()
        assert main([*words, str(taken), "--force"]) == 3
        assert "something else than a data set that vegrip wrote" in capsys.readouterr().err
    assert sorted(recorded.iterdir()) == before
    assert sorted(one.name for one in tmp_path.iterdir()) == ["other", "pull", "set"]


def test_frames_of_a_clock_that_jumped_for_years_are_refused(tmp_path: Path, capsys) -> None:
    t = np.concatenate([np.arange(50) / 100.0, [1e9]])
    jumped = Recording("jump", t, np.zeros(51), {"normal_force": 1.0 + 0.0 * t})
    write_recording(jumped, tmp_path / "jump")
    assert main(["export", "lerobot", str(tmp_path / "jump"), "-o", str(tmp_path / "set")]) == 2
    assert "frames at 100 a second are too many" in capsys.readouterr().err
    assert not (tmp_path / "set").exists()


def test_open_tactile_data_are_summed_over_their_elements(tmp_path: Path) -> None:
    normal, shear = np.full((20, 4), 0.5), np.tile([0.1, -0.2], (20, 4, 1))
    names = {"timestamps": np.arange(20) / 30.0, "/observation/tactile/normal_force": normal}
    np.savez(tmp_path / "gel.npz", **names, **{"/observation/tactile/shear_force": shear})
    assert main(["import", str(tmp_path / "gel.npz"), "-o", str(tmp_path / "rec"), "--radius", "12 mm"]) == 0
    back = read_recording(tmp_path / "rec")
    assert back.columns["normal_force"] == pytest.approx(2.0)
    assert back.columns["tangential_force_x"] == pytest.approx(0.4)
    assert back.columns["tangential_force_y"] == pytest.approx(-0.8)
    assert back.fingertip.radius == 12e-3


def test_a_set_of_the_open_schema_in_the_layout_of_lerobot_is_read(tmp_path: Path) -> None:
    (tmp_path / "set/meta").mkdir(parents=True)
    (tmp_path / "set/data/chunk-000").mkdir(parents=True)
    (tmp_path / "set/meta/info.json").write_text(json.dumps({"codebase_version": "v3.0"}))
    columns = {
        "timestamp": pa.array(np.arange(10) / 30.0, pa.float32()),
        "episode_index": pa.array([0] * 5 + [1] * 5),
        "observation.tactile.normal_force": pa.array([[0.25, 0.75]] * 10),
        "observation.tactile.shear_force": pa.array([[[0.1, 0.0], [0.2, 0.0]]] * 10),
    }
    pq.write_table(pa.table(columns), tmp_path / "set" / DATA)
    assert main(["import", str(tmp_path / "set"), "-o", str(tmp_path / "rec")]) == 0
    back = read_recording(tmp_path / "rec")
    assert back.columns["normal_force"] == pytest.approx(1.0)
    assert back.columns["tangential_force_x"] == pytest.approx(0.3)
    assert back.episode.tolist() == [0] * 5 + [1] * 5
    assert (np.diff(back.t) > 0.0).all()


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda s: (s / "meta/info.json").write_text('{"codebase_version": "v1.6"}'), "layout v1.6"),
        (lambda s: (s / "meta/info.json").write_text("{"), "damaged"),
        (lambda s: (s / DATA).write_bytes(b"PAR1 no parquet"), "cannot be read"),
        (lambda s: (s / DATA).unlink(), "there is no data"),
        (lambda s: pq.write_table(pa.table({"timestamp": [0.0, 0.1]}), s / DATA), "there is no touch"),
        (lambda s: pq.write_table(pa.table({"action": [0.0]}), s / DATA), "there is no touch"),
        (lambda s: (s / "meta/info.json").unlink(), "lacks meta/info.json"),
    ],
)
def test_a_set_that_is_not_one_is_refused_in_a_sentence(made: Path, tmp_path, capsys, spoil, said) -> None:
    spoil(made)
    capsys.readouterr()
    assert main(["import", str(made), "-o", str(tmp_path / "back")]) == 3
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "back").exists()


@pytest.mark.parametrize("beginning", [b"no zip", b"PK\x03\x04 cut off", b""])
def test_a_file_that_is_no_npz_is_refused(tmp_path: Path, capsys, beginning: bytes) -> None:
    (tmp_path / "x.npz").write_bytes(beginning)
    assert main(["import", str(tmp_path / "x.npz"), "-o", str(tmp_path / "back")]) == 3
    assert "no .npz file" in capsys.readouterr().err
    assert main(["import", str(tmp_path / "x.npz"), "-o", str(tmp_path / "back"), "--step"]) == 2


def test_objects_in_a_file_are_not_made(tmp_path: Path, capsys) -> None:
    np.savez(tmp_path / "x.npz", timestamps=np.array([{}], dtype=object), normal_force=np.ones((1, 2)))
    assert main(["import", str(tmp_path / "x.npz"), "-o", str(tmp_path / "back")]) == 3
    assert "plain numbers" in capsys.readouterr().err
