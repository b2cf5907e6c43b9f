"""What a finger takes in, needs and commands, law by law."""

import math

import numpy as np
import pytest

from tests.grip.stages import put

MS = 10**6


@pytest.fixture
def taken(kernels, monkeypatch):
    """Return what goes into the estimator, which uses the force."""
    seen = []

    def update(f, *given):
        seen.append(given)
        f[kernels.CHANNEL0 + kernels.CHANNEL_FORCE * kernels.CHANNEL_SIZE + kernels.CH_USED] = 1.0

    monkeypatch.setattr(kernels, "update", update)
    return seen


@pytest.mark.parametrize(
    ("before", "stamp", "dt", "after"),
    [
        ({}, 70, [-1.0], {"SAMPLE_SEQ": 1, "SAMPLE_STAMP": 70, "SAMPLE_REFUSED": 0}),
        ({"SAMPLE_BEGUN": 1, "SAMPLE_STAMP": 50}, 70, [2e-8], {"SAMPLE_SEQ": 1, "SAMPLE_STAMP": 70}),
        (
            {"SAMPLE_BEGUN": 1, "SAMPLE_STAMP": 70, "SAMPLE_BACKWARDS": 1},
            70,
            [],
            {
                "SAMPLE_SEQ": 0,
                "SAMPLE_REFUSED": 1,
                "SAMPLE_BACKWARDS": 2,
                "SAMPLE_TRUSTED": 0,
                "SAMPLE_STAMP": 70,
            },
        ),
        (
            {"SAMPLE_BEGUN": 1, "SAMPLE_STAMP": 90, "SAMPLE_BACKWARDS": 2},
            70,
            [1.0],
            {
                "SAMPLE_SEQ": 1,
                "SAMPLE_REFUSED": 1,
                "SAMPLE_BACKWARDS": 0,
                "SAMPLE_TRUSTED": 1,
                "SAMPLE_STAMP": 70,
            },
        ),
        ({"SAMPLE_BEGUN": 1, "SAMPLE_STAMP": 60, "SAMPLE_BACKWARDS": 2}, 70, [1e-8], {"SAMPLE_BACKWARDS": 0}),
        (
            {"SAMPLE_BEGUN": 1, "SAMPLE_STAMP": 90, "SAMPLE_RESUMED": 1},
            70,
            [1.0],
            {"SAMPLE_RESUMED": 0, "SAMPLE_REFUSED": 0, "SAMPLE_STAMP": 70},
        ),
    ],
)
def test_a_state_is_taken_after_the_last_one_or_by_a_clock_that_has_started_anew(
    kernels, f, t, taken, before, stamp, dt, after
) -> None:
    """After three in a row that are not, and after a rest, an unknown time has passed, here a second."""
    put(kernels, f, t, CLOCK_RECOVERY=3, CLOCK_GAP=10**9, NEWS_STAMP=stamp, STATE_NORMAL_FORCE=1.0, **before)
    kernels.assimilate(f, t)
    assert [given[0] for given in taken] == pytest.approx(dt)
    assert {name: t[getattr(kernels, name)] for name in after} == after
    assert t[kernels.SAMPLE_SHOWN] == stamp
    if dt:
        assert (t[kernels.SAMPLE_BEGUN], t[kernels.SAMPLE_TRUSTED], t[kernels.SAMPLE_INFORMED]) == (
            1,
            1,
            stamp,
        )


