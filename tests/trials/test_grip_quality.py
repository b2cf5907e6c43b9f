"""The least possible force is the least by brute force, and the figures are those of the rows."""

import json
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binom

from vegrip.cli import main
from vegrip.trials.closed_loop import GRASPS, Course, Scenario
from vegrip.trials.fronts import (
    CLASSES,
    FLAG,
    SPEED,
    GripRecord,
    QualityTrial,
    Surroundings,
    classes_of,
    clopper_pearson,
    figures_of,
    force_over_least,
    least_forces,
    record_of,
    record_trial,
    run_quality_trial,
    wrong_slip,
)
from vegrip.trials.known_contact import KnownContact
from vegrip.virtual import HandSettings
from vegrip.virtual.disturbance import Push, Twist, Wetting
from vegrip.virtual.fingertip import even_grid, utilisation


@pytest.fixture(scope="module")
def pinch() -> Course:
    """A constant grip in a pinch, where force and torque both load the contacts."""
    return run_quality_trial(QualityTrial("constant", 3, 4.0, 8.0, "pinch"))


@pytest.fixture(scope="module")
def steep() -> Course:
    """The same where friction falls with the force; the seed's exponent is large."""
    return run_quality_trial(QualityTrial("constant", 6, 4.0, 8.0, "pinch", world="published"))


def scanned(
    now: float, tangential: float, torque: float, mu: float, radius: float, k: float, g: float = 0.0
) -> float:
    """Return the least force by trying forces on a fine patch of elements, without any limit surface."""
    grid = even_grid(24, 48)
    for force in np.geomspace(0.02, 20.0, 1500):
        a = radius * (force / now) ** (1.0 / 3.0)
        limit = mu * (force / now) ** -g * force
        if utilisation(grid, k, tangential / limit, torque / (limit * a)) <= 1.0:
            return float(force)
    return math.inf


def test_the_least_possible_force_is_the_least_that_holds_when_forces_are_tried_one_by_one(
    pinch: Course,
) -> None:
    least = least_forces(pinch)
    for row in (150, 250, 380):
        for finger in (0, 1):
            tried = scanned(pinch.force[row][finger], *pinch.contact[row][finger])
            assert least[row, finger] == pytest.approx(tried, rel=0.01)


def test_the_least_possible_force_is_that_of_friction_that_falls_with_the_force(steep: Course) -> None:
    assert steep.friction_exponent > 0.2
    least = least_forces(steep)
    for row in (150, 250, 380):
        for finger in (0, 1):
            contact = steep.contact[row][finger]
            tried = scanned(steep.force[row][finger], *contact, steep.friction_exponent)
            assert least[row, finger] == pytest.approx(tried, rel=0.01)
            assert least[row, finger] < 0.9 * scanned(steep.force[row][finger], *contact)


def test_what_knows_the_contact_asks_for_the_least_force_of_friction_that_falls_with_the_force() -> None:
    hand = Scenario(6, 4.0, "pinch", "published").hand()
    hand.step(2.0, {"thumb": 6.0, "index": 6.0})
    now, mu, radius, k = hand.contact(1)
    load, g = (0.9, 2e-3), hand.settings.tip.friction_exponent
    asked = KnownContact(hand, "index").least_force(0.2, 0.95, load)
    assert asked == pytest.approx(scanned(now, *load, 0.8 * mu, radius, k, g), rel=0.01)


def test_a_grip_never_holds_with_less_than_the_least_possible_force(pinch: Course) -> None:
    settled = np.array(pinch.time) > 1.0
    assert np.all((least_forces(pinch) < np.array(pinch.force))[settled])
    assert pinch.slips == 0


def test_without_load_nothing_is_needed(pinch: Course) -> None:
    assert np.all(least_forces(pinch)[np.array(pinch.time) < 0.05] < 0.01)


def test_what_was_never_held_has_no_ratio() -> None:
    assert math.isnan(force_over_least(Course(("thumb",), dropped=True), 1.0))


def record(**changes: object) -> GripRecord:
    """Return four rows, one of the lift and three of a held object."""
    rows = {
        "slips": 0, "dropped": False, "largest_micro_slip": 2e-5,
        "force": np.array([9.0, 2.0, 4.0, 6.0]), "least": np.array([1.0, 1.0, 2.0, 3.0]),
        "margin": np.array([0.9, 0.5, 0.01, 0.4]), "slipped": np.zeros(4),
        "classes": np.array([5, 0, 3, 3]), "settled": np.array([False, True, True, True]),
        "friction_error": np.array([[9.0, 9.0], [1.9, -3.0], [np.nan, 0.1], [0.2, 0.3]]),
        "friction_std": np.array([[1.0, 1.0], [0.2, 0.1], [np.nan, 0.3], [0.4, 0.5]]),
    }  # fmt: skip
    return GripRecord(**{**rows, **changes})  # type: ignore[arg-type]


