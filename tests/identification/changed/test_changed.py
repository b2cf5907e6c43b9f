"""What is said of two recordings between which a known thing changed, and of some that do not overlap."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from validation.changed_pairs import Pair, made
from validation.measured.cases import data_folder
from vegrip.effects import effect
from vegrip.errors import RecordingError, UsageError
from vegrip.identification import samples
from vegrip.identification.changed import Changed, changed
from vegrip.identification.fit import fit
from vegrip.identification.recording import Recording
from vegrip.identification.recording.column_map import read_column_map
from vegrip.identification.recording.import_csv import import_csv
from vegrip.identification.samples import LATER_TABLE
from vegrip.identification.samples import recording as sample
from vegrip.model import ContactModel, paper_model

SHORT = ("short", "short")


def recorded(seed: int, **truth: float) -> tuple[Recording, Recording]:
    return made(Pair(seed, SHORT, truth))


def without_slips(one: Recording) -> Recording:
    """Return the presses alone, as a rig that cannot pull records them."""
    kept = {name: one.columns[name] for name in ("displacement", "normal_force")}
    slips = {number for number in np.unique(one.episode) if one.columns["slip"][one.episode == number].any()}
    return replace(one, columns=kept).select(~np.isin(one.episode, list(slips)))


def simulated(like: Recording, law: ContactModel, seed: int) -> Recording:
    """Return what ``law`` presses with in the motions of another recording, with noise of 10 mN."""
    t, depth = like.t, like.columns["displacement"]
    episodes = (like.episode == number for number in np.unique(like.episode))
    force = np.concatenate([law.simulate(t[rows], depth[rows]).sensed_force for rows in episodes])
    noise = 0.01 * np.random.default_rng(seed).standard_normal(t.size)
    return replace(like, columns={"displacement": depth, "normal_force": force + noise})


def sample_law() -> ContactModel:
    law = paper_model(samples.SAMPLE_RADIUS_M).with_value("K", 1.287)
    return law.with_value("c1", 0.25).with_value("nu1", 2.0)


def names(found: Changed) -> list[str]:
    return [one.name for one in found.changes]


def test_where_nothing_changed_nothing_is_said_to_have() -> None:
    found = changed(*recorded(11))
    assert (found.verdict, names(found)) == ("nothing", [])
    assert found.sentence == "index: nothing changed"
    least = {one.name: max(map(abs, one.interval)) for one in found.unchanged}
    assert least["K"] < 1.0  # [%]: the word is worth something only where a change would have shown


@pytest.mark.long
def test_a_softer_pad_is_named_and_to_exchange_the_recordings_inverts_the_change() -> None:
    first, second = recorded(12, K=math.log(0.93))
    there, back = changed(first, second), changed(second, first)
    for found, true in ((there, -7.0), (back, 100.0 / 0.93 - 100.0)):
        assert (found.verdict, names(found)) == ("named", ["K"])
        low, high = found.changes[0].interval
        assert low < true < high
        assert found.changes[0].p < 1e-6
    assert there.changes[0].percent is not None
    assert back.changes[0].percent is not None
    assert (1.0 + there.changes[0].percent / 100.0) * (
        1.0 + back.changes[0].percent / 100.0
    ) == pytest.approx(1.0, abs=1e-3)
    assert "softer" in there.sentence
    assert "stiffer" in back.sentence


@pytest.mark.long
def test_a_slip_tells_a_gain_of_the_force_sensor_from_a_stiffness_and_without_one_they_are_a_set() -> None:
    first, second = recorded(12, gain_normal_force=math.log(1.06))
    found = changed(first, second)
    assert (found.verdict, names(found)) == ("named", ["gain_normal_force"])
    found = changed(without_slips(first), without_slips(second))
    assert found.verdict == "ambiguous"
    assert found.indistinguishable == [["K", "gain_normal_force"]]
    assert found.experiment[0]["advice"].startswith("lay a known weight on the tip")
    for one in found.changes:
        assert one.interval[0] < 6.0 < one.interval[1]


@pytest.mark.long
def test_what_one_recording_alone_shows_is_not_compared() -> None:
    first, second = recorded(11)
    blind = replace(first, columns={n: one for n, one in first.columns.items() if n != "contact_radius"})
    for one, is_asked in ((first, True), (blind, False)):
        found = changed(one, second)
        compared = {each.name for each in (*found.changes, *found.unchanged)}
        assert ("gain_contact_radius" in compared) is is_asked
        assert (
            any("not compared" in said and "contact radius" in said for said in found.remarks) is not is_asked
        )


@pytest.mark.long
def test_two_changes_are_both_named_with_their_intervals() -> None:
    truth = {"mu": math.log(0.9), "zero_normal_force": 0.012}
    found = changed(*recorded(13, **truth))
    assert (found.verdict, set(names(found))) == ("named", set(truth))
    by_name = {one.name: one for one in found.changes}
    assert by_name["mu"].interval[0] < -10.0 < by_name["mu"].interval[1]
    assert by_name["zero_normal_force"].interval[0] < 0.012 < by_name["zero_normal_force"].interval[1]
    assert by_name["zero_normal_force"].percent is None


@pytest.mark.long
def test_what_the_first_lacks_is_added_for_both_and_stays_in_newtons_on_a_softer_pad(tmp_path: Path) -> None:
    found = changed(sample(), sample(LATER_TABLE))  # with adhesion in both: 11 % softer, a zero of 14 mN
    assert (found.verdict, names(found)) == ("named", ["K", "zero_normal_force"])
    assert {"adhesion"} <= {one.name for one in found.pair.second.model.effects}
    low, high = found.changes[0].interval
    assert low < -11.0 < high
    found.plot().savefig(tmp_path / "changed.png")
    assert (tmp_path / "changed.png").stat().st_size > 10_000


@pytest.mark.long
def test_an_effect_that_only_the_second_shows_is_new() -> None:
    pressed = without_slips(sample())
    clean = simulated(pressed, sample_law(), 3)
    found = changed(clean, pressed)
    assert found.verdict == "new_effect"
    assert found.new_effects == ("adhesion",)
    assert "adhesion in the second only" in found.sentence


def test_an_amount_that_one_recording_lacks_is_compared_both_ways_and_one_that_both_lack_is_not() -> None:
    law = sample_law().with_effect(effect("adhesion"))
    shown, gone, none = (
        simulated(without_slips(sample()), law.with_value("pull", pull), seed)
        for seed, pull in enumerate((0.04, 0.0, 0.0))
    )
    lost, gained = changed(shown, gone, law), changed(gone, shown, law)
    for found in (lost, gained):
        assert (found.verdict, names(found)) == ("named", ["pull"])
        assert min(found.changes[0].before, found.changes[0].after) == pytest.approx(0.0, abs=1e-3)
        largest = max(found.changes[0].before, found.changes[0].after)
        assert largest == pytest.approx(0.04 * 1.287, abs=3e-3)
        assert found.changes[0].unit == "N"
        assert {one.name for one in found.unchanged} >= {"K", "p", "c1", "nu1", "gain_normal_force"}
    assert gained.changes[0].percent is None
    assert "pull of adhesion +51 mN (+5" in gained.sentence  # of nothing it is no percentage
    least, most = lost.changes[0].interval
    assert least == -100.0 < most < -95.0  # [%]: no less than nothing, and no interval of nothing
    assert any("not compared" in said and "pull" in said for said in changed(gone, none, law).remarks)


def test_an_amount_of_either_sign_that_was_not_told_from_nothing_changes_by_newtons_per_metre() -> None:
    law = sample_law().with_effect(effect("approach_tilt"))
    none, tilted = (
        simulated(without_slips(sample()), law.with_value("b_h", slope), seed)
        for seed, slope in enumerate((1e-6, 0.05))
    )
    found = changed(none, tilted, law)
    assert [said.split(":")[0] for said in found.doubts] == [
        "the first",
        "the second",
    ]  # not twice their name
    (change,) = found.changes
    assert (change.name, change.percent, change.unit) == ("b_h", None, "N/m")
    assert change.interval[0] < 0.05 * 1.287 / law.reference_depth < change.interval[1]


def test_recordings_that_do_not_overlap_are_refused_with_what_each_shows() -> None:
    first, second = (without_slips(one) for one in recorded(11))
    slow = replace(second, t=40.0 * second.t)
    with pytest.raises(RecordingError, match=r"do not overlap: .* mm/s, .* um/s; .*the motion of the first"):
        changed(first, slow)


def test_what_is_no_recording_and_what_has_no_rows_is_refused_in_a_sentence() -> None:
    first = without_slips(sample())
    with pytest.raises(UsageError, match="give a Recording, not a Fit"):
        changed(first, fit(first))  # type: ignore[arg-type]
    with pytest.raises(RecordingError, match="has no episode"):
        changed(first, first.select(np.zeros(len(first), dtype=bool)))
    with pytest.raises(RecordingError, match="only one is of a material"):
        changed(first, replace(first, source={"material": "relaxation"}))
    calm = replace(first, columns={**first.columns, "normal_force": 1e-3 * np.sin(1e3 * first.t)})
    with pytest.raises(RecordingError, match="without contact"):
        changed(first, calm)


@pytest.mark.long
@pytest.mark.skipif(not data_folder().is_dir(), reason="the measured recordings are no part of the project")
def test_levels_of_calcium_are_in_order() -> None:
    chart = read_column_map(Path(samples.__file__).parent / samples.MUSCLE / "map.toml")
    folder = data_folder() / "muscle-stretch"
    levels = [
        import_csv(folder / f"AvgpCa{level}_0.1s.csv", chart) for level in ("6.25", "6", "5.75", "5.5", "4.4")
    ]
    found = [changed(levels[0], one, tolerance=0.02) for one in levels[1:]]
    stiffer = [
        next(float(change.percent or 0.0) for change in (*one.changes, *one.unchanged) if change.name == "K")
        for one in found
    ]
    assert stiffer == sorted(stiffer)
    assert found[0].verdict == "nothing"
    for one in found[1:]:
        assert ["K", "gain_normal_force"] in one.indistinguishable  # no weight was laid on, and nothing slips