def test_what_was_measured_goes_to_its_place_and_what_was_not_stays(kernels, f, t, taken) -> None:
    nan = math.nan
    put(kernels, f, t, STATE_TANGENTIAL_FORCE_X=-3.0, STATE_TANGENTIAL_FORCE_Y=4.0, STATE_TORQUE_Z=0.02,
        STATE_TEMPERATURE=31.0, STATE_SLIP=1.0, STATE_SLIP_SPEED=0.03, STATE_NORMAL_FORCE=2.0,
        STATE_DISPLACEMENT=1e-3, STATE_CONTACT_RADIUS=4e-3)  # fmt: skip
    kernels.take_state(f, t)
    felt = f[kernels.EXOGENOUS0 : kernels.EXOGENOUS0 + 6]
    assert felt.tolist() == [31.0, 5.0, 0.02, 0.03, -3.0, 4.0]
    assert taken[-1][1:] == (2.0, 1e-3, 4e-3, 5.0, 0.02, 1.0)
    put(
        kernels,
        f,
        t,
        STATE_TANGENTIAL_FORCE_X=nan,
        STATE_TORQUE_Z=math.inf,
        STATE_TEMPERATURE=nan,
        STATE_SLIP=0.0,
    )
    kernels.take_state(f, t)
    assert felt.tolist() == [31.0, 5.0, 0.02, 0.0, -3.0, 4.0]  # the noise of a speed is no sliding
    assert np.isnan(taken[-1][4:6]).all()
    informed = t[kernels.SAMPLE_INFORMED]
    put(kernels, f, t, STATE_NORMAL_FORCE=nan, STATE_DISPLACEMENT=nan, NEWS_STAMP=5 * MS)
    kernels.take_state(f, t)
    assert t[kernels.SAMPLE_INFORMED] == informed


@pytest.mark.parametrize(
    ("slip", "speed", "told"),
    [
        (1.0, 0.03, 1.0),
        (1.0, 0.0, math.nan),
        (1.0, math.nan, 1.0),
        (0.0, 0.0, 0.0),
        (math.nan, 0.03, math.nan),
    ],
)
def test_a_slip_flag_that_its_speed_contradicts_says_nothing(kernels, f, t, slip, speed, told) -> None:
    put(kernels, f, t, STATE_SLIP=slip, STATE_SLIP_SPEED=speed)
    assert kernels.sensed_slip(f) == pytest.approx(told, nan_ok=True)


def test_the_last_memories_and_states_are_kept_in_turn(kernels, f, t) -> None:
    size, late, rows = kernels.LASTING_SIZE, kernels.LATE_SAMPLES, kernels.HISTORY_STATES
    for k in range(late + 1):
        f[:size] = k
        kernels.keep_for_rewind(f, t)
    kept = f[kernels.REWIND0 : kernels.REWIND0 + late * size].reshape(late, size)
    assert kept[:, 0].tolist() == kept[:, -1].tolist() == [late, *range(1, late)]
    f[:size] = 0.0
    for k in range(rows + 2):
        put(kernels, f, t, NEWS_STAMP=100 + k, NEWS_SEQ=k, SAMPLE_BEGUN=1, REP_CONTACT=k % 2)
        f[kernels.STATE0 : kernels.STATE0 + kernels.MEASURED] = k
        kernels.note_history(f, t)
    noted = [*range(rows, rows + 2), *range(2, rows)]
    assert t[kernels.HISTORY_STAMP0 : kernels.HISTORY_STAMP0 + rows].tolist() == [100 + k for k in noted]
    assert t[kernels.HISTORY_SEQ0 : kernels.HISTORY_SEQ0 + rows].tolist() == noted
    width = kernels.MEASURED + 1
    table = f[kernels.HISTORY0 : kernels.HISTORY0 + rows * width].reshape(rows, width)
    assert table[:, 0].tolist() == table[:, -2].tolist() == noted
    assert table[:, -1].tolist() == [k % 2 for k in noted]
    assert t[kernels.TURN_NOTED] == rows + 2


GOOD = {
    "SAMPLE_BEGUN": 1, "SAMPLE_IS_INFORMED": 1, "SAMPLE_TRUSTED": 1, "SAMPLE_STAMP": 9 * MS,
    "SAMPLE_INFORMED": 0, "SET_LONGEST_GAP": 0.01, "SET_QUANTILE": 2.0, "REP_SOUND": 1.0, "REP_CONTACT": 1.0,
    "REP_FORCE": 2.0, "REP_FORCE_STD": 0.1, "REP_GAUGE": 0.5, "REP_GAUGE_REL": 0.0, "REP_GAUGE_ABS": 0.1,
}  # fmt: skip


