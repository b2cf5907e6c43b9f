"""The running node notices that its model fails, says where, and names who may be behind it."""

import io
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from vegrip.nodes.grasp_force import build

from validation.health_detection import fit_finger, run_estimator
from vegrip.estimator.health import NO_CELL, HealthHysteresis
from vegrip.grip import background_diagnosis
from vegrip.grip.background_diagnosis import BackgroundDiagnosis, KeptStates, SampleRing
from vegrip.grip.model_swap import ModelSwap
from vegrip.host.realtime import SideTask
from vegrip.identification.diagnosis.error_ladder import add_effect
from vegrip.identification.fit import fit
from vegrip.identification.recording import Fingertip, Recording
from vegrip.messages import BEYOND_FIT, FingertipState, ForceCommand, ModelHealth
from vegrip.model import paper_model, write_model
from vegrip.runtime import NodeContext
from vegrip.virtual import FingertipSettings

TIP = FingertipSettings(
    radius=8e-3, reference_force=2.0, amplitudes=(0.25,), rates=(3.0,), bristle_stiffness=1e10
)
HIDDEN = {
    "nothing": {},
    "adhesion": {"adhesion": {"force": 0.05}},
    "second_relaxation": {"second_relaxation": {"amplitude": 0.3, "rate": 0.2}},
}
NOISE = {"normal_force": 0.01, "displacement": 5e-6, "tangential_force": 0.01, "torque_z": 1e-4}


@cache
def contacts_of(hidden: str, count: int, seed: int = 0) -> tuple[FingertipState, ...]:
    """Return what the fingertip feels in a number of contacts."""
    return tuple(run_estimator(TIP, count, seed, HIDDEN[hidden]))


@cache
def model():
    """Return the model of the fingertip, from contacts in which nothing is hidden."""
    return fit_finger(TIP, 1)


def health_of(node, states) -> list[ModelHealth]:
    """Feed a node; return what it said of its model. Each state must get its command."""
    told = []
    for state in states:
        answers = [*node.on_message(state, state.stamp), *node.on_tick(state.stamp)]
        assert any(isinstance(m, ForceCommand) for m in answers)
        told += [m for m in answers if isinstance(m, ModelHealth)]
    return told


def mean_nis(told) -> float:
    return float(np.mean([one.nis for one in told]))


@pytest.fixture
def node(tmp_path):
    write_model(model(), tmp_path / "tip.toml")
    settings = {"tip": {"model": str(tmp_path / "tip.toml")}, "noise": NOISE, "policy": "constant"}
    made = build(settings, NodeContext("grasp_force", "", ("index",), 0.004))
    made.configure()
    made.activate()
    return made


@pytest.mark.long
def test_with_nothing_hidden_it_stays_quiet_and_starts_no_process(node) -> None:
    told = health_of(node, contacts_of("nothing", 10, 2))
    assert all(one.consistent for one in told[50:])
    assert not any(one.suspect or (one.channel and one.regime != BEYOND_FIT) for one in told)
    assert node.diagnoser.busy is None


class AtOnce(SideTask):
    """A side task that is done before the loop goes on: what it looks at is no matter of the machine."""

    def start(self) -> None:
        super().start()
        self.join()


@pytest.mark.long
def test_it_names_the_regime_and_the_suspect_after_some_contacts(node, monkeypatch) -> None:
    states = contacts_of("adhesion", 14, 6)  # with seed 4 two effects explain it alike
    monkeypatch.setattr(background_diagnosis, "SideTask", AtOnce)
    monkeypatch.setattr(background_diagnosis, "FAILING_FOR_S", 1e6)
    told = health_of(node, states[:-1000])
    monkeypatch.setattr(background_diagnosis, "FAILING_FOR_S", 2.0)
    told += health_of(node, states[-1000:])
    failing = [one for one in told if one.channel]
    assert failing
    assert failing[-1].channel == "normal_force"
    assert failing[-1].regime == "air"
    assert not failing[-1].consistent
    assert node.diagnoser.busy is not None
    last = states[-1]
    again = node.diagnoser.annotate(replace(failing[-1], stamp=last.stamp))
    assert again.suspect == "adhesion"


