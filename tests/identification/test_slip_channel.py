"""How late a slip channel is and how fine, from slides of which the load tells."""

import math
from dataclasses import replace

import numpy as np
import pytest

from vegrip.identification.calibration.trials import Trial, practice_tip, practise
from vegrip.identification.experiment.design_space import MENU, Rig
from vegrip.identification.recording import Recording
from vegrip.identification.slip_channel import Slide, SlipChannel, slides_of, slip_channel

RATE = 200.0


def late(recording, seconds):
    """Return the recording with a slip channel that is late by ``seconds`` more."""
    lag = round(seconds * RATE)
    columns = dict(recording.columns)
    for name in ("slip", "slip_speed"):
        if name in columns:
            columns[name] = np.concatenate([np.zeros(lag), columns[name][: len(recording.t) - lag]])
    return replace(recording, columns=columns)


def imposed(drop, noise=0.01, count=5):
    """Loads that grow in 0.8 s until the tip slides and the load falls by a share ``drop``; felt at once."""
    rng, t = np.random.default_rng(3), np.arange(0.0, 1.5 * count, 1.0 / RATE)
    phase = t % 1.5
    slides = (phase >= 0.9) & (phase < 1.1)
    load = 1.4 * np.interp(phase, [0.1, 0.9], [0.0, 1.0]) * np.where(slides, 1.0 - drop, 1.0) * (phase < 1.1)
    columns = {
        "normal_force": 2.0 + rng.normal(0.0, noise, len(t)),
        "tangential_force_x": load + rng.normal(0.0, noise, len(t)),
        "tangential_force_y": rng.normal(0.0, noise, len(t)),
        "slip": slides.astype(float),
    }
    return Recording("imposed", t, np.zeros(len(t), dtype=np.int64), columns)


@pytest.mark.parametrize("seconds", [0.0, 0.02, 0.1])
@pytest.mark.parametrize("drop", [0.0, 0.3, 0.9])
def test_the_delay_of_a_slide_under_an_imposed_load_is_found(drop, seconds):
    found = slip_channel(slides_of(late(imposed(drop), seconds)))
    assert found.slides >= 3
    assert found.delay == pytest.approx(seconds, abs=0.006 if drop else 0.016)


def virtual_slides(seed):
    tip = practice_tip(seed)
    rig = Rig(depth=0.1 * tip.radius, speed=2.0 * tip.radius, rate=RATE, pause=10.0)
    item = next(item for item in MENU if item.name == "slides at four speeds")
    trial = Trial("slide", item.protocol(rig, {"depth": 1.0}), ())
    speeds = [max(abs(segment.pull_x) for segment in one) for one in trial.protocol.episodes]
    return practise(trial, tip, 5), speeds


@pytest.fixture(scope="module")
def slid():
    return virtual_slides(14)


def test_slides_of_the_virtual_bench_tell_the_delay_of_a_channel_within_ten_milliseconds(slid):
    recording, speeds = slid
    for seconds in (0.0, 0.02, 0.04):
        found = slip_channel(slides_of(late(recording, seconds), speeds))
        assert found.delay == pytest.approx(seconds, abs=0.011)


def test_the_threshold_is_the_slowest_slide_that_is_felt(slid):
    recording, speeds = slid
    felt = slip_channel(slides_of(recording, speeds))
    assert felt.threshold == pytest.approx(min(speeds), rel=0.1)  # the speed as it is measured
    columns = {name: values for name, values in recording.columns.items() if name != "slip_speed"}
    unmeasured = replace(recording, columns=columns)
    assert slip_channel(slides_of(unmeasured, speeds)).threshold == min(speeds)
    deaf = columns["slip"] * (recording.episode > 0)  # it does not feel the slowest
    coarse = replace(recording, columns={**columns, "slip": deaf})
    bracketed = slip_channel(slides_of(coarse, speeds))
    assert (bracketed.unfelt, bracketed.threshold) == (min(speeds), sorted(speeds)[1])
    assert "between" in bracketed.bracket
    assert math.isnan(felt.unfelt)
    assert "perhaps at less" in felt.bracket