@pytest.mark.parametrize(
    ("changed", "sound", "known", "margin"),
    [
        ({}, True, True, 0.3),
        ({"SAMPLE_BEGUN": 0}, False, False, None),
        ({"SAMPLE_IS_INFORMED": 0}, False, False, None),
        ({"SAMPLE_STAMP": 11 * MS}, False, False, None),
        ({"REP_SOUND": 0.0}, False, False, None),
        ({"SAMPLE_TRUSTED": 0}, True, False, 0.3),
        ({"REP_FORCE": math.nan}, True, False, 0.3),
        ({"REP_FORCE_STD": math.inf}, True, False, 0.3),
        ({"REP_CONTACT": 0.0}, True, True, None),
        ({"REP_GAUGE": math.nan}, True, True, None),
    ],
)
def test_an_estimate_counts_while_measurements_come_and_are_used(
    kernels, f, t, changed, sound, known, margin
) -> None:
    put(kernels, f, t, **GOOD | changed)
    assert kernels.is_sound(f, t) == sound
    assert kernels.is_force_known(f, t) == known
    expected = math.nan if margin is None else margin
    assert kernels.margin_bound(f, t) == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize(
    ("changed", "least", "contact", "trusted"),
    [
        ({}, 1.7, 1, 1),
        ({"REP_CONTACT": 0.0}, 0.0, 0, 1),
        ({"REP_CONTACT": 0.0, "SAMPLE_TRUSTED": 0}, 0.0, 0, 0),
        ({"INPUT_LOST": "LOADING"}, math.nan, 1, 0),
        *(({"INPUT_LOST": 1 << bit}, math.nan, 1, 0) for bit in (1, 2, 3)),  # tangential forces and torque
        ({"INPUT_LOST": 1}, 1.7, 1, 1),
        ({"CHOICE_ASKS": 0}, math.nan, 1, 0),
        ({"REP_SOUND": 0.0}, math.nan, 1, 0),
    ],
)
def test_a_finger_needs_the_least_force_for_its_load(
    kernels, f, t, changed, least, contact, trusted, monkeypatch
) -> None:
    monkeypatch.setattr(kernels, "is_slipping", lambda *_: True)
    monkeypatch.setattr(kernels, "load_to_answer", lambda *_: (6.0, 0.2))
    asked = []
    monkeypatch.setattr(kernels, "least_force", lambda _, *given: asked.append(given) or 1.7)
    changed = {
        name: getattr(kernels, value) if isinstance(value, str) else value for name, value in changed.items()
    }
    put(kernels, f, t, STATE_TANGENTIAL_FORCE_X=3.0, STATE_TANGENTIAL_FORCE_Y=-4.0, STATE_TORQUE_Z=-0.1,
        TAKEN_BOUND=0.25, ASKED_MARGIN=0.3, ASKED_QUANTILE=1.6, **{"CHOICE_ASKS": 1, **GOOD, **changed},
    )  # fmt: skip
    kernels.demand_force(f, t, f)
    assert (f[kernels.DEMAND_LOAD], f[kernels.DEMAND_TORQUE], t[kernels.NEED_SLIPPING]) == (5.0, 0.1, 1)
    assert f[kernels.DEMAND_LEAST] == pytest.approx(least, nan_ok=True)
    assert (t[kernels.NEED_IN_CONTACT], t[kernels.NEED_TRUSTED]) == (contact, trusted)
    assert f[kernels.DEMAND_BOUND] == pytest.approx(0.25 if contact else math.nan, nan_ok=True)
    assert asked == [(6.0, 0.2, 0.3, 1.6)] * (least == 1.7)
    put(kernels, f, t, INPUT_DOUBTFUL=0, GRIP_HELD=2.5)
    kernels.hold_doubtful(f, t)
    assert f[kernels.DEMAND_LEAST] == pytest.approx(least, nan_ok=True)
    put(kernels, f, t, INPUT_DOUBTFUL=1)
    kernels.hold_doubtful(f, t)
    assert (f[kernels.DEMAND_LEAST], t[kernels.NEED_IN_CONTACT]) == (2.5, 1)
    kernels.demand_nothing(f, t)
    assert np.isnan(
        f[[kernels.DEMAND_LEAST, kernels.DEMAND_LOAD, kernels.DEMAND_TORQUE, kernels.DEMAND_BOUND]]
    ).all()
    assert not t[[kernels.NEED_IN_CONTACT, kernels.NEED_SLIPPING, kernels.NEED_TRUSTED]].any()


