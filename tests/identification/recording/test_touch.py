"""Touch data that vegrip did not write: other names, images, chunks and episodes; what is lost is counted."""

import json
from pathlib import Path

import numpy as np
import pytest

from vegrip import import_recording, read_recording
from vegrip.cli import main

pytest.importorskip("pyarrow")
pytest.importorskip("h5py")
import h5py
import pyarrow as pa
import pyarrow.parquet as pq

FPS = 20
T = np.arange(60) / FPS
PRESS = 2.0 * np.sin(np.pi * T / T[-1]) ** 2  # [N]


def write_set(folder: Path, version: str = "v3.0", scale: float = 1.0, **more: object) -> Path:
    """A set of a gripper with a camera: three episodes of 60 frames in two chunks, forces in its state."""
    (folder / "meta").mkdir(parents=True)
    state = {"dtype": "float32", "shape": [3], "names": {"motors": ["gripper", "fz", "fx"]}}
    features = {
        "observation.state": state,
        "observation.images.wrist": {"dtype": "image", "shape": [4, 4, 3], "names": ["height"]},
        "action": {"dtype": "float32", "shape": [1], "names": None},
    }
    info = {"codebase_version": version, "fps": FPS, "total_frames": 180, "features": features, **more}
    (folder / "meta/info.json").write_text(json.dumps(info))
    for episode, (chunk, place) in enumerate([(0, 0), (0, 1), (1, 0)]):
        name = f"file-{place:03d}" if version.startswith("v3") else f"episode_{episode:06d}"
        rows = np.stack([0.04 - 1e-3 * PRESS, 1e3 * PRESS, 100.0 * PRESS], axis=1)  # m, mN, mN
        table = {
            "observation.state": pa.array(rows.tolist(), pa.list_(pa.float32(), 3)),
            "observation.images.wrist": pa.array([{"bytes": b"PNG", "path": None}] * 60),
            "action": pa.array(PRESS, pa.float32()),
            "timestamp": pa.array(scale * T, pa.float32()),
            "frame_index": pa.array(range(60)),
            "episode_index": pa.array([episode] * 60),
            "index": pa.array(range(60 * episode, 60 * episode + 60)),
        }
        path = folder / f"data/chunk-{chunk:03d}/{name}.parquet"
        path.parent.mkdir(parents=True, exist_ok=True)
        pq.write_table(pa.table(table), path)
    return folder


FORCES = ["--map", "normal_force=observation.state[1]", "--unit", "normal_force=mN"]


def imported(path: Path, *options: str) -> int:
    return main(["import", str(path), "-o", str(path.parent / "rec"), *options])


@pytest.mark.parametrize("version", ["v3.0", "v2.1"])
def test_a_set_of_others_is_read_by_a_map_with_units_and_all_its_episodes(tmp_path, version: str) -> None:
    made = write_set(tmp_path / "set", version)
    shear = ["--map", "tangential_force_x=observation.state.fx", "--unit", "tangential_force_x=mN"]
    assert imported(made, *FORCES, *shear, "--radius", "8 mm") == 0
    back = read_recording(tmp_path / "rec")
    assert back.columns["normal_force"] == pytest.approx(np.tile(PRESS, 3), abs=1e-6)
    assert back.columns["tangential_force_x"] == pytest.approx(np.tile(0.1 * PRESS, 3), abs=1e-6)
    assert back.episode.tolist() == [0] * 60 + [1] * 60 + [2] * 60
    assert np.diff(back.t)[[0, 58, 60, 118, 120]] == pytest.approx(1.0 / FPS, abs=1e-6)
    assert back.fingertip.radius == 8e-3


def test_python_reads_the_same(tmp_path: Path) -> None:
    made = write_set(tmp_path / "set")
    columns = {"normal_force": "observation.state.fz"}
    back = import_recording(made, columns=columns, units={"normal_force": "mN"})
    assert back.columns["normal_force"] == pytest.approx(np.tile(PRESS, 3), abs=1e-6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ([], "there are observation.state (3), observation.images.wrist (4, 4, 3), action"),
        (["--map", "normal_force=observation.state"], "say which number, [0] to [2]"),
        (["--map", "normal_force=observation.state[3]"], "say which number, [0] to [2]"),
        (["--map", "normal_force=action[0]"], "leave the index away"),
        (["--map", "normal_force=observation.force"], "there is no column 'observation.force'"),
        (["--map", "normal_force=observation.state.fy"], "there is no column 'observation.state.fy'"),
        (["--map", "normal_force=observation.images.wrist"], "and no plain number"),
        ([*FORCES, "--map", "t=clock"], "there are no times"),
    ],
)
def test_what_a_set_does_not_have_is_said_with_what_it_has(tmp_path, capsys, options, said: str) -> None:
    assert imported(write_set(tmp_path / "set"), *options) == 3
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1
    assert not (tmp_path / "rec").exists()


