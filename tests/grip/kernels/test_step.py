"""The step of a finger as a whole, in plain Python: frames, messages and parts agree, and ticks renew."""

import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest

from tests.grip.stages import MODEL
from vegrip import ContactEstimator, SensorNoise
from vegrip.estimator import EstimatorSettings
from vegrip.grip.finger import GraspFinger
from vegrip.grip.finger_step import Place
from vegrip.grip.grasp_memory import GraspMemory
from vegrip.grip.safety import LimitSettings
from vegrip.grip.settings import ControlSettings
from vegrip.grip.wires import COMMANDED, LEFT_ALONE, REPORT
from vegrip.messages import Condition, FingertipState, ForceCommand, Reason
from vegrip.transport.codec import CanCodec, Frame

MS = 1_000_000
START = 7_000 * MS
STATES = 12
SETTINGS = ControlSettings(limits=LimitSettings(lifetime=0.1))
"""A command lives for 0.1 s: it is renewed after 25 ms."""


def state(k: int, force: float = 2.0) -> FingertipState:
    """Return the k-th state at 500 Hz: pressed, and loaded more and more."""
    wobble = 0.01 * math.sin(7.0 * k)
    return FingertipState(START + 2 * MS * k, "index", k + 1, force + wobble, 0.3 + 0.02 * k, 0.1 * wobble,
                          1e-4 * wobble, 1e-3 + 1e-5 * wobble, slip=0.0)  # fmt: skip


@pytest.fixture(autouse=True, scope="module")
def plain() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VEGRIP_KERNEL", "python")
        yield


class Finger:
    """A finger alone in its grasp, in plain Python, and the bytes it sends and is sent."""

    def __init__(self, *, alone: bool = False) -> None:
        self.codec = CanCodec(("index",), fd=True, use_sender_time=True)
        self.sender, self.reader = (CanCodec(("index",), fd=True, use_sender_time=True) for _ in range(2))
        settings = EstimatorSettings(late=0) if alone else EstimatorSettings(late=2)
        estimator = ContactEstimator(MODEL, SensorNoise(), settings)
        self.finger = GraspFinger(
            "index", estimator, SETTINGS, Place(0, 1, -1), GraspMemory(1),
            line=self.codec.line("index"), mode="python", alone=alone,
        )  # fmt: skip
        self.memory, self.numbers = self.finger.memory, self.finger.numbers
        assert self.finger.take_line()

    def bytes_of(self, one: FingertipState) -> tuple[np.ndarray, int]:
        (frame,) = self.sender.encode(one)
        room = np.zeros(64, dtype=np.uint8)
        room[: len(frame.data)] = np.frombuffer(frame.data, dtype=np.uint8)
        return room, len(frame.data)

    def step(self, one: FingertipState) -> int:
        return self.finger.step(*self.bytes_of(one), one.stamp, one.stamp)

    def call(self, entry: str, *given: Any) -> int:
        memory, shared = self.memory, self.numbers.shared.array
        done: int = getattr(self.numbers.module, entry)(memory.f, memory.t, shared, *given)
        return done

    def command(self) -> ForceCommand:
        data = self.numbers.answer_frame.tobytes()
        found = self.reader.decode(Frame(self.numbers.on_wire.command_id, data, True, START))
        assert isinstance(found, ForceCommand)
        return found

    def left(self) -> tuple[bytes, bytes, bytes]:
        """Return all that there is of the finger, without the counter of frames."""
        whole = self.memory.t.copy()
        for name in ("LINE_LAST", "LINE_STAMP", "LINE_LOST", "SETUP_EXPIRES"):
            whole[self.memory.layout.wholes[name]] = 0
        return self.memory.f.tobytes(), whole.tobytes(), self.numbers.shared.array.tobytes()


@pytest.fixture(scope="module")
def stepped() -> Finger:
    """Give a finger that has met all states as frames."""
    one = Finger()
    assert all(one.step(state(k)) & COMMANDED for k in range(STATES))
    return one


def singles(one: FingertipState) -> FingertipState:
    """Return what is left of a state in single precision, as in a frame."""
    return one._replace(**{  # type: ignore[attr-defined, no-any-return]
        name: float(np.float32(getattr(one, name)))
        for name in ("normal_force", "tangential_force_x", "tangential_force_y", "torque_z", "displacement")
    })  # fmt: skip


