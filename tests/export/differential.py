"""Random and hostile frames, times, saves and settings: exported C under sanitizers against Python.

Both sides get the same orders, and after each one the whole memory of the finger must be the same to the bit.
"""

import contextlib
import itertools
import math
import struct
import subprocess
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from e2e.p05 import e2e_p05_protect
from numpy.typing import NDArray

from tests.export.firmware import SANITIZED
from validation.liars import COUNTER_AT, TIME_AT, VALUES_AT
from vegrip import config
from vegrip.c99 import host
from vegrip.clock import NS
from vegrip.errors import ConfigError, InputError
from vegrip.estimator import ContactEstimator
from vegrip.estimator.saved_numbers import SavedNumbers
from vegrip.export import Request, finger, texts
from vegrip.export.finger import FingerVectors, alone
from vegrip.export.saved import HEAD, TAIL, checksum, numbers_of, resumed
from vegrip.grip.finger import GraspFinger
from vegrip.grip.wires import COMMAND_BYTES, COMMANDED
from vegrip.messages import Condition
from vegrip.transport.codec.database import layouts

INIT, FRAME, TICK, SET, SAVE, LOAD = range(6)
FINGERS = 2
ORDER = struct.Struct("<qqdiiii64s")
ANSWER = np.dtype(
    [("result", "<i8"), *[(name, "<u8") for name in ("reals", "wholes", "grasp", "other")],
     ("command", "u1", COMMAND_BYTES)], align=True,
)  # fmt: skip
CHUNK = 500  # orders between two comparisons
FIRST, LAST = -(2**63), 2**63 - 1
STEP = 5_000_000  # [ns] between two states
ODD_TIMES = (FIRST, FIRST + 1, LAST, LAST - 1, 0, -1, 2**62, -(2**62), 2**61, 9 * 10**18, -9 * 10**18, 2**53)
ODD = (
    0.0, -0.0, 1e-45, 1e38, -1e38, math.inf, -math.inf, math.nan, 3.4e38, 1.0, -1.0, -1.9, 60.0, -5.0, 1e300,
    -1e300, 1e-300, 0.5, 2.0**53, 2.0**63, 7.0,
)  # fmt: skip
NOT_A_NUMBER = np.uint64(0x7FF8000000000000)


@dataclass(frozen=True)
class Order:
    """What both sides shall do."""

    what: int
    finger: int
    first: int = 0
    second: int = 0
    data: bytes = b""
    name: int = 0
    value: float = 0.0
    numbers: NDArray[np.float64] | None = None

    def packed(self) -> bytes:
        """As the C reads it."""
        head = ORDER.pack(
            self.first, self.second, self.value, self.what, self.finger, len(self.data), self.name, self.data
        )
        return head if self.numbers is None else head + self.numbers.astype("<f8").tobytes()


Answer = tuple[int, int, int, int, int, bytes]


def digest(numbers: NDArray[np.float64]) -> int:
    """Return a sum that another bit changes; NaN counts as one."""
    words = np.where(np.isnan(numbers), NOT_A_NUMBER, numbers.view(np.uint64))
    return int((words * WEIGHTS[: len(words)]).sum())


WEIGHTS = 2 * np.arange(4096, dtype=np.uint64) + 1