def test_friction_is_inside_its_interval_where_the_error_is_below_two_deviations() -> None:
    """Of what is held: the lift does not count, nor a finger in the air."""
    figures = figures_of([record()], 0.01)
    assert figures["friction_inside"] == pytest.approx(4 / 5)
    assert figures["friction_std"] == pytest.approx(0.3)
    assert figures["by_class"]["static"]["friction_inside"] == pytest.approx(0.5)
    assert np.isnan(figures["by_class"]["wet"]["friction_inside"])


@pytest.mark.long
def test_the_true_friction_lies_inside_the_stated_interval_though_faces_get_wet_and_dry_unseen() -> None:
    trials = [QualityTrial("learning", seed, 10.0, 0.1, "hand") for seed in range(100, 110)]
    figures = figures_of([record_trial(trial) for trial in trials], 0.01)
    assert figures["friction_inside"] > 0.85  # 0.89 of 150 trials
    assert figures["by_class"]["wet"]["friction_inside"] > 0.8
    assert figures["friction_std"] < 0.25


def test_faces_that_go_on_getting_wet_after_a_slide_drop_nothing() -> None:
    """Both flags then told of a second slide, far below what had just been held, and were not believed."""
    assert not run_quality_trial(
        QualityTrial("learning", 13118, 10.0, 0.1, "pinch", world="published")
    ).dropped


def test_what_is_stated_of_friction_is_the_apparent_one() -> None:
    course = run_quality_trial(QualityTrial("vegrip", 3, 2.0, 0.15, "pinch"))
    plain, gained = (record_of(course, (), 0.3, gain) for gain in (1.0, 0.8))
    off = (gained.friction_error - plain.friction_error) * plain.friction_std
    assert np.nanmax(np.abs(off + math.log(0.8))) < 1e-12


def test_figures_count_what_is_held_and_slips_from_the_start() -> None:
    figures = figures_of([record(), record(slips=2, slipped=np.array([1.0, 0.0, 1.0, 0.0]))], 0.01)
    assert figures["mean_force"] == 4.0
    assert figures["force_over_least"] == pytest.approx(2.0)
    assert figures["time_below_002"] == pytest.approx(0.01)
    assert (figures["slips"], figures["trials_with_slip"]) == (2, 1)
    assert figures["by_class"]["torsion"]["slips"] == 1
    assert figures["by_class"]["lift"]["slips"] == 1
    assert figures["by_class"]["static"]["force_over_least"] == pytest.approx(2.0)


def test_the_worst_kind_of_disturbance_that_acts_names_the_instant() -> None:
    events = (Push(2.0, 1.0, 1.0, 0.0), Twist(2.5, 1.0, 0.1), Wetting(3.4, 1.0, 0.5))
    found = classes_of(np.array([1.0, 1.9, 2.2, 2.7, 3.2, 3.45]), events)
    assert [CLASSES[i] for i in found] == ["lift", "static", "shock", "torsion", "torsion", "wet"]


@pytest.mark.parametrize(("hits", "trials"), [(0, 50), (1, 50), (7, 20), (20, 20)])
def test_the_interval_of_slips_is_where_the_binomial_tails_are_a_fortieth(hits: int, trials: int) -> None:
    low, high = clopper_pearson(hits, trials)
    if hits > 0:
        assert binom.sf(hits - 1, trials, low) == pytest.approx(0.025)
    if hits < trials:
        assert binom.cdf(hits, trials, high) == pytest.approx(0.025)
    assert (low == 0.0) == (hits == 0)


def test_fifty_trials_without_a_slip_bound_its_chance_below_a_fourteenth() -> None:
    assert clopper_pearson(0, 50)[1] == pytest.approx(0.0711, abs=1e-4)


def test_quicker_drives_and_rougher_surfaces_are_what_they_say() -> None:
    hand = QualityTrial("constant", 0, 3.0, 8.0, "pinch").surroundings.applied
    usual, other = hand(_hand()), Surroundings(24.0, 2.0, slip_channel="absent").applied(_hand())
    assert other.actuator.bandwidth == 2.0 * usual.actuator.bandwidth
    assert other.actuator.force_rate == 2.0 * usual.actuator.force_rate
    assert other.tip.friction == 2.0 * usual.tip.friction
    steep = replace(_hand(), tip=replace(_hand().tip, friction_exponent=0.2))
    assert Surroundings(friction_scale=2.0).applied(steep).tip.friction_exponent == 0.2
    assert usual.sensor.slip_sensor
    assert not other.sensor.slip_sensor