@pytest.mark.long
def test_a_running_node_takes_the_extended_model_over_and_its_innovations_fall_as_the_error_did(
    node, monkeypatch, tmp_path
) -> None:
    threads = []
    begin = ModelSwap.begin
    monkeypatch.setattr(ModelSwap, "begin", lambda self, *given: threads.append(begin(self, *given)))
    monkeypatch.setattr(background_diagnosis, "FAILING_FOR_S", 1e6)
    hidden = "second_relaxation"
    before = health_of(node, contacts_of(hidden, 10, 5))
    evidence = node.diagnoser._samples["index"].columns()
    t = evidence.pop("t")
    episode = np.zeros(t.size, dtype=np.int64)
    recording = Recording("felt", t, episode, evidence, Fingertip(TIP.radius), NOISE)
    after, offline = add_effect(hidden, fit(recording, model()))
    write_model(after.model, tmp_path / "extended.toml")
    tip = replace(node.parameters.tip, model=str(tmp_path / "extended.toml"))
    node.parameters = replace(node.parameters, tip=tip)
    threads[0].join()
    later = [replace(s, stamp=s.stamp + 10**12, seq=s.seq + 10**6) for s in contacts_of(hidden, 10, 6)]
    told = health_of(node, later)
    half = len(told) // 2
    assert any(one.channel for one in before)
    assert not any(one.channel for one in told[1:])  # the first was of the old model
    assert offline.error > 1.1
    assert mean_nis(before[half:]) > 1.1
    assert after.error < 1.05
    assert mean_nis(told[half:]) < 1.05
    assert "second_relaxation" in [e.name for e in node.fingers["index"].estimator.model.effects]


def test_the_verdict_comes_after_a_while_and_goes_after_a_longer_one() -> None:
    watch, now = HealthHysteresis(), 0
    assert watch.update(14, 1.2, 0.0, now) == NO_CELL
    assert watch.update(14, 1.2, 0.0, now + 500_000_000) == 14
    now += 10**9
    assert watch.update(14, 0.9, 0.9, now) == 14  # between calm and the edge it stays
    now += 10**11
    assert watch.update(14, 0.9, 0.9, now) == 14
    assert watch.update(2, 0.4, 0.1, now) == 14
    assert watch.update(2, 0.4, 0.1, now + 9_000_000_000) == 14
    assert watch.update(2, 0.4, 0.1, now + 10_000_000_000) == NO_CELL


def test_a_single_look_a_little_outside_changes_nothing_and_one_far_outside_does() -> None:
    watch = HealthHysteresis()
    for i in range(100):
        assert watch.update(14, 1.5 if i % 2 else 0.1, 0.0, i * 200_000_000) == NO_CELL
    assert watch.update(14, 2.5, 0.0, 10**11) == 14


def test_another_cell_takes_over_only_when_it_is_clearly_worse() -> None:
    watch = HealthHysteresis()
    watch.update(14, 1.2, 0.0, 0)
    watch.update(14, 1.2, 0.0, 10**9)
    assert watch.update(1, 1.3, 1.2, 2 * 10**9) == 14
    assert watch.update(1, 2.0, 1.2, 3 * 10**9) == 1


def state(i: int, period: int = 2_000_000, **values: float) -> FingertipState:
    return FingertipState(
        i * period, "index", i, **{"normal_force": float(i), "displacement": 1e-3 * i} | values
    )


def kept(count: int, touching: Callable[[int], bool], period: int = 2_000_000) -> KeptStates:
    states = [state(i, period) for i in range(count)]
    values = np.array([[*one[3:], float(touching(i))] for i, one in enumerate(states)])
    return KeptStates("index", np.array([one.stamp for one in states]), np.arange(count), values)


def test_evidence_is_thinned_bounded_and_without_long_air(monkeypatch) -> None:
    monkeypatch.setattr(background_diagnosis, "RING_SAMPLES", 100)
    ring = SampleRing()
    ring.note(kept(3000, lambda i: i % 700 > 350))
    columns = ring.columns()
    assert len(ring) == 100
    assert columns["t"].size <= 100
    assert np.all(np.diff(columns["t"]) >= 0.005)
    assert columns["normal_force"][-1] == pytest.approx(2998.0, abs=3)
    assert set(columns) == {"t", "normal_force", "displacement"}
    quiet = SampleRing()
    quiet.note(kept(3000, lambda _: False))
    assert len(quiet) == 0
    assert quiet.columns()["t"].size == 0