@pytest.mark.parametrize(("seconds", "is_clear"), [(0.1, True), (0.6, False)])
def test_a_bend_that_took_long_to_grow_round_shows_no_moment(seconds, is_clear):
    """The patch slides from its rim inwards as the motion goes on."""
    rng, t = np.random.default_rng(1), np.arange(0.0, 1.5, 1.0 / RATE)
    begins = 0.3 + seconds
    share = np.clip((t - 0.3) / seconds, 0.0, 1.0)
    columns = {
        "normal_force": 2.0 + rng.normal(0.0, 0.005, len(t)),
        "tangential_force_x": 1.4 * (1.0 - (1.0 - share) ** 3) + rng.normal(0.0, 0.005, len(t)),
        "tangential_force_y": rng.normal(0.0, 0.005, len(t)),
        "slip": ((t >= begins) & (t < begins + 0.3)).astype(float),
    }
    (slide,) = slides_of(Recording("pull", t, np.zeros(len(t), dtype=np.int64), columns))
    assert math.isnan(slide.delay) is not is_clear
    assert not is_clear or abs(slide.delay) < 0.02


def test_a_pull_that_ends_before_it_slides_is_no_slide_that_is_not_felt(slid):
    recording, speeds = slid
    columns = {name: values for name, values in recording.columns.items() if name != "slip_speed"}
    short = recording.episode == 1
    columns["slip"] = columns["slip"] * ~short
    for name in ("tangential_force_x", "tangential_force_y"):
        columns[name] = np.where(short, 0.5 * columns[name], columns[name])
    assert math.isnan(slip_channel(slides_of(replace(recording, columns=columns), speeds)).unfelt)


@pytest.mark.long
def test_an_episode_in_which_nothing_slides_brackets_nothing(slid):
    recording, speeds = slid
    columns = {name: values for name, values in recording.columns.items() if name != "slip_speed"}
    sticks = recording.episode == 0
    columns["slip"] = columns["slip"] * ~sticks
    columns["tangential_force_x"] = np.where(sticks, 0.0, columns["tangential_force_x"])
    columns["tangential_force_y"] = np.where(sticks, 0.0, columns["tangential_force_y"])
    assert math.isnan(slip_channel(slides_of(replace(recording, columns=columns), speeds)).unfelt)


def test_a_slow_slide_that_is_not_felt_leaves_no_slower_one_to_count_on():
    slides = [Slide(0.02, 0.1, v) for v in (1e-4, 3e-4, 1e-3)] + [Slide(math.inf, 0.1, 2e-4)]
    assert slip_channel(slides).threshold == 3e-4
    deaf = slip_channel([replace(one, speed=1e-4) for one in slides[:3]] + [Slide(math.inf, 0.1, 2e-4)])
    assert math.isnan(deaf.threshold)
    assert "no slide that is felt has a known one" in deaf.lacking


def test_what_is_not_known_is_said_and_switches_nothing_on(slid):
    recording, _ = slid
    columns = {name: values for name, values in recording.columns.items() if name != "slip_speed"}
    found = slip_channel(slides_of(replace(recording, columns=columns)))
    assert "no slip speed is measured" in found.lacking
    assert found.settings == {}
    few = slip_channel([Slide(0.02, 0.1, 1e-4)] * 2)
    assert "2 slides begin clearly in the load, 3 are needed" in few.lacking
    assert few.settings == {}


def test_a_flag_that_comes_and_goes_without_a_load_tells_nothing():
    recording = imposed(0.3)
    rng = np.random.default_rng(1)
    columns = {**recording.columns, "slip": (rng.random(len(recording.t)) < 0.02).astype(float)}
    columns["tangential_force_x"] = rng.normal(0.0, 0.02, len(recording.t))
    found = slip_channel(slides_of(replace(recording, columns=columns)))
    assert math.isnan(found.delay)


def test_a_channel_that_is_known_switches_learning_on_with_its_own_figures():
    assert SlipChannel(1.234e-4, 0.0201, 5).settings == {
        "learning": True,
        "slip_threshold": 1.23e-4,
        "slip_delay": 0.0201,
    }