def test_times_in_ms_are_asked_about_and_read_once_their_unit_is_said(tmp_path, capsys) -> None:
    made = write_set(tmp_path / "set", scale=1e3)
    assert imported(made, *FORCES) == 3
    assert "20 frames a second; say its unit, as in --unit t=ms" in capsys.readouterr().err
    assert imported(made, *FORCES, "--unit", "t=ms") == 0
    assert np.diff(read_recording(tmp_path / "rec").t)[0] == pytest.approx(1.0 / FPS, abs=1e-6)


def test_frames_that_the_set_says_it_has_are_missed_and_counted(tmp_path: Path, capsys) -> None:
    made = write_set(tmp_path / "set")
    (made / "data/chunk-001/file-000.parquet").unlink()
    assert imported(made, *FORCES) == 3
    assert "60 of 180 rows are left out" in capsys.readouterr().err
    assert imported(made, *FORCES, "--accept-losses", "--json") == 0
    out = capsys.readouterr()
    rows = json.loads(out.out)["rows"]
    assert (rows["in"], rows["used"], rows["left_out"]["unseen"]["count"]) == (180, 120, 60)


def test_a_damaged_file_of_several_is_named(tmp_path: Path, capsys) -> None:
    made = write_set(tmp_path / "set")
    (made / "data/chunk-000/file-001.parquet").write_bytes(b"PAR1")
    assert imported(made, *FORCES) == 3
    assert "chunk-000/file-001.parquet: cannot be read" in capsys.readouterr().err


def test_a_set_without_its_info_is_called_one(tmp_path: Path, capsys) -> None:
    made = write_set(tmp_path / "set")
    (made / "meta/info.json").unlink()
    assert imported(made, *FORCES) == 3
    assert "lacks meta/info.json" in capsys.readouterr().err


def test_a_set_of_which_only_the_description_was_fetched_is_called_one(tmp_path: Path, capsys) -> None:
    made = write_set(tmp_path / "set")
    (made / "data").rename(tmp_path / "elsewhere")
    assert imported(made, *FORCES) == 3
    assert "there is no data/chunk-*/*.parquet" in capsys.readouterr().err


def test_a_set_without_a_row_is_refused_for_that(tmp_path: Path, capsys) -> None:
    made = write_set(tmp_path / "set")
    for file in (made / "data").rglob("*.parquet"):
        pq.write_table(pq.read_table(file).slice(0, 0), file)
    assert imported(made, *FORCES) == 3
    assert "there is no row in its" in capsys.readouterr().err


def test_two_fingers_in_one_file_are_two_recordings(tmp_path: Path) -> None:
    np.savez(
        tmp_path / "two.npz", timestamps=T, **{"left/normal_force": PRESS, "right/normal_force": 2 * PRESS}
    )
    assert imported(tmp_path / "two.npz") == 0
    left, right = (read_recording(tmp_path / "rec" / finger) for finger in ("left", "right"))
    assert left.columns["normal_force"] == pytest.approx(PRESS)
    assert right.columns["normal_force"] == pytest.approx(2 * PRESS)


def test_a_finger_named_to_lead_out_of_the_folder_does_not(tmp_path: Path) -> None:
    names = {"observation.tactile.../up.normal_force": PRESS, "observation.tactile.b.normal_force": PRESS}
    np.savez(tmp_path / "two.npz", timestamps=T, **names)
    assert imported(tmp_path / "two.npz") == 0
    assert {one.parent.parent for one in tmp_path.rglob("recording.toml")} == {tmp_path / "rec"}


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"normal_force": PRESS + 0j}, "is complex"),
        ({"normal_force": PRESS.astype("S8")}, "no plain number"),
        ({"normal_force": np.array([{}] * 60)}, "no .npz file of plain numbers"),
        ({"normal_force": np.ones((60, 2, 2, 2))}, "has the shape (60, 2, 2, 2); (T, N) is needed"),
        ({"normal_force": np.ones((60, 4)), "shear_force": np.ones((60, 4, 3))}, "(T, N, 2) is needed"),
        ({"wrench": np.ones((60, 3))}, "(T, 6) is needed"),
        ({"normal_force": np.ones(50)}, "differ in length: timestamp 60, normal_force 50"),
        ({"normal_force": PRESS, "tactile/normal_force": PRESS, "/normal_force": PRESS}, "there twice"),
        ({"depth": PRESS}, "there is no touch by its name"),
    ],
)
def test_arrays_that_are_no_touch_are_refused_in_a_sentence(tmp_path, capsys, arrays, said: str) -> None:
    np.savez(tmp_path / "x.npz", timestamps=T, **arrays)
    assert imported(tmp_path / "x.npz") == 3
    error = capsys.readouterr().err
    assert said in error
    assert len(error.splitlines()) == 1


