"""The lag of a drive is found from its commands and forces, and nothing that is wrong of them teaches."""

import math
import re
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.grip import drive_lag
from vegrip.grip.drive_lag import (
    begin_drives,
    follow_drive,
    judge_drive,
    measure_drive,
    measured_lag,
    watch_rate,
)
from vegrip.grip.drive_log import DriveLog, describe_lag
from vegrip.grip.friction_settings import FrictionSettings
from vegrip.grip.grasp_friction import GraspFriction
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.policies.margin_grip import GripSettings
from vegrip.grip.settings import ControlSettings
from vegrip.model import paper_model
from vegrip.types import Floats

DT, NOISE, FINGER = 0.002, 0.01, 3


def grips(seconds: float, seed: int = 1) -> Floats:
    """Return commands [N] as a grip gives them: raised at 80 N/s at some instants, lowered slowly."""
    rng = np.random.default_rng(seed)
    command, goal, out = 2.0, 2.0, []
    for _ in range(round(seconds / DT)):
        if rng.random() < DT / 0.7:
            goal = 2.0 + 3.0 * rng.random()
        step = goal - command
        command += min(step, 80.0 * DT) if step > 0.0 else max(step * DT / 0.3, -8.0 * DT)
        if command >= goal - 1e-9:
            goal = 1.5
        out.append(command)
    return np.array(out)


def forces(
    commands: Floats, time_constant: float, rate: float = 60.0, dead: int = 0, stiction: float = 0.01
) -> Iterator[tuple[float, float]]:
    """Yield the command that was in force and the measured force [N] of a drive, by sample."""
    rng = np.random.default_rng(7)
    target = force = commands[0]
    for k, command in enumerate(commands):
        asked = commands[max(k - dead, 0)]
        for _ in range(20):
            step = DT / 20
            target += min(max(asked - target, -rate * step), rate * step)
            error = target - force
            force += step / time_constant * (error - min(max(error, -stiction), stiction))
        yield command, force + 0.005 + NOISE * rng.standard_normal()


def followed(samples: Iterator[tuple[float, float]]) -> GraspMemory:
    """Return the state after all samples."""
    q = GraspMemory()
    begin_drives(q, NOISE)
    for command, force in samples:
        follow_drive(q, FINGER, DT, command, force)
    return q


def behind_a_need(time_constant: float, dead: int = 0) -> float:
    """Return the lag [s] of a drive that is commanded sample by sample."""
    return DT / (1.0 - math.exp(-DT / time_constant)) + dead * DT


@pytest.mark.parametrize(
    ("bandwidth", "rate"),
    [
        (5.0, 25.0),
        *(pytest.param(*one, marks=pytest.mark.long) for one in ((12.0, 60.0), (30.0, 150.0))),
        (80.0, 400.0),
    ],
)
def test_the_lag_of_a_drive_of_any_bandwidth_is_found_within_a_fifth(bandwidth: float, rate: float) -> None:
    time_constant = 1.0 / (2.0 * math.pi * bandwidth)
    q = followed(forces(grips(30.0), time_constant, rate))
    assert measured_lag(q, FINGER) == pytest.approx(behind_a_need(time_constant), rel=0.2)


def test_a_dead_time_counts_as_lag() -> None:
    q = followed(forces(grips(30.0), 0.01, dead=3))
    assert measured_lag(q, FINGER) == pytest.approx(behind_a_need(0.01, 3), rel=0.25)


def test_the_lag_is_not_known_before_the_command_has_moved() -> None:
    q = followed((2.0, 2.0 + 0.01 * math.sin(k)) for k in range(5000))
    assert math.isnan(measured_lag(q, FINGER))


def test_a_drive_that_becomes_slower_is_found_out() -> None:
    commands = grips(70.0)
    half = len(commands) // 2
    samples = [*forces(commands[:half], 0.01), *forces(commands[half:], 0.03)]
    assert measured_lag(followed(iter(samples)), FINGER) == pytest.approx(behind_a_need(0.03), rel=0.25)


@pytest.mark.parametrize("wrong", [1e3, -5.0, 0.0, math.inf, math.nan])
def test_one_bad_sample_of_the_force_moves_the_lag_by_little(wrong: float) -> None:
    samples = list(forces(grips(10.0), 0.0133))
    good = followed(iter(samples)).drive.lag[FINGER]
    for at in range(4000, 4400, 100):
        bad = [*samples]
        bad[at] = (samples[at][0], wrong)
        assert followed(iter(bad)).drive.lag[FINGER] == pytest.approx(good, abs=1e-3)


def test_a_force_that_stands_still_or_does_not_listen_is_not_taken_for_a_lag() -> None:
    """A drive that holds its position: what it does is told by no lag, so none is known."""
    rng = np.random.default_rng(5)
    q = followed((command, 3.0 + NOISE * rng.standard_normal()) for command in grips(30.0))
    assert math.isnan(measured_lag(q, FINGER))


