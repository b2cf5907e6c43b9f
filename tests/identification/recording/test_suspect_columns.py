"""Columns that are exchanged, of the wrong sign or of another unit are suspected; sound ones are not."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vegrip.cli.fit import opened
from vegrip.identification.recording import Fingertip, Kind, Recording, write_recording
from vegrip.identification.recording.checks import suspect_columns
from vegrip.identification.recording.column_map import BaselineMap, ChannelMap, ColumnMap, with_columns
from vegrip.identification.recording.import_csv import import_csv
from vegrip.identification.samples import recording
from vegrip.types import Floats

RADIUS = 8e-3  # [m]
Press = tuple[Floats, Floats]


def measured() -> Press:
    sample = recording()
    return sample.columns["displacement"], sample.columns["normal_force"]


def pressed(
    share_lost: float = 0.2, creep: float = 0.0, pull: float = 0.0, lag: int = 0, noise: float = 0.0
) -> Press:
    """Return approach, press, hold and release of a contact whose force falls while it is held.

    With ``creep`` the force is held instead and the depth grows by that share; ``pull`` [N] of adhesion at
    the release; the force ``lag`` rows late.
    """
    up, held = np.linspace(-0.3, 1.0, 400), np.ones(1000)
    grown = 1.0 + creep * (1.0 - np.exp(-np.linspace(0.0, 5.0, 1000)))
    down = np.linspace(grown[-1], -0.3, 400)
    kept = 1.0 - share_lost * (1.0 - np.exp(-np.linspace(0.0, 5.0, 1000)))
    depth = np.concatenate([up, grown if creep else held, down])
    force = np.concatenate([np.maximum(up, 0.0) ** 1.5, held if creep else kept])
    release = np.maximum(down / grown[-1], 0.0) ** 1.5 * (1.0 - share_lost) - pull * (
        (down < 0.1) & (down > -0.05)
    )
    force = np.roll(np.concatenate([force, release]), lag)
    scatter = np.random.default_rng(4).normal(0.0, noise, (2, depth.size))
    return 1e-3 * (depth + scatter[0]), 3.0 * (force + scatter[1])


SOUND: dict[str, Callable[[], Press]] = {
    "measured": measured,
    "pressed": pressed,
    "noisy": lambda: pressed(noise=0.02),
    "crept": lambda: pressed(0.1, creep=0.4),
    "sticky": lambda: pressed(pull=0.4),
    "elastic": lambda: pressed(share_lost=0.0),
    "late": lambda: pressed(0.2, lag=15),
}


def told(depth: Floats, force: Floats, radius: float = RADIUS) -> str:
    columns = {"displacement": depth, "normal_force": force}
    return "; ".join(suspect_columns(np.zeros(depth.size, dtype=np.int64), columns, radius))


@pytest.mark.parametrize("name", SOUND)
def test_a_sound_recording_is_not_suspected(name: str) -> None:
    assert told(*SOUND[name]()) == ""


@pytest.mark.parametrize("name", ["measured", "pressed", "noisy", "sticky"])
def test_exchanged_columns_are_suspected_whatever_their_units(name: str) -> None:
    depth, force = SOUND[name]()
    assert "exchange their columns in --map" in told(1e-3 * force, 1e3 * depth)
    assert "exchange their columns in --map" in told(force, depth)


@pytest.mark.parametrize("name", SOUND)
def test_a_wrong_sign_is_told_with_the_option_that_turns_it(name: str) -> None:
    depth, force = SOUND[name]()
    assert told(depth, -force).endswith(
        "has the wrong sign (compression and indentation are positive); import with --negate normal_force"
    )
    assert told(-depth, force).endswith("--negate displacement")
    if name != "sticky":  # whose force goes to both sides
        assert told(-depth, -force).endswith("--negate normal_force --negate displacement")


def test_a_stiffness_that_nothing_has_is_told() -> None:
    depth, force = pressed()
    assert "the stiffness cannot be" in told(1e-3 * depth, 1e3 * force)
    assert "the stiffness cannot be" in told(30.0 * depth, 1e-4 * force)
    assert told(1e-3 * depth, 1e3 * force, radius=np.nan) == ""


def slid(unit: float) -> str:
    """Return what is said of the sample, its normal force in another unit."""
    sample = recording()
    columns = sample.columns | {"normal_force": unit * sample.columns["normal_force"]}
    return "; ".join(suspect_columns(sample.episode, columns, RADIUS))


@pytest.mark.parametrize("unit", [1e-3, 102.0, 1e3])
def test_a_friction_that_nothing_has_is_told(unit: float) -> None:
    assert "the friction cannot be" in slid(unit)
    assert slid(1.0) == ""


@pytest.mark.parametrize(
    ("channel", "unit"),
    [(c, u) for c in ("normal_force", "displacement", "t") for u in (1e-3, 1e3)] + [("normal_force", 1.0)],
)
def test_a_unit_that_is_off_by_a_thousand_is_asked_about_without_a_slip(
    tmp_path: Path, channel: str, unit: float
) -> None:
    depth, force = measured()
    columns = {"t": recording().t, "displacement": depth, "normal_force": force}
    columns[channel] = unit * columns[channel]
    rows = "".join(
        f"{t!r},{d!r},{f!r}\n" for t, d, f in zip(*map(np.ndarray.tolist, columns.values()), strict=True)
    )
    (tmp_path / "a.csv").write_text("t,displacement,normal_force\n" + rows)
    told = import_csv(tmp_path / "a.csv", radius=RADIUS).report
    assert any(f.kind in (Kind.SUSPECT, Kind.IMPLAUSIBLE) for f in told.findings) == (unit != 1.0)


def test_both_signs_wrong_are_no_travel_of_a_rig(tmp_path: Path) -> None:
    depth, force = measured()
    rows = "".join(
        f"{i / 100},{-d!r},{-f!r}\n"
        for i, (d, f) in enumerate(zip(depth.tolist(), force.tolist(), strict=True))
    )
    (tmp_path / "a.csv").write_text("t,displacement,normal_force\n" + rows)
    told = [
        f.what
        for f in import_csv(tmp_path / "a.csv", radius=RADIUS).report.findings
        if f.kind is Kind.SUSPECT
    ]
    assert len(told) == 1
    assert "both have the wrong sign" in told[0]


@pytest.mark.parametrize(("least", "is_told"), [(-1.0, False), (0.3, True)])
def test_a_recording_without_air_is_told_so_before_a_fit(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, least: float, is_told: bool
) -> None:
    depth, force = pressed()
    rows = depth > least * depth.max()
    columns = {"displacement": depth[rows], "normal_force": force[rows]}
    t = np.arange(rows.sum()) / 100.0
    some = Recording("grip", t, np.zeros(t.size, dtype=np.int64), columns, Fingertip(RADIUS), {})
    write_recording(some, tmp_path / "grip")
    opened(tmp_path / "grip", None)
    assert ("never in the air" in caplog.text) == is_told


@pytest.mark.parametrize("rows", [0, 1, 49])
def test_of_a_few_rows_nothing_is_said(rows: int) -> None:
    depth, force = pressed()
    assert told(depth[400 : 400 + rows], -force[400 : 400 + rows]) == ""
    assert told(np.zeros(99), np.zeros(99)) == ""
    assert told(np.full(99, np.nan), np.arange(99.0)) == ""


def test_the_command_turns_the_sign(tmp_path: Path) -> None:
    depth, force = pressed()
    rows = "".join(f"{i / 100},{1e3 * d},{-f}\n" for i, (d, f) in enumerate(zip(depth, force, strict=True)))
    (tmp_path / "a.csv").write_text("t,depth_mm,normal_force\n" + rows)
    said = (["displacement=depth_mm"], ["displacement=mm"])
    wrong = import_csv(tmp_path / "a.csv", with_columns(ColumnMap(), *said), radius=RADIUS)
    right = import_csv(tmp_path / "a.csv", with_columns(ColumnMap(), *said, ["normal_force"]), radius=RADIUS)
    assert [one.kind for one in wrong.report.findings if one.kind is Kind.SUSPECT]
    assert not [one.kind for one in right.report.findings if one.kind is Kind.SUSPECT]
    np.testing.assert_allclose(right.columns["normal_force"], force)


def test_an_empty_column_is_told_and_left_out(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,normal_force,displacement\n0,,1\n1,nan,2\n")
    found = import_csv(tmp_path / "a.csv")
    assert list(found.columns) == ["displacement"]
    assert "normal_force holds no number: the column 'normal_force' is empty" in found.report.summary()


def travelled(tmp_path: Path, offset: float, name: str = "displacement", scale: float = 1.0) -> Path:
    """Write two trials whose displacement [m] begins at ``offset``, and whose force rests at 0.35 N."""
    depth, force = pressed(noise=1e-3)
    lines = [
        f"{1e-2 * i},{scale * (d + offset)},{f + 0.35},{trial}"
        for trial in ("a", "b")
        for i, (d, f) in enumerate(zip(depth, force, strict=True))
    ]
    path = tmp_path / "rig.csv"
    path.write_text("\n".join([f"t,{name},normal_force,trial", *lines, ""]))
    return path


def test_the_travel_of_a_rig_is_no_indentation_and_the_option_that_is_told_makes_it_one(
    tmp_path: Path,
) -> None:
    chart = with_columns(ColumnMap(), ["episode=trial"], [])
    for offset in (-3e-3, 2.4e-3):
        said = import_csv(travelled(tmp_path, offset), chart, radius=RADIUS).report.summary()
        assert "--zero displacement=contact --zero normal_force=baseline --baseline 0.5" in said
    zeros = ["displacement=contact", "normal_force=baseline"]
    chart = with_columns(ColumnMap(baseline=BaselineMap(0.5)), ["episode=trial"], [], [], zeros)
    right = import_csv(travelled(tmp_path, 2.4e-3), chart, radius=RADIUS)
    assert Kind.SUSPECT not in {one.kind for one in right.report.findings}
    depth, force = pressed(noise=1e-3)
    np.testing.assert_allclose(right.columns["normal_force"], np.tile(force, 2), atol=2e-3)
    np.testing.assert_allclose(right.columns["displacement"], np.tile(depth, 2), atol=4e-5)
    stated = ColumnMap({"displacement": ChannelMap("displacement", offset=-1e-5)})  # where the zero is
    chart = with_columns(stated, ["episode=trial"], [])
    assert "travel" not in import_csv(travelled(tmp_path, 2.4e-3), chart, radius=RADIUS).report.summary()
    near = import_csv(travelled(tmp_path, 0.2e-3), with_columns(ColumnMap(), ["episode=trial"], []))
    assert Kind.SUSPECT not in {one.kind for one in near.report.findings}  # a fit finds it


def test_trials_that_lie_over_each_other_are_told(tmp_path: Path) -> None:
    path = travelled(tmp_path, 0.0)
    assert "the time begins anew 1 x" in import_csv(path).report.summary()
    chart = with_columns(ColumnMap(), ["episode=trial"], [])
    assert "begins anew 1 x" not in import_csv(path, chart).report.summary()


@pytest.mark.parametrize("name", ["Weg [mm]", "depth (mm)", "z  [ mm ]"])
def test_a_unit_in_the_name_of_a_column_counts_unless_another_is_said(tmp_path: Path, name: str) -> None:
    path = travelled(tmp_path, 0.0, name, 1e3)
    mapped = [f"displacement={name}", "episode=trial"]
    found = import_csv(path, with_columns(ColumnMap(), mapped, []))
    np.testing.assert_allclose(found.columns["displacement"], np.tile(pressed(noise=1e-3)[0], 2))
    assert "displacement in mm" in found.report.summary()
    other = import_csv(path, with_columns(ColumnMap(), mapped, ["displacement=um"]))
    np.testing.assert_allclose(other.columns["displacement"], 1e-3 * np.tile(pressed(noise=1e-3)[0], 2))


def test_a_remark_in_the_name_of_a_column_is_no_unit(tmp_path: Path) -> None:
    path = travelled(tmp_path, 0.0, "depth (left)")
    found = import_csv(path, with_columns(ColumnMap(), ["displacement=depth (left)", "episode=trial"], []))
    np.testing.assert_allclose(found.columns["displacement"], np.tile(pressed(noise=1e-3)[0], 2))
