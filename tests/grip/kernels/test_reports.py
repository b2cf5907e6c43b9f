"""What is told of a finger is what is believed of it, in the units and places of a message, or nothing."""

import math

import pytest

SURE = {
    "SAMPLE_BEGUN": 1, "SAMPLE_IS_INFORMED": 1, "SAMPLE_TRUSTED": 1, "SAMPLE_STAMP": 9_000_000,
    "SAMPLE_INFORMED": 4_000_000, "TURN_REPORTS": 7,
}  # fmt: skip
BELIEVED = {
    "SET_LONGEST_GAP": 0.01, "SET_QUANTILE": 1.6448536269514722, "REP_SOUND": 1.0, "REP_CONTACT": 1.0,
    "REP_GAUGE": 0.4, "REP_GAUGE_REL": 0.3, "REP_GAUGE_ABS": 0.05, "TAKEN_LOAD": 0.8, "TAKEN_TORQUE": 0.0,
    "PUBLISHED_CONFIDENCE": 0.95,
}  # fmt: skip


@pytest.fixture
def told(kernels, f, t, monkeypatch):
    """Report the margin with some numbers changed: return the bound and what was packed."""

    def report(reserve=1.5, likely=2.0, earliest=1.0, **changed):
        packed, asked = [], []
        monkeypatch.setattr(kernels, "pack_margin", lambda _, *values: packed.append(values))
        monkeypatch.setattr(kernels, "protect", lambda *_: None)
        monkeypatch.setattr(kernels, "force_reserve", lambda *_: reserve)
        monkeypatch.setattr(kernels, "slip_times", lambda *of: (asked.append(of[-1]), (likely, earliest))[1])
        for name, value in {**SURE, **BELIEVED, **changed}.items():
            (t if name in SURE else f)[getattr(kernels, name)] = value
        return kernels.report_margin(f, t, None), packed, asked

    return report


def test_the_margin_is_what_is_left_of_the_gauge_and_its_bound_what_is_left_of_the_upper_one(
    kernels, told
) -> None:
    bound, [packed], [chance] = told()
    upper = kernels.upper_gauge(0.4, 0.3, 0.05, BELIEVED["SET_QUANTILE"])
    assert bound == pytest.approx(1.0 - upper, abs=1e-12)
    seq, stamp, valid, value, std, age, lower, confidence, *rest = packed
    assert (seq, stamp, valid, confidence) == (7, 9_000_000, 1, 0.95)
    assert value == pytest.approx(0.6, abs=1e-12)
    assert lower == bound
    assert std == pytest.approx(math.hypot(0.4 * 0.3, 0.05))
    assert age == pytest.approx(5e-3)
    assert rest == [1.5, 2.0, 1.0]
    assert chance == pytest.approx(0.05)  # of the normal law beyond the quantile


@pytest.mark.parametrize("changed", [{"REP_SOUND": 0.0}, {"REP_CONTACT": 0.0}, {"REP_GAUGE": math.nan}])
def test_a_margin_that_is_not_known_is_told_as_such(told, changed) -> None:
    bound, [packed], asked = told(**changed)
    assert math.isnan(bound)
    assert packed[2] == 0
    assert all(math.isnan(packed[i]) for i in (3, 6, 8, 9, 10))
    assert packed[4] == packed[5] == math.inf
    assert not asked


@pytest.mark.parametrize(
    "changed",
    [
        {"REP_GAUGE": 4e38, "REP_GAUGE_REL": 0.0},
        {"reserve": 4e38},
        {"REP_GAUGE_ABS": 3e38},  # the bound alone is beyond: 1.6 times as much
        {"likely": 4e38},
        {"earliest": 4e38},
    ],
)
def test_what_a_single_does_not_carry_is_left_to_messages(told, changed) -> None:
    bound, packed, _ = told(**changed)
    assert bound == math.inf
    assert packed == []


def test_a_time_may_be_without_end(told) -> None:
    bound, [packed], _ = told(likely=math.inf, earliest=math.inf)
    assert math.isfinite(bound)
    assert packed[-2:] == (math.inf, math.inf)


