"""What a step tells beside the state."""

import math

import numpy as np
import pytest
from scipy.stats import norm


@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.975])
def test_a_margin_is_told_at_the_stated_confidence(kernels, m, monkeypatch, confidence) -> None:
    asked = []
    monkeypatch.setattr(kernels, "slip_times", lambda _, *given: (asked.append(given), (3.0, 1.5))[1])
    kernels.report(m, 0.3, 5e-4)
    m[kernels.SET_QUANTILE] = norm.ppf(confidence)
    out = np.zeros(5)
    kernels.margin_of(m, 0.3, 5e-4, out)
    gauge = m[kernels.REP_GAUGE]
    upper = kernels.upper_gauge(
        gauge, m[kernels.REP_GAUGE_REL], m[kernels.REP_GAUGE_ABS], norm.ppf(confidence)
    )
    assert out[0] == gauge
    assert out[1] == upper
    assert out[2] == kernels.force_reserve(m, 0.3, 5e-4)
    assert out[3:].tolist() == [3.0, 1.5]
    ((tangential, torque, chance),) = asked
    assert (tangential, torque) == (0.3, 5e-4)
    assert chance == pytest.approx(1.0 - confidence)


@pytest.mark.parametrize("value", [1.0, -3e4, 0.0])
def test_a_value_that_a_sensor_may_measure_is_kept(kernels, value) -> None:
    assert kernels.plausible_value(value) == value
    assert kernels.plausible_value(0.9e50) == 0.9e50
    for beyond in (math.nan, math.inf, -math.inf, 1e50, -1e50):
        assert math.isnan(kernels.plausible_value(beyond))


def at(kernels, name):
    return getattr(kernels, name)


@pytest.mark.parametrize(
    ("streak", "period", "contradicted", "restarts"),
    [
        (5.0, 0.0201, 0.0, True),
        (4.9, 0.0201, 0.0, False),  # samples
        (5.0, 0.0199, 0.0, False),  # a tenth of a second
        (60.0, 0.002, 0.0, True),
        (0.0, 0.002, 0.0149, False),
    ],
)
@pytest.mark.parametrize("channel", ["DISPLACEMENT_STREAK", "FORCE_STREAK"])
def test_a_contact_that_a_channel_contradicts_begins_anew_after_a_tenth_of_a_second(
    kernels, m, channel, streak, period, contradicted, restarts
) -> None:
    m[kernels.DISPLACEMENT_STREAK] = m[kernels.FORCE_STREAK] = 0.0
    m[at(kernels, channel)], m[kernels.MODE_PERIOD] = streak, period
    m[kernels.MODE_CONTRADICTED], m[kernels.MODE_UNEXPLAINED] = contradicted, 1.0
    before = m[kernels.COUNT_RESTARTS]
    kernels.begin_lost_contact_anew(m, 0.002, 1.0, 9e-4)
    assert (m[kernels.COUNT_RESTARTS] - before == 1.0) == restarts
    if restarts:
        assert (m[kernels.FORCE_STREAK], m[kernels.DISPLACEMENT_STREAK]) == (0.0, 0.0)
        assert (m[kernels.MODE_CAUTION], m[kernels.MODE_UNEXPLAINED]) == (1.0, 0.0)
        assert m[kernels.MODE_LOST] == pytest.approx(0.002)
        for j in (kernels.OFFSET, kernels.BIAS):
            assert m[kernels.P0 + j * (kernels.N + 1)] == m[kernels.PRIOR0 + j]
    else:
        assert m[kernels.MODE_UNEXPLAINED] == 1.0


