"""The device of a map, simulated: it sends what the map decodes, and decodes what the map sends. Pure.

Everything follows from the map: the packets, their pages, records, counters, checksums and clock; the
resolution of each field; what is answered to which poll, what is sent by itself after the opening, and at
which rate. What the map leaves open in a packet (``..`` of its start, fields that nothing reads) is zero.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np

from vegrip.clock import NS
from vegrip.errors import ConfigError
from vegrip.messages import FingertipState
from vegrip.transport.codec import Frame
from vegrip.transport.hands.virtual_drive import Simulated
from vegrip.transport.mapped.commands import FrameCommands, Outgoing, Target, rounding
from vegrip.transport.mapped.compiled import Group, compile_raw, groups_of, made, packing
from vegrip.transport.mapped.plan import VECTORS, ChannelPlan, FingerPlan, Plan
from vegrip.transport.maps.dialogue import Dialogue, Step
from vegrip.transport.maps.packets import Index, Packet, PacketMap, read_field
from vegrip.transport.maps.schema import POLAR
from vegrip.transport.maps.signals import ForeignMessage, Signal

USUAL_RATE: Final = 100.0  # [Hz] of a device that sends by itself and whose map states none
TURN: Final = 2.0 * math.pi  # [rad]


class VirtualDevice(Simulated):
    """The first device of a hand."""

    def __init__(self, plan: Plan, latency: float = 0.0) -> None:
        if plan.hand.format or plan.hand.nodes:
            raise ConfigError(
                f"{plan.hand.path}: only packets and frames of a CAN database have a virtual device"
            )
        super().__init__(latency)
        self._plan = plan
        self._packets = {one.name: one for one in plan.database.packets if one.device == 0}
        hand, on_can = plan.hand, not plan.database.packets
        self._on_can = on_can
        self._dialogue = Dialogue(
            hand.device, 0, hand.command.period, Counter(), str(hand.path), on_can=on_can
        )
        commands = FrameCommands(plan, self._state_of, Counter())
        self._commands = {
            name: _CommandReader(plan, *each)
            for name, each in commands.targets.items()
            if on_can or each[0].name in self._packets
        }
        answers = {step.expects for step in (*self._dialogue.zeroing, *self._dialogue.poll)}
        answers = (answers | {each.answer for each in hand.packets.values()}) - {""}
        sent = {hand.packets[name].of or name if name in hand.packets else name for name in plan.messages}
        known = plan.database.messages if on_can else self._packets
        self._writers = {name: _Writer(plan, name) for name in known if name in sent | answers}
        self._by_itself = [name for name in self._writers if name not in answers]
        self._period = round(NS / (hand.rate or USUAL_RATE))
        self._raws: dict[int, int] = {}  # slot -> what stands in its field
        self._held: dict[int, float] = {}  # slot -> what can be read in it
        self._positions: dict[str, float] = {}  # in the unit of their command
        self._measured: dict[str, float] = {}  # [N] the last normal force
        self._values: dict[str, dict[str, float]] = {}  # finger -> channel -> value in the maker's frame
        self._zeros: dict[str, dict[str, float]] = {}
        self._frictions: dict[str, float] = {}  # [-] of its own estimate, by finger
        self.reset()

    def reset(self) -> None:
        """Begin as when it is switched on: only what needs no opening is sent."""
        self._streams = not self._dialogue.opening
        self._next = 0
        self._received.clear()
        self._outbox.clear()

    def sense(self, state: FingertipState) -> None:
        """Take what a finger feels."""
        finger = next((one for one in self._plan.fingers if one.name == state.finger), None)
        if finger is None:
            return
        values = self._values[state.finger] = _theirs(finger, state)
        values |= self._own_estimate(finger, values)
        self._fill(finger)

    def take_in(self, frame: Frame, now: int) -> None:
        if self._on_can:
            self._take_whole(frame, now)
            return
        self._received += frame.data
        while self._received and (size := self._understand(bytes(self._received), now)):
            del self._received[:size]

    def _take_whole(self, frame: Frame, now: int) -> None:
        asked = frame.arbitration_id, bytes(frame.data)
        for step in (one for one in self._steps if one.frame[:2] == asked):
            self._obey(step, now)
            return
        for finger, reader in self._commands.items():
            if reader.message.identifier == frame.arbitration_id and len(frame.data) >= reader.message.length:
                self._command(finger, reader, asked[1][: reader.message.length])

    def due(self, now: int) -> list[Frame]:
        """Return what it sends up to ``now`` [ns]; on a byte stream only the data counts."""
        if self._streams and self._by_itself:
            if now - self._next > 2 * self._period:
                self._next = now
            while self._next <= now:
                for name in self._by_itself:
                    self._send(name, self._next, b"")
                self._next += self._period
        return self._said_by(now)

    @property
    def _steps(self) -> Sequence[Step]:
        dialogue = self._dialogue
        return (*dialogue.opening, *dialogue.poll, *dialogue.zeroing, *dialogue.closing)

    def _understand(self, data: bytes, now: int) -> int:
        """Return how many bytes of ``data`` are done with; 0: more are needed."""
        known = [step for step in self._steps if data.startswith(step.data)]
        if known:
            step = max(known, key=lambda one: len(one.data))
            self._obey(step, now)
            return len(step.data)
        is_begun = any(step.data.startswith(data) for step in self._steps)
        size, answered = 0, set[str]()
        for finger, reader in self._commands.items():
            packet = self._packets[reader.message.name]
            if packet.start.match(data) is None:
                is_begun = is_begun or len(data) < packet.reach
            elif len(data) < reader.message.length:
                is_begun = True
            else:
                size = reader.message.length
                self._command(finger, reader, data[:size])
                answered.add(self._plan.hand.packets[packet.name].answer)
        for name in answered:
            self._send(name, now, data[:size])
        if size or is_begun:
            return size
        self.counts["unknown_request"] += 1
        return 1

    def _obey(self, step: Step, now: int) -> None:
        dialogue = self._dialogue
        if step in dialogue.closing:
            self._streams = False
        if dialogue.opening and step == dialogue.opening[-1]:
            self._streams, self._next = True, now + self._period
        if step in dialogue.zeroing:
            self.counts["zero"] += 1
            self._zeros = {finger: dict(values) for finger, values in self._values.items()}
            for finger in self._plan.fingers:
                self._fill(finger)
        if step.answer:
            self._say(Frame(-1, step.answer + b"\r\n", False, now), now)
        if step.expects:
            self._send(step.expects, now, step.data)
        elif step in dialogue.poll:
            for name in self._writers:
                self._send(name, now, step.data)

    def _send(self, name: str, now: int, asked: bytes) -> None:
        if name in self._writers:
            for frame in self._writers[name].frames(self._raws, now, asked):
                self._say(frame, now)

    def _command(self, finger: str, reader: "_CommandReader", data: bytes) -> None:
        before = self.forces.get(finger, math.nan)
        force = reader.force(data, before, *self._state_of(finger))
        self._press(finger, force)

    def _state_of(self, finger: str) -> tuple[float, float]:
        """Return the normal force that is felt [N], and the position as it is sent."""
        return self._measured.get(finger, math.nan), self._positions.get(finger, math.nan)

    def _fill(self, finger: FingerPlan) -> None:
        values, zeros = self._values.get(finger.name, {}), self._zeros.get(finger.name, {})
        self._measured[finger.name] = values.get("normal_force", math.nan)
        felt = {name: value - zeros.get(name, 0.0) for name, value in values.items()}
        if finger.channels.keys() >= POLAR:
            x, y = (felt.get(name, math.nan) for name in VECTORS[0][:2])
            felt["tangential_magnitude"], felt["tangential_direction"] = math.hypot(x, y), math.atan2(y, x)
        for name, channel in finger.channels.items():
            self._spread(name, channel, felt.get(name, math.nan))
        if finger.torque is not None:
            self._twist(finger, felt)
        if finger.name in self._plan.feedback:
            self._stand(finger)

    def _own_estimate(self, finger: FingerPlan, felt: Mapping[str, float]) -> dict[str, float]:
        """Return what a device says that watches slip itself: by Coulomb's law, from the last slide on."""
        if "device_friction" not in finger.channels:
            return {}
        normal = felt["normal_force"]
        tangential = math.hypot(*(felt[name] for name in VECTORS[0][:2]))
        if felt["slip"] > 0.0 and normal > 0.0:
            self._frictions[finger.name] = tangential / normal
        friction = self._frictions.get(finger.name, math.nan)
        return {
            "device_slip_state": float(normal > 0.0),
            "device_friction": friction,
            "device_grip_force": tangential / friction if friction > 0.0 else math.nan,
        }

    def _spread(self, name: str, channel: ChannelPlan, value: float) -> None:
        """Share ``value`` among the slots of a channel; each takes what those before it could not hold."""
        if not math.isnan(channel.above + value):
            value = channel.above + (1.0 if value > 0.0 else -1.0)
        if channel.table:
            theirs, ours = (np.array(column) for column in zip(*channel.table, strict=True))
            order = np.argsort(ours)
            value = float(np.interp(value, ours[order], theirs[order]))
        rest = value - channel.constant
        for place, slot in enumerate(channel.slots):
            left = len(channel.slots) - place
            turns = (0.0, TURN, -TURN) if name == "tangential_direction" else (0.0,)
            for turn in turns:
                given, is_beyond = self._put(slot, rest / left + turn)
                if not is_beyond:
                    break
            rest -= given

    def _twist(self, finger: FingerPlan, felt: Mapping[str, float]) -> None:
        """Have the taxels turn about the middle of an evenly pressed array by the torque."""
        plan = finger.torque
        assert plan is not None  # noqa: S101 (looked at by the caller)
        places = np.array(plan.positions)
        arms = places - places.mean(axis=0)
        torque = felt.get("torque_z", 0.0) / max(float((arms**2).sum()), 1e-12)
        for fx, fy, (x, y) in zip(plan.x, plan.y, arms.tolist(), strict=True):
            n = len(arms)
            self._put(fx, felt.get("tangential_force_x", math.nan) / n - torque * y)
            self._put(fy, felt.get("tangential_force_y", math.nan) / n + torque * x)

    def _stand(self, finger: FingerPlan) -> None:
        """Be where a channel says, or else where a spring is that is as stiff as the map says."""
        number = self._plan.feedback[finger.name]
        slot = self._plan.slots[number]
        same = [
            one
            for one in self._plan.slots
            if (one.message, one.signal) == (slot.message, slot.signal) and one.number != number
        ]
        if same:
            value = (self._held[same[0].number] - same[0].offset) / same[0].scale * slot.scale + slot.offset
        else:
            law = self._commands[finger.name].target.law
            value = law.at_rest(self._measured[finger.name])
        self._positions[finger.name] = self._put(number, value)[0]

    def _put(self, number: int, value: float) -> tuple[float, bool]:
        """Write ``value`` to a slot; return what can be read there, and whether it is beyond its range."""
        slot = self._plan.slots[number]
        if slot.place is None or not math.isfinite(value):
            unknown = slot.invalid[0] if slot.invalid else 0
            self._raws[number] = 0 if slot.place is None else rounding(slot.place, raw=True)(unknown)[0]
            self._held[number] = math.nan
            return 0.0, False
        steps = (value - slot.offset) / slot.scale
        raw, is_beyond = rounding(slot.place, raw=True)(steps)
        self._raws[number] = raw
        held = (steps if slot.place.is_float else raw) * slot.scale + slot.offset
        self._held[number] = held
        return held, is_beyond