DUE = {
    "SAMPLE_BEGUN": 1, "SAMPLE_IS_INFORMED": 1, "TURN_SEEN": 1, "TURN_HAS_MARGIN": 1, "TURN_CONTACT_DUE": 100,
}  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "now", "told"),
    [
        ({}, 100, True),
        ({}, 99, False),
        ({"INPUT_CONDITION": "DEGRADED"}, 100, True),
        ({"INPUT_CONDITION": "FROZEN"}, 100, False),
        ({"TURN_CONTACT_DUE": 1}, 1, True),
        ({"TURN_CONTACT_DUE": 0}, 100, False),  # messages tell the first
        *(({name: 0}, 100, False) for name in DUE),
    ],
)
def test_frames_tell_what_is_due_not_the_first_and_believed(kernels, t, changed, now, told) -> None:
    for name, value in {**DUE, **changed}.items():
        known = getattr(kernels, f"CONDITION_{value}") if isinstance(value, str) else value
        t[getattr(kernels, name)] = known
    assert kernels.is_reported_here(t, now) == told


@pytest.mark.parametrize(("bound", "told"), [(0.3, True), (math.nan, True), (math.inf, False)])
def test_a_report_is_counted_and_the_next_one_is_due_a_period_later(
    kernels, f, t, monkeypatch, bound, told
) -> None:
    monkeypatch.setattr(kernels, "report_margin", lambda *_: bound)
    monkeypatch.setattr(kernels, "report_contact", lambda *_: None)
    for name, value in {**DUE, "SETUP_REPORT_PERIOD": 20, "TURN_HEALTH_DUE": 115, "TURN_REPORTS": 7}.items():
        t[getattr(kernels, name)] = value
    for now, due in ((100, 115), (120, 115)) if told else ((100, 0),):
        assert kernels.finger_report(f, t, now, None, None, None) == (
            kernels.REPORTED if told else kernels.NOT_REPORTED
        )
        assert t[kernels.TURN_REPORT_DUE] == due
    assert (t[kernels.TURN_REPORTS], t[kernels.TURN_CONTACT_DUE]) == ((9, 140) if told else (7, 100))


ESTIMATES = {
    "DEPTH_NOW": "DEPTH_STD", "FORCE": "FORCE_STD", "RADIUS": "RADIUS_STD", "EXPONENT": "EXPONENT_STD",
    "MU": "MU_STD", "LIMIT_FORCE": "LIMIT_FORCE_STD", "LIMIT_TORQUE": "LIMIT_TORQUE_STD",
    "LIMIT_RADIUS": "LIMIT_RADIUS_STD",
}  # fmt: skip
LARGEST = 3.4028234663852886e38  # the largest single


@pytest.mark.parametrize("name", ESTIMATES)
def test_frames_carry_a_contact_of_singles_whose_spreads_may_be_without_end(kernels, f, name) -> None:
    value, spread = (getattr(kernels, f"REP_{one}") for one in (name, ESTIMATES[name]))
    for at, number, carried in [
        *((value, one, True) for one in (0.0, LARGEST, -LARGEST, math.nan)),
        *((value, one, False) for one in (math.nextafter(LARGEST, math.inf), math.inf, -math.inf)),
        *((spread, one, True) for one in (0.0, LARGEST, math.nan, math.inf)),
        (spread, math.nextafter(LARGEST, math.inf), False),
    ]:
        f[at] = number
        assert kernels.is_carried(f) == carried, number
        f[at] = 0.0