def test_the_steps_of_a_sample_stand_in_the_page_as_they_are_taken() -> None:
    page = (Path(__file__).parents[3] / "docs" / "architecture.md").read_text(encoding="utf-8")
    said = [
        name
        for names in re.findall(r"`vegrip/(?:grip|estimator)/kernels/\w+\.py`: ((?:`\w+`(?:, )?)+)", page)
        for name in re.findall(r"\w+", names)
    ]
    one, taken = Finger(), []
    for k in range(8):
        one.step(state(k))

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_name not in taken:
            taken.append(frame.f_code.co_name)

    sys.setprofile(note)
    one.step(state(8))
    sys.setprofile(None)
    others = {"asked_force", "hold_then_ramp"}  # of another policy, after a fault
    assert len(said) > 12
    assert [name for name in said if name not in others] == [
        name for name in taken if name in said and name not in others
    ]


def test_a_message_is_answered_as_its_frame(stepped: Finger) -> None:
    other = Finger()
    for k in range(STATES):
        other.finger.answer(singles(state(k)), state(k).stamp)
    assert other.left() == stepped.left()


def test_the_parts_of_the_step_one_after_another_are_the_step(stepped: Finger) -> None:
    other = Finger()
    for k in range(STATES):
        one = singles(state(k))
        other.numbers.put(one)
        if k % 2:
            believed = other.numbers.sense(one.seq, one.stamp, one.stamp)
        else:
            believed = other.numbers.judge(one.seq, one.stamp, one.stamp)
            assert other.numbers.take(one.stamp)
            is_asked = bool(other.numbers.bound(one.stamp))
            assert is_asked == (other.finger.condition <= Condition.DEGRADED)
            assert other.numbers.need(one.stamp)
        assert believed
        assert other.finger.settle(one.stamp) & COMMANDED
    for name in ("OWN_BASE", "OWN_STEP"):  # said to a policy in Python alone
        other.memory[name] = stepped.memory[name]
    assert other.left() == stepped.left()


def test_the_frame_of_a_command_says_what_is_held_and_when_it_expires(stepped: Finger) -> None:
    said, last = stepped.command(), state(STATES - 1)
    assert said.normal_force == pytest.approx(stepped.finger.held, rel=1e-6)
    assert (said.stamp, said.expires - said.stamp) == (last.stamp, 100 * MS)
    assert said.reason == stepped.finger.command().reason


@pytest.mark.parametrize(("silence", "anew"), [(200 * MS, False), (260 * MS, True)])
def test_after_a_silence_in_which_the_contact_is_lost_the_force_that_is_there_is_taken_over(
    silence: int, anew: bool
) -> None:
    """The estimate takes a pause of up to 0.25 s for one of its samples."""
    one = Finger()
    for k in range(STATES):
        one.step(state(k))
    began = one.memory["TURN_TRANSFER_SINCE"]
    for k in range(STATES, 2 * STATES):
        late = state(k)._replace(stamp=state(k).stamp + silence)  # type: ignore[attr-defined]
        one.step(late)
    assert (one.memory["TURN_TRANSFER_SINCE"] > began) == anew
    if anew:
        assert one.memory["TRANSFER_FORCE"] == pytest.approx(2.0, abs=0.02)


def test_the_first_command_is_the_force_that_is_there_or_where_none_is_measured_that_is_estimated() -> None:
    measured, pressed = Finger(), Finger()
    measured.step(state(0))
    assert measured.command().normal_force == pytest.approx(state(0).normal_force, rel=1e-6)
    pressed.step(state(0)._replace(normal_force=math.nan))  # type: ignore[attr-defined]
    assert pressed.command().normal_force == pytest.approx(pressed.memory["REP_FORCE"], rel=1e-6)


def test_counters_of_frames_go_with_who_reads_them() -> None:
    one = Finger()
    frames = [one.sender.encode(state(k))[0]._replace(stamp=state(k).stamp) for k in range(3)]
    for frame in frames[:2]:
        room = np.zeros(64, dtype=np.uint8)
        room[: len(frame.data)] = np.frombuffer(frame.data, dtype=np.uint8)
        assert one.finger.step(room, len(frame.data), frame.stamp, frame.stamp) & COMMANDED
    one.numbers.leave_line()
    assert one.codec.decode(frames[1]) is None
    assert one.codec.rejected == {"counter": 1}
    assert one.codec.decode(frames[2]) is not None
    assert one.codec.lost == 0


def test_before_a_state_is_believed_there_is_no_command() -> None:
    one = Finger()
    nothing = {"normal_force": math.nan, "displacement": math.nan}
    done = one.step(state(0)._replace(**nothing))  # type: ignore[attr-defined]
    assert done != LEFT_ALONE
    assert not done & COMMANDED
    assert not one.finger.started
    assert one.finger.condition is Condition.MISSING
    assert not one.finger.watch(START + MS)