def test_samples_that_do_not_count_teach_nothing() -> None:
    """A fail-safe, a doubtful force or a stale state come as a command that is no number."""
    q = followed((math.nan, force) for _, force in forces(grips(10.0), 0.03))
    assert q.drive.state[3 * FINGER] == pytest.approx(0.015)
    assert math.isnan(measured_lag(q, FINGER))


def test_the_lag_stays_within_bounds_whatever_comes() -> None:
    rng = np.random.default_rng(3)
    odd = rng.choice([0.0, 1.0, 1.4, 5.0, 1e300, -1e300, math.nan, math.inf], size=(20_000, 2))
    q = followed((float(command), float(force)) for command, force in odd)
    assert all(math.isfinite(value) for value in q)
    assert 0.0 <= q.drive.lag[FINGER] <= 0.3


def test_a_node_logs_the_lag_of_a_drive_once_it_is_known(caplog: pytest.LogCaptureFixture) -> None:
    log = DriveLog("grip")
    friction = GraspFriction({"thumb": object()}, ControlSettings())
    friction.set_lead(GripSettings(drive_lag=0.01))
    with caplog.at_level("INFO", logger="vegrip.grip"):
        log.log_changes("thumb", friction, GripSettings(drive_lag=0.01))
        for command, force in forces(grips(20.0), 0.0133):
            follow_drive(friction.memory, 0, DT, command, force)
            log.log_changes("thumb", friction, GripSettings(drive_lag=0.01))
    assert friction.drive_lag("thumb") == pytest.approx(0.0143, rel=0.2)
    stated = [record.getMessage() for record in caplog.records]
    assert len(stated) == 1
    assert re.fullmatch("drive of thumb: lag 1[3-7] ms, configured 10 ms(; 15 ms of it are led)?", stated[0])


def test_other_parameters_do_not_make_it_forget_a_lag() -> None:
    friction = GraspFriction({"thumb": object()}, ControlSettings())
    for command, force in forces(grips(20.0), 0.0133):
        follow_drive(friction.memory, 0, DT, command, force)
    known = friction.drive_lag("thumb")
    friction.set_lead(GripSettings())
    assert friction.drive_lag("thumb") == known


@pytest.mark.parametrize("lag", [0.0, 1e-3])
@pytest.mark.parametrize("learning", [False, True])
def test_a_finger_leads_its_load_where_the_lag_of_its_drive_is_stated_or_friction_is_learned(
    lag: float, *, learning: bool
) -> None:
    grip, friction = GripSettings(drive_lag=lag), FrictionSettings(learning=learning)
    settings = ControlSettings(grip=grip, friction=friction)
    estimator = ContactEstimator(paper_model(tip_radius=9e-3), SensorNoise())
    shared = GraspFriction({"thumb": estimator}, settings)
    told: dict[str, float] = {}
    shared.write_to(told, "thumb")
    assert told["SETUP_LEADS"] == (learning or lag > 0.0)


def test_what_a_slow_drive_costs_is_said() -> None:
    grip = GripSettings(drive_lag=0.01, burst_rate=20.0)
    assert describe_lag(0.033, grip) == (
        "lag 33 ms, configured 10 ms; 15 ms of it are led, for the rest 15 % more is held, "
        "which a quicker drive would not need"
    )
    assert describe_lag(0.004, grip) == "lag 4 ms, configured 10 ms"
    assert describe_lag(0.015, GripSettings()) == "lag 15 ms"
    assert describe_lag(0.01501, GripSettings()) == "lag 15 ms; 15 ms of it are led"
    assert "for the rest 1 % more is held" in describe_lag(0.0161, GripSettings())  # 0.8 %


def test_a_lag_is_logged_when_it_is_known_and_when_it_has_changed_by_more_than_three_tenths(
    caplog: pytest.LogCaptureFixture,
) -> None:
    log, lags = DriveLog("grip"), (math.nan, 10.0, 7.1, 13.0, 13.1, 10.0, 9.0, 9.0)
    given = iter(lags)
    friction: Any = SimpleNamespace(drive_lag=lambda _: next(given, 5.0))
    logged = []
    with caplog.at_level("INFO", logger="vegrip.grip"):
        for _ in lags:
            log.log_changes("thumb", friction, GripSettings())
            logged.append(len(caplog.records))
        assert logged == [0, 1, 1, 1, 2, 2, 3, 3]
        log.log_changes("index", friction, GripSettings())
    assert caplog.records[-1].getMessage().startswith("drive of index: lag")