def test_what_is_lost_for_two_seconds_begins_as_with_the_first_sample(kernels, m) -> None:
    for lost, all_anew in ((1.997, False), (1.999, True)):
        was = m.copy()
        was[kernels.MODE_LOST], was[kernels.MODE_CONTRADICTED], was[kernels.MODE_PERIOD] = lost, 0.016, 0.004
        kernels.begin_lost_contact_anew(was, 0.002, 1.0, 9e-4)
        assert was[kernels.COUNT_RESTARTS] - m[kernels.COUNT_RESTARTS] == float(all_anew)
        assert was[kernels.MODE_PERIOD] == 0.004
        if all_anew:  # with a zero that may have moved by a tenth of the radius
            zero = was[kernels.P0 + kernels.OFFSET * (kernels.N + 1)]
            assert zero == pytest.approx((0.1 * m[kernels.SET_TIP_RADIUS]) ** 2)
            assert (was[kernels.FORCE_STREAK], was[kernels.DISPLACEMENT_STREAK]) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("dt", "period", "bridged"),
    [(0.26, 0.06, True), (0.25, 0.01, False), (0.4, 0.1, False), (0.41, 0.1, True)],
)
def test_a_pause_is_a_gap_beyond_the_longest_and_four_times_the_usual_spacing(
    kernels, m, monkeypatch, dt, period, bridged
) -> None:
    gaps, steps = [], []
    monkeypatch.setattr(kernels, "age_channels", lambda *_: None)
    monkeypatch.setattr(kernels, "bridge_gap", lambda _m, dt, *_: gaps.append(dt))
    monkeypatch.setattr(kernels, "predict_motion", lambda _m, dt: steps.append(dt))
    m[kernels.SET_LONGEST_GAP], m[kernels.MODE_PERIOD] = 0.25, period
    m[kernels.MODE_SLOPE] = 5.0
    kernels.filter_step(m, dt, math.nan, math.nan, math.nan)
    assert m[kernels.MODE_SLOPE] == 0.0  # nothing was measured
    assert gaps == [dt] * bridged
    assert steps == [0.0 if bridged else dt]


@pytest.mark.parametrize(
    ("age", "displacement", "blind"),
    [(0.26, math.nan, 1.0), (0.25, math.nan, 0.0), (0.26, 9e-4, 0.0)],
)
def test_the_displacement_counts_as_lost_after_the_longest_gap(kernels, m, age, displacement, blind) -> None:
    m[kernels.SET_LONGEST_GAP], m[kernels.DISPLACEMENT_AGE], m[kernels.MODE_BLIND] = 0.25, age, 0.0
    kernels.filter_step(m, 1e-3, math.nan, displacement, math.nan)
    assert m[kernels.MODE_BLIND] == blind


@pytest.mark.parametrize(("radius", "count"), [(5e-3, 1), (0.0, 0), (math.nan, 0), (math.inf, 0)])
def test_a_radius_is_measured_where_there_is_one(kernels, m, monkeypatch, radius, count) -> None:
    measured = []
    monkeypatch.setattr(kernels, "measure_radius", lambda _m, value: measured.append(value))
    kernels.filter_step(m, 2e-3, math.nan, math.nan, radius)
    assert measured == [radius] * count


@pytest.mark.parametrize(
    ("given", "sound"),
    [({}, True), ({"LOST": 1.0}, False), ({"MODE_CONTRADICTED": 1e-9}, False), ({"PART": 0.5}, False)],
)
def test_friction_is_learned_of_a_sound_estimate_under_a_load_that_is_not_doubted(
    kernels, m, monkeypatch, given, sound
) -> None:
    told = []
    for name in ("filter_step", "keep_finite", "follow_load", "note_contradiction"):
        monkeypatch.setattr(kernels, name, lambda *_: None)
    of_report = float("LOST" not in given)
    monkeypatch.setattr(kernels, "report", lambda m, *_: m.__setitem__(kernels.REP_SOUND, of_report))
    monkeypatch.setattr(kernels, "learn_friction", lambda _m, *one: told.append(one))
    m[kernels.MODE_CONTRADICTED] = given.get("MODE_CONTRADICTED", 0.0)
    m[kernels.PART0 + kernels.PART_LOST], m[kernels.REP_CONTACT] = given.get("PART", 0.0), 1.0
    for force, zero in ((0.5, 0.0), (0.0, 1.0)):
        m[kernels.REP_FORCE], m[kernels.MODE_ZERO_KNOWN] = force, 0.0
        kernels.update(m, 0.002, 1.0, 9e-4, math.nan, 0.3, 0.0, 0.5)
        assert m[kernels.MODE_ZERO_KNOWN] == zero
    begun = []
    monkeypatch.setattr(kernels, "begin_filter", lambda _m, *one: begun.append(one))
    for dt in (0.0, -1.0):
        kernels.update(m, dt, 1.0, 9e-4, math.nan, 0.3, 0.0, 0.5)
    assert begun == [(1.0, 9e-4)]
    assert [one[0] for one in told[2:]] == [0.0, 0.0]
    expected = (0.002, *kernels.utilisation(m), 0.5, True, sound)
    assert told[:2] == [expected, expected]