class _CommandReader:
    """Reads the force of one finger out of a command."""

    def __init__(self, plan: Plan, outgoing: Outgoing, target: Target) -> None:
        self.message = plan.database.messages[outgoing.name]
        self.target = target
        self._raw = compile_raw(self.message, target.place)
        self._pages = [
            (compile_raw(self.message, self.message.signals[name]), value)
            for name, value in outgoing.constants.items()
            if name in {signal.selected_by for signal in self.message.signals.values()}
        ]

    def force(self, data: bytes, before: float, measured: float, position: float) -> float:
        """Return the force that is commanded [N], NaN when this page has none."""
        if any(raw(data) != value for raw, value in self._pages):
            return math.nan
        signal, value = self.target.place, float(self._raw(data))
        if not self.target.raw:
            value = value * signal.scale + signal.offset
        return self.target.law.force(value, before, measured, position)


class _Writer:
    """Makes a packet or frame from the raw values of the slots in it."""

    def __init__(self, plan: Plan, name: str) -> None:
        self._message = plan.database.messages[name]
        self._packet = next((one for one in plan.database.packets if one.name == name), None)
        self._spec = plan.hand.packets.get(name, PacketMap())
        self._pages = [_Page(plan, name, group) for group in _groups(plan, name)]
        self._records = [
            (each.record, _Page(plan, one, _groups(plan, one)[0]))
            for one, each in plan.hand.packets.items()
            if each.of == name
        ]
        self._guard = plan.guard_of(name) if self._packet is None else None

    def frames(self, raws: Mapping[int, int], now: int, asked: bytes) -> list[Frame]:
        """Return the pages that ``asked`` asks for, or else all."""
        wanted = [page for page in self._pages if page.is_asked_by(asked)] or self._pages
        return [
            Frame(self._message.identifier, self._whole(page, raws, now), self._message.fd, now)
            for page in wanted
        ]

    def _whole(self, page: "_Page", raws: Mapping[int, int], now: int) -> bytes:
        data, packet = page.data(raws), self._packet
        guard = self._guard
        if packet is not None:
            if packet.clock is not None:
                _, modulus, per_count = packet.clock
                signal = self._message.signals[self._spec.clock.partition(" ")[0]]
                _put_in(data, signal, round(now / per_count) % modulus)
            if packet.index is not None:
                data = self._with_records(data, packet.index, raws)
            if packet.least < packet.most:
                data = self._ended(data, packet)
            guard = packet.guard(len(data))
        if guard is not None:
            guard.protect(data)
        return bytes(data)

    def _ended(self, data: bytearray, packet: Packet) -> bytearray:
        data = data.removesuffix(packet.end)
        if packet.checked is not None and packet.checked.start < 0:
            data += bytes(-(packet.checked.start // 8) - len(packet.end))
        data += packet.end
        if isinstance(self._spec.length, Mapping):
            place = read_field("length", self._spec.length["field"], 0, packet.where)
            _put_in(data, place, len(data) - self._spec.length.get("plus", 0))
        return data

    def _with_records(self, head: bytearray, index: Index, raws: Mapping[int, int]) -> bytearray:
        kind_at = read_field("type", self._spec.index["type"], 0, self._message.name)
        bodies = [(kind, page.data(raws)) for kind, page in self._records]
        entries, begin = bytearray(), index.at + len(bodies) * index.entry - index.origin
        for kind, body in bodies:
            if index.offset is None:
                body.extend(bytes(index.sizes[kind] - len(body)))
                _put_in(body, kind_at, kind)
                continue
            entry = bytearray(index.entry)
            _put_in(entry, kind_at, kind)
            _put_in(entry, read_field("offset", self._spec.index["offset"], 0, self._message.name), begin)
            entries += entry
            begin += len(body)
        head = head[: index.at].ljust(index.at, b"\0")
        return head + entries + b"".join(body for _, body in bodies)


class _Page:
    """The fields of a message that come together."""

    def __init__(self, plan: Plan, name: str, group: Group) -> None:
        self._message = plan.database.messages[name]
        fields: dict[str, int | str] = {name: next(iter(values)) for name, values in group.condition}
        fields |= {
            slot.place.name: f"raws.get({slot.number}, 0)" for slot in group.slots if slot.place is not None
        }
        self._gates = [
            (compile_raw(self._message, self._message.signals[name]), values)
            for name, values in group.condition
        ]
        spec = plan.hand.messages.get(name)
        if spec is not None and spec.counter:
            fields[spec.counter] = f"count % {plan.modulus_of(name)}"
        text = f" return bytearray({packing(self._message, fields)})"
        self._pack = made(["def pack(raws, count):", text], "pack", {})
        self._count = -1

    def is_asked_by(self, request: bytes) -> bool:
        """Whether a request begins as this page does: it has the values that select it."""
        data = request.ljust(self._message.length, b"\0")
        return bool(request and self._gates) and all(raw(data) in values for raw, values in self._gates)

    def data(self, raws: Mapping[int, int]) -> bytearray:
        """Return the page, without what is counted from its end."""
        self._count += 1
        data: bytearray = self._pack(raws, self._count)
        return data


def _groups(plan: Plan, name: str) -> list[Group]:
    message: ForeignMessage = plan.database.messages[name]
    return groups_of(message, [slot for slot in plan.slots if slot.message == name]) or [Group((), ())]


def _put_in(data: bytearray, signal: Signal, raw: int) -> None:
    first, size = signal.start // 8, signal.length // 8
    order: Any = "big" if signal.is_big_endian else "little"
    data[first : first + size] = (raw & (1 << signal.length) - 1).to_bytes(size, order)


def _theirs(finger: FingerPlan, state: FingertipState) -> dict[str, float]:
    ours: dict[str, Any] = state._asdict()  # type: ignore[attr-defined]
    found = {name: float(value) for name, value in ours.items() if name not in ("stamp", "finger", "seq")}
    if finger.rotation:
        turn = np.array(finger.rotation)
        for vector in VECTORS:
            felt = np.array([found.get(name, 0.0) for name in vector])
            found |= dict(zip(vector, (turn.T @ felt).tolist(), strict=True))
    return found