def drive(q: GraspMemory) -> tuple[Floats, Floats]:
    """Return the state (L, s, b) of the finger and its covariance."""
    x, p = 3 * FINGER, 9 * FINGER
    return np.array(q.drive.state[x : x + 3]), np.array(q.drive.p[p : p + 9]).reshape(3, 3)


@pytest.mark.parametrize(("rate", "way", "stds"), [(3.0, 1.0, 1.0), (-5.0, -0.4, -2.0), (2.0, 0.0, 9.0)])
def test_a_gap_is_a_kalman_filters_measurement_of_lag_stiction_and_offset(rate, way, stds) -> None:
    """In matrices: walk, innovation of at most three deviations, gain, covariance; the others' stay."""
    q = GraspMemory()
    begin_drives(q, NOISE)
    root = np.diag([4e-3, 8e-3, 2e-2]) @ np.tril(np.array([[1.0, 0, 0], [0.3, 0.9, 0], [-0.5, 0.2, 0.7]]))
    for k, value in enumerate((root @ root.T).ravel()):
        q.drive.p[9 * FINGER + k] = value
    before = q.array.copy()
    x, P = drive(q)
    P += np.diag([3e-4**2 * DT, 0.0, 0.01**2 * DT])
    h = np.array([rate, way, 1.0])
    variance = h @ P @ h + (3.0 * NOISE) ** 2
    off = stds * math.sqrt(variance)
    measure_drive(q, FINGER, DT, rate, way, h @ x + off)
    gain = P @ h / variance
    after, covariance = drive(q)
    moved = x + gain * min(max(off, -3.0 * math.sqrt(variance)), 3.0 * math.sqrt(variance))
    assert after == pytest.approx([moved[0], min(max(moved[1], 0.0), 0.5), moved[2]], rel=1e-12)
    assert covariance == pytest.approx(P - np.outer(gain, h @ P), rel=1e-12, abs=1e-18)
    fade = 1.0 - math.exp(-DT / 0.3)
    assert q.drive.misfit[FINGER] == pytest.approx(fade * min(abs(off), 0.5))
    restored = GraspMemory()
    restored.array[:] = q.array
    begin, own = 3 * FINGER, GraspMemory()
    own.array[:] = before
    for k in range(9):
        restored.drive.p[9 * FINGER + k] = own.drive.p[9 * FINGER + k]
    for k in range(begin, begin + 3):
        restored.drive.state[k] = own.drive.state[k]
    restored.drive.misfit[FINGER] = own.drive.misfit[FINGER]
    assert np.array_equal(restored.array, before)


def test_what_is_known_of_a_drive_fades_to_what_was_known_at_the_beginning() -> None:
    q = GraspMemory()
    begin_drives(q, NOISE)
    _, first = drive(q)
    assert first == pytest.approx(np.diag([0.015**2, 0.02**2, 0.05**2]))
    measure_drive(q, FINGER, 1e9, 0.0, 0.0, 0.0)
    assert drive(q)[1][0] == pytest.approx(first[0])


@pytest.mark.parametrize(
    ("std", "moved", "misfit", "before", "known"),
    [
        (0.99e-3, 4.0, 1.99, 0.0, True),
        (1.03e-3, 4.0, 0.0, 0.0, False),
        (1.03e-3, 4.0, 0.0, 1.0, True),
        (1.99e-3, 4.0, 0.0, 1.0, True),
        (2.06e-3, 4.0, 0.0, 1.0, False),
        (0.0, 3.99, 0.0, 1.0, False),
        (0.0, 4.0, 2.01, 1.0, False),
    ],
)
def test_a_lag_is_known_where_it_is_sure_was_moved_and_explains(std, moved, misfit, before, known) -> None:
    """At a lag of 9 ms a tenth of what is told, 10.03 ms, and a fifth of it once it was known."""
    q = GraspMemory()
    begin_drives(q, NOISE)
    q.drive.state[3 * FINGER], q.drive.p[9 * FINGER] = 9e-3, std**2
    q.drive.moved[FINGER], q.drive.misfit[FINGER], q.drive.known[FINGER] = moved, misfit * NOISE, before
    judge_drive(q, FINGER, DT)
    assert q.drive.lag[FINGER] == pytest.approx(10.037e-3, rel=1e-3)
    assert math.isnan(measured_lag(q, FINGER)) != known


def test_the_rate_that_a_drive_was_seen_to_follow_with_is_the_fastest_of_the_last_minute() -> None:
    q = GraspMemory()
    begin_drives(q, NOISE)
    q.drive.force[FINGER] = 1.0
    force = 1.0
    for _ in range(200):  # 40 N/s behind a command that is ahead
        force += 40.0 * DT
        watch_rate(q, FINGER, DT, force + 0.3, force)
    assert q.drive.seen[FINGER] == pytest.approx(40.0, rel=1e-3)
    for _ in range(50):  # away from the command
        force += 90.0 * DT
        watch_rate(q, FINGER, DT, force - 0.3, force)
    assert q.drive.seen[FINGER] == pytest.approx(40.0, rel=5e-3)
    watch_rate(q, FINGER, 60.0, force, force)
    assert q.drive.seen[FINGER] == pytest.approx(40.0 / math.e, rel=1e-2)