def test_a_displacement_is_noted_by_what_it_is_off_and_one_that_jumped_is_refused(kernels, m) -> None:
    channel = kernels.CHANNEL0 + kernels.CHANNEL_SIZE * kernels.CHANNEL_DISPLACEMENT
    cell = kernels.HEALTH0 + kernels.CELL_SIZE * int(m[kernels.MODE_CELL])
    assert kernels.CHANNEL_DISPLACEMENT == 0
    for off in (-1e-6, 1e-6):
        n = m.copy()
        n[cell : cell + kernels.CELL_SIZE] = 0.0
        kernels.use_displacement(n, 2e-3, n[kernels.MOTION_POSITION] + off, 0.49)
        assert n[cell + kernels.CELL_MEAN] == pytest.approx(math.copysign(0.7, off))
        assert n[cell + kernels.CELL_NIS] == pytest.approx(0.49)
        assert n[channel + kernels.CH_USED] == 1.0
    streak = m[channel + kernels.CH_STREAK]
    kernels.refuse_displacement(m, 64.0)
    assert m[channel + kernels.CH_STREAK] == streak + 1.0


def test_what_was_lost_is_found_after_a_twentieth_of_a_second_without_contradiction(kernels, m) -> None:
    m[kernels.MODE_LOST], m[kernels.MODE_AGREED] = 0.0, 0.04
    kernels.note_lost(m, 0.01, True)
    assert (m[kernels.MODE_LOST], m[kernels.MODE_AGREED]) == (0.01, 0.0)
    for _ in range(5):
        kernels.note_lost(m, 0.01, False)
    assert m[kernels.MODE_LOST] == 0.01
    kernels.note_lost(m, 0.01, False)
    assert m[kernels.MODE_LOST] == 0.0


def test_time_passes_for_channels_caution_health_and_the_usual_spacing(kernels, m) -> None:
    size, age = kernels.CHANNEL_SIZE, kernels.CH_AGE
    places = [kernels.CHANNEL0 + size * channel for channel in range(kernels.CHANNELS)]
    for place in places:
        m[place + age], m[place + kernels.CH_USED] = 0.3, 1.0
    m[kernels.MODE_CAUTION], m[kernels.MODE_PERIOD], m[kernels.SET_HEALTH_TIME] = 0.015, 0.004, 5.0
    kernels.age_channels(m, 0.01)
    assert [m[place + age] for place in places] == pytest.approx([0.31] * kernels.CHANNELS)
    assert [m[place + kernels.CH_USED] for place in places] == [0.0] * kernels.CHANNELS
    assert m[kernels.MODE_CAUTION] == pytest.approx(0.005)
    assert m[kernels.MODE_HEALTH_DECAY] == pytest.approx(math.exp(-0.002))
    assert m[kernels.MODE_PERIOD] == pytest.approx(0.0046)  # a tenth of the way
    kernels.age_channels(m, 0.01)
    assert m[kernels.MODE_CAUTION] == 0.0
    kernels.age_channels(m, 0.0)
    assert m[kernels.MODE_PERIOD] == pytest.approx(0.00514)
    m[kernels.MODE_PERIOD] = 0.0
    kernels.age_channels(m, 0.02)
    assert m[kernels.MODE_PERIOD] == 0.02


