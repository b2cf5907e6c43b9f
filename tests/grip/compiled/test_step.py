"""What the compiled finger step does and leaves alone, and that all that run it do the same."""

import ast
from pathlib import Path
from types import SimpleNamespace

import numba
import numpy as np
import pytest
from numba.core.event import install_recorder

import vegrip.estimator.kernels as estimator_kernels
import vegrip.grip.kernels as grip_kernels
from validation.compiled_finger import Answers, Log, Replay, bits_left, hostile
from vegrip.c99 import BYTES, LONGS, MEMORY, host
from vegrip.clock import NS
from vegrip.contact.limit_surface import fast
from vegrip.estimator.layout import layout_of
from vegrip.estimator.memory import CHANNELS
from vegrip.grip.compiled import compile_now
from vegrip.grip.layout import FingerLayout
from vegrip.grip.safety import Ranges
from vegrip.grip.wires import FRAME_ENTRIES, LEFT_ALONE, NODE_ENTRIES
from vegrip.messages import FingertipState
from vegrip.model import paper_model
from vegrip.model.native import kernel_mode

FRAMES = 600


@pytest.fixture(scope="module")
def false_log(hand_log: Log) -> Log:
    log = hostile(hand_log, 3)
    return Log(log.fingers, log.sender_time, log.events[:FRAMES])


@pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
def test_c_and_plain_python_leave_the_same_bits_in_the_whole_memory(false_log: Log) -> None:
    assert bits_left(Replay(false_log, "c")) == bits_left(Replay(false_log, "python"))


@pytest.mark.skipif(kernel_mode() != "numba", reason="numba compiles for a minute; make test-numba")
def test_numba_leaves_the_bits_of_plain_python(false_log: Log) -> None:
    assert bits_left(Replay(false_log, "numba")) == bits_left(Replay(false_log, "python"))


@pytest.mark.skipif(host.compiler() is None, reason="no C compiler")
def test_c_and_plain_python_leave_the_same_bits_of_a_recorded_grasp(hand_log: Log) -> None:
    short = Log(hand_log.fingers, hand_log.sender_time, hand_log.events[: 2 * FRAMES])
    assert bits_left(Replay(short, "c")) == bits_left(Replay(short, "python"))


class OneBitOff(Replay):
    """A node in whose last finger one number changes by its last bit, or that sends one byte otherwise."""

    def __init__(self, log: Log, mode: str, what: str) -> None:
        super().__init__(log, mode)
        self.what = what

    def finish(self) -> Answers:
        memory = list(self.node.compiled_fingers.values())[-1].memory
        if self.what == "commands and reports":
            name, data = self.answers.commands[-1]
            self.answers.commands[-1] = name, bytes([data[0] ^ 1]) + data[1:]
        else:
            (memory.t if "whole" in self.what else memory.f.view(np.int64))[5] ^= 1
        return super().finish()


@pytest.mark.parametrize("what", ["commands and reports", "real numbers", "whole numbers"])
def test_one_bit_in_what_a_node_leaves_is_a_difference(hand_log: Log, mode: str, what: str) -> None:
    short = Log(hand_log.fingers, hand_log.sender_time, hand_log.events[:60])
    (frames, left), (again, other) = (bits_left(one(short, mode, *more)) for one, more in (
        (Replay, ()), (OneBitOff, (what,)),
    ))  # fmt: skip
    assert frames == again > 0
    (unequal,) = (name for name in left if left[name] != other[name])
    assert unequal.endswith(what)


def test_a_frame_that_is_left_alone_has_changed_nothing(hand_log: Log, mode: str) -> None:
    replay = Replay(hand_log, mode)
    for event in hand_log.events[:FRAMES]:
        replay.meet(event)
    event = next(event for event in hand_log.events[FRAMES:] if event.frame is not None)
    assert event.frame is not None
    finger = replay.lines[event.frame.arbitration_id][0]
    one = replay.node.compiled_fingers[finger]
    assert one.take_line()
    shared = replay.node.controller.friction.memory.array
    before = one.memory.f.tobytes(), one.memory.t.tobytes(), shared.tobytes()
    whole = np.zeros(64, dtype=np.uint8)
    whole[:48] = np.frombuffer(event.frame.data, dtype=np.uint8)
    for bit in range(48 * 8):
        broken = whole.copy()
        broken[bit // 8] ^= 1 << bit % 8
        assert one.step(broken, 48, event.frame.stamp, event.now) == LEFT_ALONE
    for length in (0, 8, 47, 49, 64):
        assert one.step(whole, length, event.frame.stamp, event.now) == LEFT_ALONE
    assert (one.memory.f.tobytes(), one.memory.t.tobytes(), shared.tobytes()) == before
    assert one.step(whole, 48, event.frame.stamp, event.now) != LEFT_ALONE
    assert one.step(whole, 48, event.frame.stamp, event.now) == LEFT_ALONE, "the same frame twice"


def test_before_the_first_frame_numba_has_compiled_what_a_node_calls() -> None:
    """Else it would do so within the loop. These functions stand for the module's, which take minutes."""
    finger = FingerLayout(layout_of(paper_model(8e-3)), is_shared=True)
    module = SimpleNamespace(
        finger_step=numba.njit(lambda a, b, c, d, e, f, g, h: (a, b, c, d, e, f, g, h)),
        finger_report=numba.njit(lambda a, b, c, d, e, f: (a, b, c, d, e, f)),
    )
    arrays = {MEMORY: np.zeros(9), LONGS: np.zeros(9, dtype=np.int64), BYTES: np.zeros(64, dtype=np.uint8)}
    compile_now(module, finger, arrays[MEMORY], arrays[LONGS], arrays[BYTES])
    with install_recorder("numba:compile") as compiled:
        for name in FRAME_ENTRIES:
            kinds = NODE_ENTRIES[name]
            assert len(getattr(module, name)(*[arrays.get(kind, 7) for kind in kinds])) == len(kinds)
    assert not compiled.buffer


@pytest.mark.skipif(kernel_mode() != "numba", reason="numba compiles for a minute; make test-numba")
def test_the_first_states_after_activation_compile_nothing(hand_log: Log) -> None:
    replay = Replay(hand_log, "numba")
    first = next(iter(replay.node.compiled_fingers.values()))
    known = {name: getattr(first.numbers.module, name) for name in ("finger_step", "finger_report")}
    before = {name: function.signatures for name, function in known.items()}
    with install_recorder("numba:compile") as compiled:
        for one in hand_log.events[:FRAMES]:
            replay.meet(one)
        assert first.numbers.report_as_frames(hand_log.events[FRAMES].now + NS)
    assert not compiled.buffer
    assert {name: function.signatures for name, function in known.items()} == before
    assert all(len(signatures) == 1 for signatures in before.values())


def test_channels_stand_in_one_order_everywhere() -> None:
    assert CHANNELS == tuple(Ranges.__dataclass_fields__) == tuple(FingertipState.__dataclass_fields__)[3:]


def test_kernels_multiply_where_python_and_c_would_raise_to_a_power_differently() -> None:
    """``x ** 2`` is pow() in plain Python and one product in C and numba, one bit apart now and then."""
    folders = [Path(package.__path__[0]) for package in (estimator_kernels, grip_kernels)]
    files = [*(path for folder in folders for path in sorted(folder.glob("*.py"))), Path(fast.__file__)]
    for path in files:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
                assert not isinstance(getattr(node.right, "value", None), int), (path, node.lineno)