RULES = {
    "RULE_MIN_FORCE": 0.3, "RULE_MAX_FORCE": 15.0, "RULE_RAISE_RATE": 100.0, "RULE_LOWER_RATE": 10.0,
    "RULE_LIFETIME": 0.05, "RULE_HOLD_TIME": 0.1, "RULE_RAMP_RATE": 5.0, "RULE_SAFE_FORCE": 4.0,
}  # fmt: skip


@pytest.mark.parametrize(
    ("condition", "force", "reason", "required", "told"),
    [
        ("OK", 2.5, "RAISE", 2.5, "RAISE"),
        ("DEGRADED", 2.5, "LOWER", 2.5, "LOWER"),
        ("OK", 20.0, "RAISE", 15.0, "MAX_LIMIT"),
        ("OK", 0.1, "LOWER", 0.3, "MIN_LIMIT"),
        ("OK", 2.5, "UNTRUSTED", 3.0, "UNTRUSTED"),
        ("OK", math.nan, "RAISE", 3.0, "UNTRUSTED"),
        ("MISSING", 2.5, "RAISE", 3.0, "INPUT_HOLD"),
    ],
)
def test_a_need_is_bounded_and_a_fault_is_ridden_out(
    kernels, f, t, condition, force, reason, required, told, monkeypatch
) -> None:
    noted = []
    monkeypatch.setattr(
        kernels, "wanted_force",
        lambda _, __, base, dt: noted.append((base, dt)) or (force, getattr(kernels, f"REASON_{reason}")),
    )  # fmt: skip
    put(kernels, f, t, **RULES)
    kernels.start_control(f, t, 3.0, 1000)
    assert (t[kernels.TURN_STARTED], t[kernels.TURN_ASKED], t[kernels.TURN_COMMANDED]) == (1, 1000, 1000)
    put(kernels, f, t, GRIP_HELD=2.0, INPUT_CONDITION=getattr(kernels, f"CONDITION_{condition}"))
    kernels.require_force(f, t, 1000 + 2 * MS)
    assert noted == [(3.0, pytest.approx(2e-3))] * (condition != "MISSING")
    assert f[kernels.GRIP_REQUIRED] == required
    assert t[kernels.TURN_REASON] == getattr(kernels, f"REASON_{told}")
    assert kernels.is_at_fault(f) == (told in ("UNTRUSTED", "INPUT_HOLD"))
    kernels.require_force(f, t, 0)  # a clock set back: no time has passed
    assert t[kernels.TURN_ASKED] == 1000 + 2 * MS
    put(kernels, f, t, NEED_SLIPPING=1, INPUT_CONDITION=kernels.CONDITION_OK)
    kernels.require_force(f, t, 0)
    assert noted[-1] == (2.0, 0.0)  # from what is held: slip and faults do not count on what was needed