@pytest.mark.parametrize("stds", [2.0, -2.0, 30.0])
def test_what_a_force_leaves_unexplained_is_averaged_over_a_second_and_a_refused_one_cautions(
    kernels, m, stds
) -> None:
    m[kernels.MODE_UNEXPLAINED], m[kernels.MODE_TOLERATED], m[kernels.MODE_CAUTION] = 3e-4, 2e-4, 0.0
    S, dt = 1e-3, 0.05
    kernels.use_force(m, dt, stds * math.sqrt(S), S)
    if abs(stds) > 10.0:
        assert (m[kernels.MODE_UNEXPLAINED], m[kernels.MODE_CAUTION]) == (3e-4, 0.1)
        return
    excess = 4.0 * S - (S - 2e-4)
    assert m[kernels.MODE_UNEXPLAINED] == pytest.approx(3e-4 + dt / (1.0 + dt) * (excess - 3e-4))
    assert m[kernels.MODE_CAUTION] == 0.0
    m[kernels.MODE_UNEXPLAINED] = 0.0
    kernels.use_force(m, dt, 0.0, S)
    assert m[kernels.MODE_UNEXPLAINED] == 0.0  # no variance is negative


def test_a_coordinate_that_is_freed_has_a_variance_of_its_own(kernels, m, P) -> None:
    before = P.copy()
    kernels.free_coordinate(m, kernels.OFFSET, 7.0)
    others = np.arange(kernels.N) != kernels.OFFSET
    assert P[kernels.OFFSET, kernels.OFFSET] == 7.0
    assert not P[kernels.OFFSET, others].any()
    assert not P[others, kernels.OFFSET].any()
    assert np.array_equal(P[np.ix_(others, others)], before[np.ix_(others, others)])


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("stds", "far"), [(4.99, False), (5.01, True)])
def test_an_estimate_is_not_sound_where_it_is_five_deviations_from_its_measurement_for_15_ms(
    kernels, m, stds, far, sign
) -> None:
    m[kernels.MODE_CONTRADICTED] = m[kernels.MODE_RADIUS_CONTRADICTED] = m[kernels.MODE_LOST] = 0.0
    depth = math.hypot(m[kernels.REP_DEPTH_STD], math.sqrt(m[kernels.SET_R_DISPLACEMENT]))
    radius = math.hypot(m[kernels.REP_RADIUS_STD], math.sqrt(m[kernels.SET_R_RADIUS]))
    told = {
        "force": m[kernels.REP_FORCE] + m[kernels.Y0 + kernels.BIAS] + sign * stds * m[kernels.REP_FORCE_STD],
        "displacement": m[kernels.REP_DEPTH_NOW] + m[kernels.Y0 + kernels.OFFSET] + sign * stds * depth,
        "radius": m[kernels.REP_RADIUS] + sign * stds * radius,
    }
    assert told["radius"] > 0.0
    for name, value in told.items():
        n = m.copy()
        n[kernels.REP_SOUND] = n[kernels.REP_RADIUS_SOUND] = 1.0
        sample = dict.fromkeys(told, math.nan) | {name: value}
        sound = []
        for _ in range(5):  # the first begins it
            kernels.note_contradiction(n, 0.0051, **sample)
            sound.append((n[kernels.REP_SOUND], n[kernels.REP_RADIUS_SOUND]))
        wrong = (1.0, 0.0) if name == "radius" else (0.0, 0.0)
        assert sound == [(1.0, 1.0)] * 3 + [wrong if far else (1.0, 1.0)] * 2
        kernels.note_contradiction(n, 0.0051, *[math.nan] * 3)
        assert n[kernels.MODE_CONTRADICTED] == n[kernels.MODE_RADIUS_CONTRADICTED] == 0.0