def test_a_frame_that_is_not_welcome_changes_nothing() -> None:
    one = Finger()
    one.step(state(0))
    room, length = one.bytes_of(state(1))
    room[20] ^= 1
    before = one.left()
    assert one.finger.step(room, length, START + MS, START + MS) == LEFT_ALONE
    assert one.finger.step(room, length - 1, START + MS, START + MS) == LEFT_ALONE
    assert one.left() == before


def ticked(one: Finger, ms: int) -> int:
    return one.call("finger_tick", START + ms * MS, one.numbers.answer_frame)


def watched(one: Finger, ms: int) -> int:
    """Tick as a node does: look at the clock, and settle where a command is due."""
    now = START + ms * MS
    return one.finger.settle(now) if one.finger.watch(now) else LEFT_ALONE


@pytest.mark.parametrize("tick", [ticked, watched])
def test_a_command_is_renewed_from_a_quarter_of_its_life_on_and_after_a_silence_never_falls(tick) -> None:
    one = Finger()
    assert [bool(one.step(state(k)) & COMMANDED) for k in range(-5, 1)] == [True] * 6
    first = one.finger.command()
    assert tick(one, 24) == LEFT_ALONE
    assert tick(one, 25) & COMMANDED
    renewed = one.finger.command()
    assert (renewed.stamp, renewed.seq) == (START + 25 * MS, first.seq + 1)
    assert renewed.normal_force == first.normal_force
    assert one.finger.condition is Condition.OK
    forces, reasons = [first.normal_force], []
    for ms in range(51, 900, 26):  # stale after 50 ms, held for 0.25 s, then 10 N/s
        assert tick(one, ms) & COMMANDED
        forces.append(one.finger.held)
        reasons.append(one.finger.command().reason)
    assert one.finger.condition is Condition.STALE
    assert forces == sorted(forces)
    assert forces[-1] == 5.0
    assert reasons[0] is Reason.INPUT_HOLD
    assert Reason.FAIL_SAFE in reasons


def test_a_fault_of_the_node_itself_is_ridden_out_by_the_clock() -> None:
    one = Finger()
    one.step(state(0))
    assert not one.finger.hold_last(START + 24 * MS)
    forces = [one.finger.held]
    for ms in range(25, 900, 25):
        assert one.finger.hold_last(START + ms * MS)
        one.finger.settle(START + ms * MS)
        forces.append(one.finger.held)
    assert forces == sorted(forces)
    assert forces[-1] == 5.0


def test_what_was_met_is_kept_for_those_who_look_back_and_asked_for_when_half_of_it_waits(stepped) -> None:
    assert [one.seq for one in stepped.numbers.past.after(-1)] == [k + 1 for k in range(STATES)]
    one = Finger()
    one.memory["TURN_REPORT_DUE"] = START + 10**12
    one.memory["TURN_REPORTED_CONDITION"] = int(Condition.MISSING)
    assert not one.step(state(0)) & REPORT
    one.memory["TURN_FETCHED"] = one.memory["TURN_NOTED"] - 1000
    assert one.step(state(1)) & REPORT


def received(one: Finger, room: np.ndarray, length: int, now: int) -> int:
    return one.call("finger_receive", room, length, now, now, one.numbers.answer_frame)


def test_firmware_answers_a_frame_notes_a_broken_one_and_leaves_a_repeat() -> None:
    one = Finger(alone=True)
    room, length = one.bytes_of(state(0))
    assert received(one, room, length, START) & COMMANDED
    assert received(one, room, length, START) == LEFT_ALONE
    assert one.memory["INPUT_IS_CORRUPT"] == 0
    room, length = one.bytes_of(state(1))
    room[30] ^= 4
    assert received(one, room, length, START + 40 * MS) == LEFT_ALONE
    one.call("finger_tick", START + 60 * MS, one.numbers.answer_frame)
    assert one.finger.condition is Condition.CORRUPT


def test_firmware_that_has_met_nothing_has_nothing_to_say() -> None:
    one = Finger(alone=True)
    nothing = {"normal_force": math.nan, "displacement": math.nan}
    room, length = one.bytes_of(state(0)._replace(**nothing))  # type: ignore[attr-defined]
    assert not received(one, room, length, START) & COMMANDED
    assert one.call("finger_tick", START + 40 * MS, one.numbers.answer_frame) == LEFT_ALONE