class InPython:
    """Two exported fingers of one grasp, as Python has them."""

    def __init__(self, request: Request, mode: str) -> None:
        self.request = request
        self.estimator = ContactEstimator(request.model, request.noise, request.estimator)
        self.saved = SavedNumbers(request.model, self.estimator.layout)
        self.settable = tuple(finger.settable())
        self.needs = np.full(len(request.fingers), np.nan)
        self.ones = [alone(request, mode) for _ in range(FINGERS)]
        self.blank = [(one.memory.f.copy(), one.memory.t.copy()) for one in self.ones]
        self.settings = [request.control for _ in range(FINGERS)]
        self.frame = np.zeros(64, dtype=np.uint8)
        self.counts: Counter[object] = Counter()
        """How often what was done, and in which condition a finger was after a frame or tick."""

    def answer(self, order: Order) -> Answer:
        """Obey; return what C returns, digests of all memory and of a save, and the last command."""
        result, other = self._obey(order)
        one = self.ones[order.finger]
        wholes = int((one.memory.t.view(np.uint64) * WEIGHTS[: len(one.memory.t)]).sum())
        return (
            result,
            digest(one.memory.f),
            wholes,
            digest(self.needs),
            other,
            one.numbers.answer_frame.tobytes(),
        )

    def _obey(self, order: Order) -> tuple[int, int]:
        one = self.ones[order.finger]
        if order.what in (FRAME, TICK):
            with np.errstate(over="raise", invalid="ignore"):  # no whole number leaves 64 bits
                return self._step(order, one), 0
        if order.what == INIT:
            return self._init(order, one), 0
        if order.what == SET:
            return self._set(order, one), 0
        if order.what == SAVE:
            return 0, digest(self.save(order.finger))
        return self._load(order, one), 0

    def save(self, number: int) -> NDArray[np.float64]:
        """Return what is saved of a finger."""
        memory = self.ones[number].memory
        self.estimator.numbers[:] = memory.section("ESTIMATOR")
        found = numbers_of(self.estimator)
        found[1] = memory["SAMPLE_BEGUN"]
        found[-TAIL] = checksum(found[:-TAIL])
        return found

    def _step(self, order: Order, one: GraspFinger) -> int:
        f, t = one.memory.f, one.memory.t
        if order.what == FRAME:
            self.frame[: len(order.data)] = np.frombuffer(order.data, dtype=np.uint8)
            done = one.numbers.module.finger_receive(
                f,
                t,
                self.needs,
                self.frame,
                len(order.data),
                order.first,
                order.second,
                one.numbers.answer_frame,
            )
        else:
            done = one.numbers.module.finger_tick(f, t, self.needs, order.second, one.numbers.answer_frame)
        self.counts[("frame", "tick")[order.what == TICK], bool(done)] += 1
        self.counts[Condition(one.memory["INPUT_CONDITION"]).name] += 1
        return int(bool(done & COMMANDED))

    def _init(self, order: Order, one: GraspFinger) -> int:
        if not (0 <= order.first < layouts().hands and 0 <= order.second < len(self.needs)):
            return 0
        memory = one.memory
        memory.f[:], memory.t[:] = self.blank[order.finger]
        one.numbers.answer_frame[:] = 0
        offset = order.first * layouts().hand_stride + order.second * layouts().finger_stride
        memory["SETUP_STATE_ID"] += offset
        memory["SETUP_COMMAND_ID"] += offset
        memory["SETUP_FINGER"] = order.second
        self.settings[order.finger] = self.request.control
        return 1

    def _set(self, order: Order, one: GraspFinger) -> int:
        if not 0 <= order.name < len(self.settable):
            return 0
        setting, settings = self.settable[order.name], self.settings[order.finger]
        section, _, key = setting.parameter.partition(".")
        group, value = getattr(settings, section), order.value
        if setting.name == "QUANTILE":  # of a probability that Python is told
            accepted = setting.low <= value <= setting.high
        else:
            try:
                group = config.replace(group, key, value / setting.scale)
                accepted = True
            except ConfigError:
                accepted = False
        self.counts["set", accepted] += 1
        if accepted:
            self.settings[order.finger] = replace(settings, **{section: group})
            one.memory[f"RULE_{setting.name}"] = value
        return int(accepted)

    def _load(self, order: Order, one: GraspFinger) -> int:
        assert order.numbers is not None
        try:
            resumed(self.estimator, order.numbers)
        except InputError:
            self.counts["load", False] += 1
            return 0
        self.counts["load", True] += 1
        memory = one.memory
        self.saved.put_into(memory.f, order.numbers[HEAD:-TAIL])
        memory["SAMPLE_BEGUN"] = memory["SAMPLE_RESUMED"] = int(order.numbers[1])
        memory["SAMPLE_TRUSTED"] = memory["SAMPLE_IS_INFORMED"] = 0
        return 1