def test_a_load_without_a_contact_is_beyond_every_limit_and_no_load_is_within(kernels) -> None:
    assert kernels.gauge_of(0.0, 1e-3, 2.0, 0.7, (0.1, 0.0)) == math.inf
    assert kernels.gauge_of(1.0, 0.0, 2.0, 0.7, (0.0, 1e-3)) == math.inf
    assert kernels.gauge_of(0.0, 1e-3, 2.0, 0.7, (0.0, 0.0)) == 0.0
    assert kernels.gauge_of(2.0, 1e-3, 2.0, 0.7, (0.7, 0.0)) == pytest.approx(0.5, rel=1e-4)
    assert kernels.gauge_of(0.5, 1e-3, 2.0, 0.7, (0.175, 0.0)) == pytest.approx(0.5, rel=1e-4)
    limit = 0.7 * 2.0 * 1e-3 * kernels.torsion_limit(2.0)
    assert kernels.gauge_of(2.0, 1e-3, 2.0, 0.7, (0.0, 0.5 * limit)) == pytest.approx(0.5, rel=1e-3)
    assert kernels.load_of(-0.3, math.nan) == (0.3, 0.0)
    assert kernels.load_of(0.3, -2e-3) == (0.3, 2e-3)


@pytest.mark.parametrize(("relative", "force_std"), [(0.3, 0.1), (0.05, 0.1), (2e6, 0.1)])
def test_the_spread_that_does_not_come_from_the_force_is_the_rest_or_that_of_friction(
    kernels, m, relative, force_std
) -> None:
    m[kernels.REP_GAUGE_REL], m[kernels.REP_FORCE], m[kernels.REP_FORCE_STD] = relative, 2.0, force_std
    m[kernels.REP_GAUGE_BY_FORCE] = 0.0
    friction = m[kernels.CONSIDER0 + kernels.CONSIDERED_MU] = m[kernels.FRI_VAR]
    rest = max(relative**2 - (force_std / 2.0) ** 2 - friction, 0.0) + friction
    if relative > 1e6:
        rest = friction
    assert kernels.variance_without_force(m, 2.0) == pytest.approx(rest)
    m[kernels.REP_FORCE] = 0.0
    assert kernels.variance_without_force(m, 2.0) == pytest.approx(friction)


def test_friction_may_be_another_in_each_new_contact_and_not_in_the_air(kernels, m) -> None:
    m[kernels.SET_MU_DRIFT], m[kernels.SET_REGRASP], m[kernels.SET_MU_PRIOR_VAR] = 0.0, 0.1, 0.16
    m[kernels.FRI_VAR] = m[kernels.FRI_BASE_VAR] = 1e-3
    m[kernels.FRI_SCATTER_VAR] = m[kernels.SET_SCATTER] ** 2
    zero, begin = m[kernels.Y0 + kernels.BIAS], m[kernels.Y0 + kernels.OFFSET]
    seen = []
    for force, depth in ((0.0, -1e-3), (1.0, 9e-4), (0.0, -1e-3), (1.0, 9e-4)):
        for _ in range(200):
            kernels.update(m, 0.002, zero + force, begin + depth, math.nan, 0.0, 0.0, math.nan)
        seen.append((m[kernels.REP_CONTACT], m[kernels.FRI_VAR]))
    assert [contact for contact, _ in seen] == [0.0, 1.0, 0.0, 1.0]
    assert [var for _, var in seen] == pytest.approx([0.001, 0.011, 0.011, 0.021])


@pytest.mark.parametrize(
    ("regime", "rest"), [("AIR", 0.31), ("HOLD", 0.31), ("LOADING", 0.0), ("UNLOADING", 0.0)]
)
def test_a_tip_rests_while_it_neither_loads_nor_unloads(kernels, m, monkeypatch, regime, rest) -> None:
    monkeypatch.setattr(kernels, "regime_of", lambda _: getattr(kernels, f"REGIME_{regime}"))
    monkeypatch.setattr(kernels, "cell_of", lambda m: 7.0 + m[kernels.MODE_SINCE_JERK])
    m[kernels.MODE_REST] = m[kernels.MODE_SINCE_JERK] = 0.3
    kernels.note_regime(m, 0.01)
    assert m[kernels.MODE_REST] == pytest.approx(rest)
    assert m[kernels.MODE_CELL] == 7.0 + m[kernels.MODE_SINCE_JERK] == pytest.approx(7.31)