def test_holes_and_bad_times_of_a_file_are_counted(tmp_path: Path, capsys) -> None:
    t, force = T.copy(), np.stack([PRESS, PRESS], axis=1)
    t[10], t[20] = np.nan, t[19]
    force[30:33, 1] = np.nan
    np.savez(tmp_path / "x.npz", timestamps=t, normal_force=force)
    assert imported(tmp_path / "x.npz", "--json") == 0
    out = capsys.readouterr()
    told = json.loads(out.out)
    assert (told["rows"]["in"], told["rows"]["used"]) == (60, 58)
    assert {name: one["count"] for name, one in told["rows"]["left_out"].items()} == {
        "no_time": 1, "duplicate": 1,
    }  # fmt: skip
    findings = {one["kind"]: one["count"] for one in told["recordings"][0]["report"]["findings"]}
    assert findings["missing"] == 3
    assert "normal_force has no value in 3 of 58 rows" in out.err


def test_times_of_a_file_in_ms_are_asked_about(tmp_path: Path, capsys) -> None:
    np.savez(tmp_path / "x.npz", timestamps=1e3 * T, normal_force=PRESS)
    assert imported(tmp_path / "x.npz") == 3
    assert "advances by 50 s a row; say its unit" in capsys.readouterr().err
    assert imported(tmp_path / "x.npz", "--unit", "t=ms") == 0
    assert read_recording(tmp_path / "rec").duration == pytest.approx(T[-1])


def test_demonstrations_in_hdf5_are_episodes(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "x.h5", "w") as file:
        for number in range(11):  # as tactile-data-toolkit and robomimic lay them out
            demo = file.create_group(f"data/demo_{number}")
            demo["timestamps"] = T
            force = demo.create_dataset("obs/tactile_normal_force", data=np.full((60, 4), 0.1 * number))
            force.attrs["schema_path"] = "/observation/tactile/normal_force"
            demo["obs/raw_image"] = np.zeros((60, 2, 2, 3), np.uint8)
    assert imported(tmp_path / "x.h5") == 0
    back = read_recording(tmp_path / "rec")
    assert back.columns["normal_force"][::60] == pytest.approx(0.4 * np.arange(11))
    assert back.episode[::60].tolist() == list(range(11))


def test_arrays_at_the_root_of_hdf5_are_read_by_a_map(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "x.hdf5", "w") as file:
        file["clock_ms"], file["glove/force"] = 1e3 * T, np.stack([PRESS, 3 * PRESS], axis=1)
    options = ["--map", "t=clock_ms", "--unit", "t=ms", "--map", "normal_force=glove/force[1]"]
    assert imported(tmp_path / "x.hdf5", *options) == 0
    back = read_recording(tmp_path / "rec")
    assert back.columns["normal_force"] == pytest.approx(3 * PRESS)
    assert back.duration == pytest.approx(T[-1])


@pytest.mark.parametrize("name", ["normal_force", "/observation/tactile/normal_force"])
def test_a_map_may_call_an_array_what_the_file_calls_it(tmp_path: Path, name: str) -> None:
    np.savez(tmp_path / "x.npz", timestamps=T, normal_force=PRESS)
    assert imported(tmp_path / "x.npz", "--map", f"normal_force={name}", "--map", "t=timestamps") == 0
    back = read_recording(tmp_path / "rec")
    assert back.columns["normal_force"] == pytest.approx(PRESS)
    assert back.source["map"] == "command line"


def test_a_remedy_names_the_option_where_there_is_no_map(tmp_path: Path, capsys) -> None:
    np.savez(tmp_path / "x.npz", timestamps=T, glove=PRESS)
    options = ["--map", "normal_force=glove", "--zero", "normal_force=baseline"]
    assert imported(tmp_path / "x.npz", *options) == 3
    assert "give --baseline SECONDS" in capsys.readouterr().err


def test_what_is_not_read_is_said_in_a_sentence(tmp_path: Path, capsys, monkeypatch) -> None:
    (tmp_path / "x.h5").write_bytes(b"\x89HDF\r\n\x1a\n cut")
    assert imported(tmp_path / "x.h5") == 3
    assert "no HDF5 file that can be read" in capsys.readouterr().err
    (tmp_path / "arrays").mkdir()
    (tmp_path / "arrays/zarr.json").write_text("{}")
    assert imported(tmp_path / "arrays") == 3
    assert "is Zarr, which is not read" in capsys.readouterr().err
    monkeypatch.setitem(__import__("sys").modules, "h5py", None)
    assert imported(tmp_path / "x.h5") == 2
    assert "needs the library h5py (h5py is missing): pip install 'vegrip[hdf5]'" in capsys.readouterr().err
    assert imported(tmp_path / "x.h5", "--delimiter", ";") == 2


def test_the_column_of_the_trials_is_the_one_that_is_asked_for(tmp_path: Path, capsys) -> None:
    """Before, it was left out without a word where it had another name than ``episode_index``."""
    np.savez(tmp_path / "x.npz", timestamps=T, normal_force=PRESS, trial=np.arange(T.size) // (T.size // 2))
    mapped = ("--map", "normal_force=normal_force", "--map")
    assert imported(tmp_path / "x.npz", *mapped, "episode=trial") == 0
    assert np.unique(read_recording(tmp_path / "rec").episode).tolist() == [0, 1]
    assert imported(tmp_path / "x.npz", "--force", *mapped, "episode=tria") == 3
    assert "there is no column 'tria'" in capsys.readouterr().err