def test_a_dead_slip_channel_tells_of_no_slide_and_a_stuck_or_noisy_one_of_slides_that_are_not() -> None:
    """Seen by a controller that believes them all: it raises the grip by what it feels."""

    def run(channel: str, friction: float) -> Course:
        around = Surroundings(friction_scale=friction, slip_channel=channel)
        return run_quality_trial(QualityTrial("vegrip", 3, 2.0, 0.15, "pinch", around))

    slippery, usual = 0.4, 1.0
    assert not run("sound", slippery).dropped
    assert run("dead", slippery).dropped
    assert run("absent", slippery).dropped
    sound = np.mean(run("sound", usual).force)
    assert np.mean(run("dead", usual).force) == pytest.approx(sound, rel=1e-3)
    for channel in ("stuck", "noisy"):
        assert np.mean(run(channel, usual).force) > 1.05 * sound


def test_a_noisy_slip_channel_has_two_flags_in_a_hundred_wrong_and_two_millimetres_a_second() -> None:
    assert wrong_slip("sound", 5) is None
    spoil = wrong_slip("noisy", 5)
    assert spoil is not None
    values = np.full((40_000, 9), 1.0)
    values[:, FLAG] = 0.0
    spoil(values)
    assert values[:, FLAG].mean() == pytest.approx(0.02, abs=0.002)
    assert values[:, SPEED].std() == pytest.approx(2e-3, rel=0.02)
    assert np.all(values[:, [0, 1, 2, 3, 4, 5, 8]] == 1.0)


def _hand() -> HandSettings:
    return GRASPS["pinch"]


def answer(arguments: list[str], read: Callable[[], tuple[str, str]]) -> dict[str, object]:
    """Return what the command prints."""
    assert main(["controllers", *arguments, "--json"]) == 0
    found: dict[str, object] = json.loads(read().out)  # type: ignore[attr-defined]
    return found


def test_the_command_prints_the_figures_of_every_controller(
    capsys: pytest.CaptureFixture[str],
) -> None:
    told = answer(
        ["--grasp", "pinch", "--seeds", "1", "--duration", "2.5", "--only", "constant", "--sweep"],
        capsys.readouterr,
    )
    one = told["controllers"]["constant"]  # type: ignore[index]
    assert told["slip_channel"] == "sound"
    assert list(told["worlds"]) == ["old", "published"]  # type: ignore[call-overload]
    assert told["worlds"]["old"] == told["controllers"]  # type: ignore[index]
    asked = {
        "slips", "drops", "trials", "mean_force", "force_over_least", "largest_micro_slip", "margin_q05",
        "time_below_002", "by_class", "front", "friction_inside", "friction_std",
    }  # fmt: skip
    assert asked <= one.keys()
    assert set(one["by_class"]) == set(CLASSES)
    ratios = [point["force_over_least"] for point in one["front"]]
    assert ratios == sorted(ratios)
    assert one["mean_force"] == pytest.approx(8.0, abs=0.1)


def test_what_did_not_occur_is_a_dash_in_the_tables(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [
        "--grasp",
        "pinch",
        "--seeds",
        "1",
        "--duration",
        "2.5",
        "--only",
        "constant",
        "--world",
        "old",
    ]
    one = answer(arguments, capsys.readouterr)["controllers"]["constant"]  # type: ignore[index]
    absent = sum(math.isnan(by["force_over_least"] or math.nan) for by in one["by_class"].values())
    assert main(["controllers", *arguments]) == 0
    told = capsys.readouterr().out
    assert "nan" not in told
    (row,) = [
        line for line in told.split("force over least (slips)")[1].splitlines()[:2] if "constant" in line
    ]
    assert row.split().count("-") == absent > 0


def test_one_world_is_shown_alone_and_both_say_which_they_are(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--grasp", "pinch", "--seeds", "1", "--duration", "2.5", "--only", "constant"]
    alone = answer([*arguments, "--world", "published"], capsys.readouterr)
    assert list(alone["worlds"]) == ["published"]  # type: ignore[call-overload]
    assert alone["controllers"] == alone["worlds"]["published"]  # type: ignore[index]
    assert main(["controllers", *arguments]) == 0
    rows = [line.split()[:2] for line in capsys.readouterr().out.splitlines() if "constant" in line]
    assert rows == 3 * [["old", "constant"], ["published", "constant"]]


@pytest.mark.parametrize(
    "wrong",
    [["--grasp", "fist"], ["--only", "vegri"], ["--duration", "1"], ["--friction-scale", "0"],
     ["--drive-bandwidth", "1e6"], ["--slip-delay", "nan"], ["--duration", "nan"],
     ["--world", "new"], ["--slip-channel", "ded"], ["--slip-channel", "dead", "--no-slip-channel"]],
)  # fmt: skip
def test_what_cannot_be_asked_is_one_sentence_and_exit_code_two(
    wrong: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["controllers", *wrong]) == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