def test_a_share_is_commanded_at_most_at_the_rate_of_a_living_command(kernels, f, t) -> None:
    put(
        kernels,
        f,
        t,
        GRIP_REQUIRED=2.0,
        GRIP_HELD=2.0,
        TURN_COMMANDED=0,
        TURN_REASON=kernels.REASON_RAISE,
        **RULES,
    )
    kernels.end_fault(f)
    change, reason = kernels.command_share(f, t, 2.1, math.nan, 2 * MS)
    assert (change, reason) == (pytest.approx(0.1), kernels.REASON_RAISE)
    change, reason = kernels.command_share(f, t, 9.0, math.nan, 4 * MS)
    assert (change, reason) == (pytest.approx(0.2), kernels.REASON_RATE_LIMIT)
    assert kernels.command_share(f, t, 1.0, math.nan, 6 * MS)[0] == pytest.approx(
        -0.02
    )  # not below the need, at 10 N/s
    assert (f[kernels.GRIP_HELD], t[kernels.TURN_SEQ]) == (pytest.approx(2.28), 3)
    change, _ = kernels.command_share(f, t, 14.0, math.nan, 900 * MS)
    assert change == pytest.approx(5.0)  # after a silence no more than in the life of a command
    assert t[kernels.TURN_COMMANDED] == 900 * MS
    kernels.command_share(f, t, 14.0, math.nan, 0)
    assert t[kernels.TURN_COMMANDED] == 900 * MS
    put(kernels, f, t, GRIP_ELAPSED=0.0, GRIP_REQUIRED=7.0)
    assert (
        kernels.command_share(f, t, 14.0, math.nan, 901 * MS)[0] < 0.0
    )  # at fault no other finger's need counts
    put(kernels, f, t, GRIP_REQUIRED=1.0)
    assert kernels.command_share(f, t, 1.0, 14.0, 901 * MS)[0] == 0.0  # nor what they press
    put(kernels, f, t, SETUP_RENEWAL=20 * MS, TURN_STARTED=1)
    assert [kernels.is_renewal_due(t, 901 * MS + late) for late in (19 * MS, 20 * MS)] == [False, True]
    put(kernels, f, t, TURN_STARTED=0)
    assert not kernels.is_renewal_due(t, 9000 * MS)


@pytest.mark.parametrize(
    ("changed", "pressed"),
    [
        ({}, 5.0),
        ({"SETUP_FINGER": 1}, math.nan),  # no thumb
        ({"SETUP_THUMB": -1}, math.nan),
        ({"CHOICE_SHARE": 1}, math.nan),  # Python shares the grasp
        ({"SETUP_FINGERS": 21}, math.nan),
        ({"SETUP_FINGERS": 1}, math.nan),
    ],
)
def test_against_a_thumb_presses_what_the_other_fingers_are_commanded_that_have_a_need(
    kernels, t, changed, pressed
) -> None:
    g = np.zeros(kernels.BALANCE_PRESSED + kernels.BELIEF_MOST)
    g[:4] = 1.0, 1.0, 1.0, math.nan
    g[kernels.BALANCE_PRESSED : kernels.BALANCE_PRESSED + 4] = 7.0, 2.0, 3.0, 4.0
    put(kernels, g, t, **{"SETUP_THUMB": 0, "SETUP_FINGER": 0, "SETUP_FINGERS": 4, **changed})
    assert kernels.pressed_by_others(t, g) == pytest.approx(pressed, nan_ok=True)