def test_samples_count_only_after_a_rest_in_a_slow_motion_that_the_force_follows() -> None:
    def after(commands: list[float], lag: float = 0.0) -> float:
        q = GraspMemory()
        begin_drives(q, NOISE)
        for command in commands:
            follow_drive(q, FINGER, DT, command, command - lag)
        return q.drive.moved[FINGER]

    ramp = [2.0 + 4.0 * DT * k for k in range(60)]
    assert after(ramp[:5]) == 0.0  # 10 ms of rest first
    moved = [after(ramp[:n]) for n in (20, 40, 60)]
    assert 0.0 < moved[0] < moved[1] < moved[2]
    assert moved[2] - moved[1] <= 4.0 * 20 * DT  # the path of the model
    assert after([2.0 + 0.45 * DT * k for k in range(60)]) == 0.0  # too slow to tell
    assert after([2.0 + 12.5 * DT * k for k in range(60)]) == 0.0  # perhaps at its rate limit
    assert after(ramp, 0.51) == 0.0  # does not listen
    assert after([*ramp[:30], math.nan, *ramp[30:34]]) == pytest.approx(after(ramp[:30]))


@pytest.mark.parametrize("slope", [4.0, -6.0])
def test_in_a_steady_motion_the_model_moves_as_the_command_which_comes_from_one_side(
    monkeypatch, slope
) -> None:
    q, told = GraspMemory(), []
    begin_drives(q, NOISE)
    monkeypatch.setattr(drive_lag, "measure_drive", lambda *given: told.append(given[1:]))
    for k in range(120):
        command = 5.0 + slope * DT * k
        follow_drive(q, FINGER, DT, command, command - 0.3)
    late = 1.0 - DT / 0.015 / (math.exp(DT / 0.015) - 1.0)  # the model is moved sample by sample
    moves = pytest.approx(slope * (1.0 - late), rel=1e-3)
    assert told[-1] == (FINGER, DT, moves, pytest.approx(math.copysign(1.0, slope)), pytest.approx(0.3))
    assert q.drive.moved[FINGER] == pytest.approx(sum(abs(one[2]) * DT for one in told))


def test_a_force_that_is_far_off_twice_is_where_the_model_goes_on() -> None:
    q = GraspMemory()
    begin_drives(q, NOISE)
    for k, (force, model) in enumerate(
        [(2.0, 2.0), (2.0, 2.0), (2.0, 2.0), (1.49, 2.0), (1.4, 1.4), (1.5, None)]
    ):
        follow_drive(q, FINGER, 0.0075, 2.0, force)
        if k == 2:
            assert q.drive.wait[FINGER] == 0.0
        assert q.drive.model[FINGER] == pytest.approx(2.0 - 0.6 * math.exp(-0.5) if model is None else model)


def test_drives_that_begin_anew_have_nothing_of_what_was_before() -> None:
    used, fresh = GraspMemory(), GraspMemory()
    used.array[:] = 7.0
    for q in (used, fresh):
        begin_drives(q, NOISE)
    for name in ("lag", "known", "begun", "moved", "misfit", "seen", "state", "p"):
        assert list(getattr(used.drive, name)) == list(getattr(fresh.drive, name)), name
    assert used.drive.noise == NOISE


@pytest.mark.parametrize(
    "sample",
    [(DT, 2.0, math.inf), (DT, math.inf, 2.0), (DT, -math.inf, math.inf), (DT, 2.0, math.nan),
     (0.0, 2.0, 2.0), (-DT, 2.0, 2.0), (0.0501, 2.0, 2.0)],
)  # fmt: skip
def test_a_sample_that_is_no_number_or_too_late_begins_anew(sample: tuple[float, float, float]) -> None:
    q = GraspMemory()
    begin_drives(q, NOISE)
    follow_drive(q, FINGER, 0.05, 2.0, 2.0)  # the longest gap still counts
    assert q.drive.begun[FINGER] == 1.0
    follow_drive(q, FINGER, *sample)
    assert q.drive.begun[FINGER] == 0.0
    follow_drive(q, FINGER, DT, 3.0, 2.5)
    begun = (q.drive.command, q.drive.play, q.drive.model, q.drive.force)
    assert [one[FINGER] for one in begun] == [3.0, 3.0, 2.5, 2.5]
    assert q.drive.slope[FINGER] == 0.0