@pytest.fixture
def contact(kernels, f, t, monkeypatch):
    """Report a contact with some numbers changed: return what was packed, by the place in its two frames."""

    def report(**changed):
        packed = []
        for pack in ("pack_contact1", "pack_contact2"):
            monkeypatch.setattr(kernels, pack, lambda _, *values: packed.append(values))
        monkeypatch.setattr(kernels, "protect", lambda *_: None)
        monkeypatch.setattr(kernels, "stated_friction", lambda _, __, mu, std: (2.0 * mu, 3.0 * std))
        numbers = {f"REP_{name}": 1.0 + 2 * i for i, name in enumerate(ESTIMATES)}
        numbers |= {f"REP_{name}": 2.0 + 2 * i for i, name in enumerate(ESTIMATES.values())}
        numbers |= {"REP_RADIUS_SOUND": 1.0, "SAMPLE_SHOWN": 9_000_000}
        wholes = {*SURE, "SAMPLE_SHOWN", "TURN_NOTED"}
        for name, value in {**SURE, **BELIEVED, **numbers, **changed}.items():
            (t if name in wholes else f)[getattr(kernels, name)] = value
        kernels.report_contact(f, t, None, None)
        return packed

    return report


def test_a_contact_is_told_in_the_places_of_its_frames(contact) -> None:
    first, second = contact()
    assert first[:7] == (7, 9_000_000, 1, 1, 1, 1, 1)
    assert first[7:16] == (1.0, 2.0, 5e-3, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)
    assert second[:6] == (7, 9_000_000, 1, 1, 1, 1)
    assert second[6:] == (18.0, 30.0, 5e-3, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0)


@pytest.mark.parametrize(
    ("changed", "first", "second"),
    [  # touching, current, force, radius, exponent; friction, limits of force and torque and of this load
        ({"SAMPLE_TRUSTED": 0}, (1, 0, 0, 0, 0), (0, 0, 0, 0)),
        ({"REP_SOUND": 0.0}, (1, 0, 0, 0, 0), (0, 0, 0, 0)),
        ({"REP_CONTACT": 0.0}, (0, 1, 1, 1, 0), (1, 1, 1, 0)),
        ({"REP_RADIUS_SOUND": 0.0}, (1, 1, 1, 0, 1), (1, 1, 1, 1)),
        ({"REP_FORCE": math.nan}, (1, 1, 0, 1, 1), (1, 1, 1, 1)),
        ({"REP_FORCE_STD": math.inf}, (1, 1, 0, 1, 1), (1, 1, 1, 1)),
        ({"REP_RADIUS": math.nan}, (1, 1, 1, 0, 1), (1, 1, 1, 1)),
        ({"REP_EXPONENT_STD": math.nan}, (1, 1, 1, 1, 0), (1, 1, 1, 1)),
        ({"REP_MU_STD": math.inf}, (1, 1, 1, 1, 1), (0, 1, 1, 1)),
        ({"REP_LIMIT_FORCE": math.nan}, (1, 1, 1, 1, 1), (1, 0, 1, 1)),
        ({"REP_LIMIT_TORQUE": math.nan}, (1, 1, 1, 1, 1), (1, 1, 0, 1)),
        ({"REP_LIMIT_RADIUS_STD": math.nan}, (1, 1, 1, 1, 1), (1, 1, 1, 0)),
    ],
)
def test_an_estimate_is_valid_that_is_current_and_known(contact, changed, first, second) -> None:
    one, two = contact(**changed)
    assert (one[2:7], two[2:6]) == (first, second)


@pytest.mark.parametrize(
    ("channel", "bit"),
    [("FORCE", 1), ("DISPLACEMENT", 2), ("RADIUS", 4), ("LOAD", 8), ("TORQUE", 16), ("", 32)],
)
def test_each_channel_that_the_last_sample_gave_has_its_bit(kernels, f, contact, channel, bit) -> None:
    row = 3  # the state kept last
    slip = kernels.HISTORY0 + row * (kernels.MEASURED + 1) + 6
    nothing = {"TAKEN_LOAD": math.nan, "TAKEN_TORQUE": math.nan, "TURN_NOTED": row + 1}
    f[slip] = math.nan if channel else 1.0
    if channel in ("LOAD", "TORQUE"):
        nothing[f"TAKEN_{channel}"] = 0.5
    elif channel:
        at = getattr(kernels, f"CHANNEL_{channel}") * kernels.CHANNEL_SIZE + kernels.CH_USED
        f[kernels.CHANNEL0 + at] = 1.0
    assert contact(**nothing)[0][-1] == bit
    assert contact(**nothing, SAMPLE_TRUSTED=0)[0][-1] == 0