class Attacker:
    """Gives orders: states that go on, with every now and then something wrong with them."""

    def __init__(self, seed: int, vectors: FingerVectors, python: InPython) -> None:
        self.rng = np.random.default_rng(seed)
        self.states = [meeting.data for meeting in vectors.meetings if meeting.data]
        self.python = python
        self.clock = 10 * NS
        self.counter = [0] * FINGERS
        self.next = [0] * FINGERS
        self.kept: list[NDArray[np.float64]] = []
        self.hostile = 0.2

    def orders(self) -> Iterator[Order]:
        """Yield them without end; what is saved is what the finger in Python has by then."""
        for number in range(FINGERS):
            yield Order(INIT, number, 0, number)
        rng = self.rng
        while True:
            number = int(rng.integers(FINGERS))
            if rng.random() < 0.005:
                self.hostile = float(rng.choice([0.0, 0.02, 0.2, 0.6]))
            draw = rng.random()
            if draw < 0.80:
                yield self._state(number)
            elif draw < 0.93:
                yield Order(TICK, number, 0, self._time())
            elif draw < 0.96:
                yield self._setting(number)
            elif draw < 0.965:
                self.kept = [*self.kept[-5:], self.python.save(number)]
                yield Order(SAVE, number)
            elif draw < 0.998 and self.kept:
                yield self._restored(number)
            elif draw > 0.9995:
                hand, place = (int(rng.integers(-1, high)) for high in (9, 6))
                yield Order(INIT, number, hand, place)

    def _time(self) -> int:
        """Return a time [ns]: mostly the clock's, which may have jumped."""
        rng = self.rng
        if rng.random() < 0.02 * self.hostile:
            self.clock = self._odd_time()  # and goes on from there
        elif rng.random() < 0.01 * self.hostile:
            return self._odd_time()
        step = STEP // 2 if rng.random() < 0.99 else int(10 ** rng.uniform(3.0, 11.0))
        self.clock = min(self.clock + step, LAST)
        return self.clock

    def _odd_time(self) -> int:
        rng = self.rng
        if rng.random() < 0.5:
            return int(rng.choice(ODD_TIMES))
        return min(
            max(self.clock + int(rng.choice([-1, 1])) * int(2 ** rng.uniform(10.0, 63.0)), FIRST), LAST
        )

    def _state(self, number: int) -> Order:
        rng, at = self.rng, self.next[number]
        data = bytearray(self.states[at % len(self.states)])
        self.next[number] += 1
        self.counter[number] += 1
        counter = self.counter[number]
        if rng.random() < 0.005:
            counter += int(rng.integers(-3, 2**32)) if rng.random() < 0.5 else int(rng.integers(-3, 30))
            self.counter[number] = counter if rng.random() < 0.2 else self.counter[number]
        arrival = self._time()
        struct.pack_into("<I", data, COUNTER_AT, counter % 2**32)
        struct.pack_into("<I", data, TIME_AT, (arrival // 1000 + int(rng.integers(-200, 1))) % 2**32)
        for at in range(VALUES_AT, len(data), 4):
            if rng.random() < 0.3 * self.hostile:
                self._spoil(data, at)
        memory = self.python.ones[number].memory
        e2e_p05_protect(data, memory["SETUP_STATE_ID"], increment_counter=False)
        if rng.random() < 0.03 * self.hostile:
            data[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        if rng.random() < 0.01 * self.hostile:
            data = data[: int(rng.integers(len(data)))] if rng.random() < 0.5 else data + bytes(16)
        now = arrival + 20_000 if arrival < LAST - 20_000 else arrival
        return Order(FRAME, number, arrival, now if rng.random() < 0.99 else self._time(), bytes(data))

    def _spoil(self, data: bytearray, at: int) -> None:
        rng, value = self.rng, struct.unpack_from("<f", data, at)[0]
        draw = rng.random()
        if draw < 0.1:
            data[at : at + 4] = rng.bytes(4)
            return
        value = rng.choice(ODD) if draw < 0.4 else value * rng.normal(1.0, 0.5)
        with np.errstate(over="ignore"):
            struct.pack_into("<f", data, at, np.float32(value))

    def _setting(self, number: int) -> Order:
        rng = self.rng
        name = int(rng.integers(-1, len(self.python.settable) + 1))
        setting = self.python.settable[name % len(self.python.settable)]
        low, high = setting.low, setting.high
        memory = self.python.ones[number].memory
        values = (
            rng.choice(ODD), low, high, np.nextafter(low, -math.inf), np.nextafter(high, math.inf),
            rng.uniform(low, high), low + (high - low) * 10 ** rng.uniform(-9.0, 0.0),
            memory[f"RULE_{setting.name}"] * rng.uniform(0.5, 2.0), rng.uniform(0.1, 20.0),
        )  # fmt: skip
        return Order(SET, number, name=name, value=float(values[int(rng.integers(len(values)))]))

    def _restored(self, number: int) -> Order:
        """Return a save that is whole, damaged, or illegal behind a checksum that fits."""
        rng = self.rng
        numbers = self.kept[int(rng.integers(len(self.kept)))].copy()
        draw = rng.random()
        if draw < 0.1:
            return Order(LOAD, number, numbers=numbers)
        at = int(rng.integers(len(numbers)))
        if draw < 0.4:
            bits = numbers.view(np.uint64)
            bits[at] ^= np.uint64(1) << np.uint64(rng.integers(64))
        else:
            numbers[at] = rng.choice(ODD) if rng.random() < 0.7 else numbers[at] * rng.normal()
        if draw > 0.7:
            numbers[-TAIL] = checksum(numbers[:-TAIL])
        return Order(LOAD, number, numbers=numbers)


def build(request: Request, folder: Path) -> Path:
    """Return the program, under the sanitizers."""
    for name, text in texts.write(request).files.items():
        if name.startswith("vg_finger."):
            (folder / name).write_text(text)
    source, program = Path(__file__).with_suffix(".c"), folder / "differential"
    command = [str(host.compiler()), *host.EXACT, *SANITIZED, f"-I{folder}", str(source)]
    subprocess.run(
        [*command, str(folder / "vg_finger.c"), "-o", str(program), "-lm"], check=True, capture_output=True
    )
    return program


class InC:
    """The program that :func:`build` makes, while it runs."""

    def __init__(self, program: Path) -> None:
        pipe = subprocess.PIPE
        self._process = subprocess.Popen([str(program)], stdin=pipe, stdout=pipe, stderr=pipe)

    def __enter__(self) -> "InC":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.communicate()

    def obey(self, orders: Sequence[Order]) -> list[Answer]:
        """Return its answers, no more than :data:`CHUNK`: so many the pipe holds.

        Raises:
            AssertionError: a sanitizer has ended it.

        """
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        assert len(orders) <= CHUNK
        with contextlib.suppress(BrokenPipeError):
            for order in orders:
                self._process.stdin.write(order.packed())
            self._process.stdin.flush()
        data = self._process.stdout.read(len(orders) * ANSWER.itemsize)
        assert len(data) == len(orders) * ANSWER.itemsize, self._process.communicate()[1].decode()
        return [(*one[:5], bytes(one[5])) for one in np.frombuffer(data, ANSWER).tolist()]


def difference(python: InPython, attacker: Attacker, program: Path, frames: int) -> str:
    """Return what differs first in so many frames, "" = nothing."""
    given, met = attacker.orders(), 0
    with InC(program) as c:
        while met < frames:
            orders, ours = [], []
            for order in itertools.islice(given, CHUNK):  # the next one depends on what became of it
                ours.append(python.answer(order))
                orders.append(order)
            met += sum(order.what == FRAME for order in orders)
            for order, one, other in zip(orders, ours, c.obey(orders), strict=True):
                if one != other:
                    return f"among the first {met} frames, {order}: Python {one}, C {other}"
    return ""