SEEN = 9e-4  # [m]
OTHER = "keep, predict 0.0009, return, predict nan, "


@pytest.mark.parametrize(
    ("displacement", "off", "surprise", "calls"),
    [
        (math.nan, [7.1], 0.0, "predict nan, force 7.1, extremes False"),
        (math.nan, [], 0.0, "predict nan, extremes False"),
        (SEEN, [], 50.0, "keep, predict 0.0009, displacement 50.0, extremes True"),
        (SEEN, [7.1], 49.0, "keep, predict 0.0009, force 7.1, displacement 49.0, extremes True"),
        (SEEN, [-7.0], 50.0, "keep, predict 0.0009, force -7.0, displacement 50.0, extremes True"),
        (SEEN, [7.1, 7.0], 50.0, OTHER + "force 7.0, extremes False, refuse 50.0"),
        (SEEN, [-7.1, 7.1, 7.2], 50.0,
         OTHER + "return, predict 0.0009, force 7.2, displacement 50.0, extremes True"),
    ],
)  # fmt: skip
def test_of_displacement_and_force_that_contradict_each_other_the_one_that_jumped_is_refused(
    kernels, m, monkeypatch, displacement, off, surprise, calls
) -> None:
    """The displacement, where the force fits the motion as it was expected; beyond seven deviations each."""
    done, left = [], list(off)

    def notes(name, place=None):
        def note(_m, *given):
            done.append(name if place is None else f"{name} {given[place]}")

        return note

    for function, note in {
        "predict": notes("predict", 1), "keep_belief": notes("keep"),
        "use_displacement": notes("displacement", 2), "follow_extremes": notes("extremes", 1),
        "refuse_displacement": notes("refuse", 0), "return_belief": notes("return"),
    }.items():  # fmt: skip
        monkeypatch.setattr(kernels, function, note)
    monkeypatch.setattr(kernels, "use_force", lambda _m, _dt, by, _: done.append(f"force {2.0 * by}"))
    monkeypatch.setattr(kernels, "surprise_of", lambda *_: surprise)
    monkeypatch.setattr(kernels, "expect_innovation", lambda *_: (0.5 * left.pop(0), 0.25))
    m[kernels.MODE_CAUTION], m[kernels.MODE_CORNER], m[kernels.MODE_BLIND] = 0.0, 7.0, 0.0
    kernels.take_sample(m, 2e-3, 1.0 if off else math.nan, displacement)
    assert ", ".join(done) == calls
    corner = 0.0 if math.isnan(displacement) else displacement - m[kernels.MOTION_POSITION]
    assert m[kernels.MODE_CORNER] == corner
    assert m[kernels.MODE_CAUTION] == (0.1 if "refuse" in calls else 0.0)


@pytest.mark.parametrize(
    ("blind", "begin", "depth"), [(1.0, -1e-3, 0.0), (0.0, -1e-3, -1e-3), (1.0, 5e-4, 5e-4)]
)
def test_without_a_displacement_a_tip_is_nowhere_in_the_air_and_its_force_alone_is_expected(
    kernels, m, monkeypatch, blind, begin, depth
) -> None:
    monkeypatch.setattr(kernels, "predict", lambda *_: None)
    monkeypatch.setattr(kernels, "expect_force", lambda *_: (1.0, 0.0))
    monkeypatch.setattr(kernels, "expect_force_alone", lambda *_: (1.0, 1.0))
    m[kernels.MODE_BLIND], m[kernels.Y0 + kernels.DELTA], m[kernels.Y0 + kernels.SPEED] = blind, begin, 0.1
    kernels.take_sample(m, 2e-3, math.nan, math.nan)
    assert m[kernels.Y0 + kernels.DELTA] == depth
    assert m[kernels.Y0 + kernels.SPEED] == (0.1 if begin == depth else 0.0)
    assert kernels.expect_innovation(m, 1.0) == (1.0, blind)