def test_a_fault_holds_then_ramps_to_the_safe_force_and_lets_go_of_nothing(kernels, f, t) -> None:
    put(kernels, f, t, GRIP_REQUIRED=2.0, GRIP_HELD=2.5, **RULES)
    kernels.end_fault(f)
    forces, reasons = [], []
    for _ in range(60):
        kernels.hold_then_ramp(f, t, 0.01, kernels.REASON_INPUT_HOLD)
        forces.append(f[kernels.GRIP_REQUIRED])
        reasons.append(int(t[kernels.TURN_REASON]))
    begin = reasons.index(kernels.REASON_FAIL_SAFE)
    assert begin == pytest.approx(10, abs=1)  # hold time 0.1 s
    assert forces[:begin] == [2.5] * begin
    assert np.diff(forces[begin - 1 : begin + 29]) == pytest.approx(0.05)
    assert forces[-1] == 4.0
    assert reasons[-1] == kernels.REASON_INPUT_HOLD  # it is there, and holds
    assert math.isnan(f[kernels.GRIP_ENVELOPE])
    put(kernels, f, t, GRIP_HELD=6.0)
    kernels.hold_then_ramp(f, t, 0.01, kernels.REASON_UNTRUSTED)
    assert (f[kernels.GRIP_REQUIRED], t[kernels.TURN_REASON]) == (6.0, kernels.REASON_UNTRUSTED)


def test_a_contact_met_in_its_middle_is_asked_for_what_it_shows_to_suffice(kernels, f, t) -> None:
    put(kernels, f, t, DEMAND_LOAD=0.3, DEMAND_TORQUE=4e-3, DEMAND_LEAST=9.0, **RULES)
    kernels.begin_transfer(f, t, 2.0, 1e-2, 100)
    assert f[kernels.TRANSFER_LOAD] == pytest.approx(0.5)
    kernels.bound_takeover(f, t, 100)
    assert f[kernels.DEMAND_LEAST] == pytest.approx(2.0)
    put(kernels, f, t, DEMAND_LEAST=9.0)
    kernels.bound_takeover(f, t, 100 + 100 * MS)
    assert f[kernels.DEMAND_LEAST] == pytest.approx(2.5)  # along the ramp
    put(kernels, f, t, DEMAND_LEAST=9.0, DEMAND_LOAD=0.6, DEMAND_TORQUE=math.nan)
    kernels.bound_takeover(f, t, 100)
    assert f[kernels.DEMAND_LEAST] == pytest.approx(2.0 * 1.2**2)  # by the square of the load's growth
    put(kernels, f, t, DEMAND_LEAST=0.7)
    kernels.bound_takeover(f, t, 100)
    assert f[kernels.DEMAND_LEAST] == 0.7
    for late, slips in ((300 * MS, 0), (-1, 0), (MS, 1)):
        put(kernels, f, t, TURN_IN_TRANSFER=1, NEED_SLIPPING=slips, DEMAND_LEAST=9.0)
        kernels.bound_takeover(f, t, 100 + late)
        assert (t[kernels.TURN_IN_TRANSFER], f[kernels.DEMAND_LEAST]) == (0, 9.0)
    put(kernels, f, t, TRANSFER_LOAD=0.0, DEMAND_LOAD=0.0)
    assert kernels.growth_of_load(f) == 1.0
    put(kernels, f, t, DEMAND_LOAD=0.1, TRANSFER_ARM=0.0)
    assert kernels.growth_of_load(f) == math.inf