def test_evidence_begins_in_the_middle_of_a_true_stay_in_the_air() -> None:
    ring = SampleRing()
    ring.note(kept(2000, lambda i: (i < 500 and not 300 < i < 320) or i > 700))  # lost for a moment
    assert ring.columns()["normal_force"][0] == pytest.approx(600.0, abs=4)
    short = SampleRing()  # where none is long, the longest
    short.note(kept(200, lambda i: not (30 <= i < 35 or 100 <= i < 120 or 150 <= i < 160), 6_000_000))
    assert short.columns()["normal_force"][0] == 110.0


@pytest.mark.parametrize(("period", "second"), [(6_000_000, 166), (5_000_000, 200)])
@pytest.mark.parametrize("air", [500, 517])
def test_of_a_long_air_the_second_after_the_contact_and_the_end_are_kept(period, second, air) -> None:
    """At 6 ms a second is 166 rows, at 5 ms 200; 32 stand before the next contact, however long it is."""
    ring = SampleRing()
    ring.note(kept(400 + air, lambda i: not 100 <= i < 100 + air, period))
    rows = [*range(100, 100 + second), *range(100 + air - 32, 100 + air)]
    expected = [*rows[len(rows) // 2 :], *range(100 + air, 400 + air)]
    assert ring.columns()["normal_force"].tolist() == expected


def test_ten_thousand_samples_are_kept_one_every_five_milliseconds() -> None:
    ring, count = SampleRing(), 10_003
    ring.note(KeptStates("index", 5_000_000 * np.arange(count), np.arange(count), np.ones((count, 10))))
    assert len(ring) == 10_000
    assert ring.columns()["t"] == pytest.approx(0.005 * np.arange(10_000))


def test_evidence_counts_its_seconds_from_its_first_row_to_the_stamp_that_is_asked_for() -> None:
    ring = SampleRing()
    ring.note(kept(100, lambda i: i >= 20, 6_000_000))
    columns = ring.columns(50 * 6_000_000)
    assert columns["t"] == pytest.approx(0.006 * np.arange(41))
    assert columns["normal_force"].tolist() == [*range(10, 51)]  # from the middle of the air


def test_a_stamp_that_comes_twice_is_there_once_and_with_an_earlier_one_evidence_begins_anew() -> None:
    ring, felt = SampleRing(), kept(50, lambda _: True, 6_000_000)
    ring.note(felt)
    ring.note(KeptStates("index", felt.stamps[-1:], felt.numbers[-1:], felt.values[-1:]))
    assert ring.columns()["normal_force"].tolist() == [*range(50)]
    ring._stamps[7] = ring._stamps[6]  # as a reader may find it while the loop goes on
    assert ring.columns()["normal_force"].tolist() == [*range(7), *range(8, 50)]
    ring.note(kept(3, lambda _: True, 6_000_000))
    assert ring.columns()["normal_force"].tolist() == [0.0, 1.0, 2.0]


def test_evidence_in_which_the_touch_never_ends_is_all_there() -> None:
    ring = SampleRing()
    ring.note(kept(100, lambda _: True))
    assert ring.columns()["normal_force"][0] == 0.0


def test_what_comes_after_the_question_is_left_out() -> None:
    ring = SampleRing()
    ring.note(kept(2000, lambda i: i > 100))
    assert ring.columns(state(1000).stamp)["normal_force"][-1] == pytest.approx(1000.0, abs=3)


def failing(stamp: int) -> ModelHealth:
    return ModelHealth(stamp, "index", 0, channel="normal_force", regime="air")


@pytest.fixture
def inquiries(monkeypatch):
    """A diagnosis with enough samples, whose process answers at once."""
    asked = []

    def answer(columns, model, noise):
        asked.append(columns["t"].size)
        return "adhesion"

    monkeypatch.setattr(background_diagnosis, "diagnose_in_subprocess", answer)
    made = BackgroundDiagnosis(lambda: {"index": None}, NOISE, "node")
    made.note(kept(5000, lambda i: i % 100 > 20, 6_000_000))
    made.asked = asked
    return made


def test_it_asks_once_in_a_while_and_forgets_with_the_model(inquiries) -> None:
    t = 10**12
    assert inquiries.annotate(failing(t)).suspect == ""
    assert inquiries.busy is None
    inquiries.annotate(failing(t + 11 * 10**9))
    inquiries.busy.join()
    assert inquiries.annotate(failing(t + 12 * 10**9)).suspect == "adhesion"
    assert inquiries.annotate(failing(t + 60 * 10**9)).suspect == "adhesion"
    assert len(inquiries.asked) == 1
    inquiries.annotate(failing(t + 140 * 10**9))
    inquiries.busy.join()
    assert len(inquiries.asked) == 2
    inquiries.forget("index")
    assert inquiries.annotate(failing(t + 141 * 10**9)).suspect == ""
    healthy = ModelHealth(t + 150 * 10**9, "index", 0, consistent=True)
    assert inquiries.annotate(healthy) == healthy


SECOND, LATER = 10**9, 10**12


def looked_at(inquiries, healths) -> list[float]:
    """Return after how many seconds the look began, of those at which the health is told."""
    begun = []
    for health in healths:
        before = len(inquiries.asked)
        inquiries.annotate(health)
        if inquiries.busy is not None:
            inquiries.busy.join()
        begun += [(health.stamp - LATER) / SECOND] * (len(inquiries.asked) - before)
    return begun


def test_what_fails_for_ten_seconds_is_looked_at_and_again_after_two_minutes(inquiries, caplog) -> None:
    after = (0, 10 * SECOND - 1, 10 * SECOND, 130 * SECOND - 1, 130 * SECOND)
    with caplog.at_level("INFO"):
        assert looked_at(inquiries, [failing(LATER + one) for one in after]) == [10.0, 130.0]
    assert [record.getMessage() for record in caplog.records] == ["index: adhesion"] * 2


@pytest.mark.parametrize("good", [{"consistent": True}, {"consistent": False, "channel": ""}])
def test_once_nothing_fails_the_ten_seconds_begin_anew(inquiries, good) -> None:
    healths = [failing(LATER + i * SECOND) for i in range(22)]
    healths[9] = replace(healths[9], **good)
    assert looked_at(inquiries, healths) == [20.0]
    assert inquiries.annotate(healths[9]) is healths[9]


def test_nothing_is_looked_at_before_four_thousand_samples_or_while_a_look_goes_on(inquiries) -> None:
    count = 4000
    felt = KeptStates("index", 5_000_000 * np.arange(count), np.arange(count), np.ones((count, 10)))
    first, last = (
        KeptStates("index", felt.stamps[part], felt.numbers[part], felt.values[part])
        for part in (slice(0, -1), slice(-1, None))
    )
    inquiries._samples.clear()
    assert looked_at(inquiries, [failing(LATER - 20 * SECOND), failing(LATER - SECOND)]) == []
    inquiries.note(first)
    assert looked_at(inquiries, [failing(LATER), failing(LATER + 20 * SECOND)]) == []
    inquiries.note(last)
    inquiries.busy = SimpleNamespace(is_alive=lambda: True, join=lambda: None)
    assert looked_at(inquiries, [failing(LATER + 21 * SECOND)]) == []
    inquiries.busy = None
    assert looked_at(inquiries, [failing(LATER + 22 * SECOND)]) == [22.0]


@pytest.mark.parametrize(("said", "reason"), [("one\ntwo\n", "two"), (" ", "it died")])
def test_a_process_that_diagnoses_gets_ten_minutes_and_the_noise_that_is_known(
    said, reason, monkeypatch
) -> None:
    asked, done = [], SimpleNamespace(returncode=0, stdout="adhesion\n", stderr=said)

    def run(worker, sensors, *, patience, given):
        asked.append((worker, sensors, patience))
        assert np.load(io.BytesIO(given))["t"].tolist() == [0.0, 1.0]
        return done

    monkeypatch.setattr(background_diagnosis, "run_behind", run)
    noise = {
        "normal_force": 0.01,
        "torque_z": 0.0,
        "displacement": np.inf,
        "temperature": np.nan,
        "slip": 0.5,
    }
    given = {"t": np.array([0.0, 1.0])}, paper_model(8e-3), noise
    assert background_diagnosis.diagnose_in_subprocess(*given) == "adhesion"
    done.returncode = 1
    with pytest.raises(RuntimeError, match=f"^{reason}$"):
        background_diagnosis.diagnose_in_subprocess(*given)
    assert (
        asked == [("vegrip.runtime.workers.diagnosis_worker", ["normal_force=0.01", "slip=0.5"], 600.0)] * 2
    )


def test_a_look_that_fails_is_logged_and_nothing_else(inquiries, monkeypatch, caplog) -> None:
    def broken(columns, model, noise):
        raise RuntimeError("it died")

    monkeypatch.setattr(background_diagnosis, "diagnose_in_subprocess", broken)
    inquiries.annotate(failing(0))
    with caplog.at_level("WARNING"):
        inquiries.annotate(failing(20 * 10**9))
        inquiries.busy.join()
    assert "it died" in caplog.text
    assert inquiries.annotate(failing(21 * 10**9)).suspect == ""


def test_without_a_displacement_there_is_nothing_to_compare_and_nothing_is_said(inquiries, caplog) -> None:
    felt = kept(5000, lambda i: i % 100 > 20, 6_000_000)
    felt.values[:, background_diagnosis.CHANNELS.index("displacement")] = np.nan
    inquiries.forget("index")
    made = BackgroundDiagnosis(lambda: {"index": None}, NOISE, "node")
    made.note(felt)
    made.annotate(failing(0))
    with caplog.at_level("INFO"):
        made.annotate(failing(20 * 10**9))
        made.busy.join()
    assert caplog.text == ""
    assert inquiries.asked == []


def test_what_was_suspected_is_said_no_more_once_the_model_has_held(inquiries) -> None:
    assert looked_at(inquiries, [failing(LATER), failing(LATER + 10 * SECOND)]) == [10.0]
    assert inquiries.annotate(failing(LATER + 11 * SECOND)).suspect == "adhesion"
    inquiries.annotate(ModelHealth(LATER + 12 * SECOND, "index", 0, consistent=True))
    assert inquiries.annotate(failing(LATER + 13 * SECOND)).suspect == ""


def test_a_finger_that_gets_another_model_during_the_look_is_told_nothing_of_the_old_one(
    inquiries, monkeypatch, caplog
) -> None:
    def answer(columns, model, noise):
        inquiries.forget("index")
        return "adhesion"

    monkeypatch.setattr(background_diagnosis, "diagnose_in_subprocess", answer)
    with caplog.at_level("INFO"):
        looked_at(inquiries, [failing(LATER), failing(LATER + 10 * SECOND)])
    assert inquiries.annotate(failing(LATER + 11 * SECOND)).suspect == ""
    assert caplog.records == []


@pytest.mark.parametrize(
    ("found", "said"),
    [("adhesion", "adhesion"), ("", "nothing is missing after a fit: the model's values are off")],
)
def test_a_look_sees_what_was_felt_before_it_with_model_and_noise_and_says_what_it_found(
    monkeypatch, caplog, found, said
) -> None:
    seen = []

    def answer(columns, model, noise):
        seen.append((columns["normal_force"][-1], model, noise))
        return found

    monkeypatch.setattr(background_diagnosis, "diagnose_in_subprocess", answer)
    made = BackgroundDiagnosis(lambda: {"thumb": "other", "index": "own"}, NOISE, "node")
    made.note(kept(5000, lambda i: i % 100 > 20, 6_000_000))
    made.annotate(failing(0))
    with caplog.at_level("INFO"):
        made.annotate(failing(18 * SECOND))
        made.busy.join()
    assert seen == [(3000.0, "own", NOISE)]  # one each 6 ms, for 18 s
    assert [one.getMessage() for one in caplog.records] == [f"index: {said}"]
    assert made.annotate(failing(19 * SECOND)).suspect == found


def test_without_a_force_there_is_nothing_to_compare_either(inquiries) -> None:
    felt = kept(5000, lambda i: i % 100 > 20, 6_000_000)
    felt.values[:, background_diagnosis.CHANNELS.index("normal_force")] = np.nan
    inquiries._samples.clear()
    inquiries.note(felt)
    assert looked_at(inquiries, [failing(LATER), failing(LATER + 10 * SECOND)]) == []
    assert inquiries.annotate(failing(LATER + 11 * SECOND)).suspect == ""