def test_the_usual_need_is_the_median_of_the_largest_of_each_slot(kernels, f, t) -> None:
    """Until half of the window is seen no less than the present need, and than the largest seen."""
    n, dt = kernels.USUAL_SLOTS, 0.01
    put(kernels, f, t, RULE_USUAL_TIME=n * 4 * dt, RULE_PROVEN_TIME=0.0)
    kernels.forget_usual(f, t)
    needs = np.random.default_rng(0).uniform(1.0, 3.0, 4 * (2 * n + 3)).round(3)
    for k, need in enumerate(needs):
        usual = kernels.add_need(f, t, need, dt)
        slots = needs[: (k + 1) // 4 * 4].reshape(-1, 4).max(axis=1)[-n:]
        if slots.size > n // 2:
            assert usual == np.sort(slots)[slots.size // 2]
        else:
            assert usual == max([need, *slots])
    put(kernels, f, t, RULE_USUAL_TIME=0.0)
    kernels.forget_usual(f, t)
    assert kernels.add_need(f, t, 2.2, dt) == 2.2  # without a window the present one


def test_a_need_that_was_once_enough_rises_slowly_to_the_usual_one(kernels, f, t) -> None:
    put(kernels, f, t, GRIP_SLOT=0.1, RULE_PROVEN_TIME=2.0, GRIP_PROVEN=1.0, GRIP_MEDIAN=3.0)
    for k in range(1, 30):
        kernels.prove_need(f)
        assert f[kernels.GRIP_PROVEN] == pytest.approx(3.0 - 2.0 * 0.95**k)
    put(kernels, f, t, GRIP_MEDIAN=0.5)
    kernels.prove_need(f)
    assert f[kernels.GRIP_PROVEN] == 0.5  # down at once
    put(kernels, f, t, GRIP_MEDIAN=1.5, RULE_PROVEN_TIME=0.01)
    kernels.prove_need(f)
    assert f[kernels.GRIP_PROVEN] == 1.5


def test_the_need_is_followed_up_at_once_and_down_after_a_rest_by_the_release_time(kernels, f, t) -> None:
    put(kernels, f, t, RULE_SETTLE_TIME=0.035, RULE_RELEASE_TIME=0.2, RULE_USUAL_TIME=0.0,
        RULE_SLIP_GROWTH=4.0, RULE_DEAD_BAND=0.1, RULE_WANTED_MARGIN=0.3, NEED_TRUSTED=1,
        NEED_IN_CONTACT=1)  # fmt: skip
    kernels.forget_grip(f, t)
    assert kernels.follow_need(f, t, 2.0, 3.0, 0.01) == 3.0
    held = [kernels.follow_need(f, t, 3.0, 1.0, 0.01) for _ in range(8)]
    assert held[:3] == [3.0] * 3
    assert held[3:] == pytest.approx([1.0 + 2.0 * math.exp(-0.05 * k) for k in range(1, 6)])
    assert kernels.follow_need(f, t, 1.5, 1.0, 0.01) < 1.5  # what a limit cut off was never there
    put(kernels, f, t, NEED_SLIPPING=1, DEMAND_LEAST=0.4)
    assert kernels.wanted_force(f, t, 2.0, 0.01) == (pytest.approx(2.08), kernels.REASON_SLIP)
    put(kernels, f, t, DEMAND_LEAST=2.5)
    assert kernels.wanted_force(f, t, 2.0, 0.01)[0] == 2.5
    put(kernels, f, t, NEED_TRUSTED=0)
    assert kernels.wanted_force(f, t, 2.0, 0.01)[0] == pytest.approx(2.08)
    put(kernels, f, t, NEED_SLIPPING=0)
    assert kernels.wanted_force(f, t, 2.0, 0.01) == (2.0, kernels.REASON_UNTRUSTED)
    put(kernels, f, t, NEED_TRUSTED=1)
    kernels.forget_grip(f, t)
    for bound, reason in ((0.3, "FORECAST"), (0.29, "RAISE"), (math.nan, "RAISE")):
        put(kernels, f, t, DEMAND_BOUND=bound)
        assert kernels.wanted_force(f, t, 2.0, 0.01) == (2.5, getattr(kernels, f"REASON_{reason}"))
    for envelope, told in ((1.81, (2.0, "HOLD")), (1.79, (1.79 / 0.9, "LOWER")), (2.0, (2.0, "HOLD"))):
        force, reason = kernels.with_play(f, 2.0, envelope)
        assert (force, reason) == (pytest.approx(told[0]), getattr(kernels, f"REASON_{told[1]}"))
    put(kernels, f, t, NEED_IN_CONTACT=0)
    kernels.forget_grip(f, t)
    assert kernels.follow_need(f, t, 2.0, 0.0, 0.04) == pytest.approx(2.0 * math.exp(-0.2))
