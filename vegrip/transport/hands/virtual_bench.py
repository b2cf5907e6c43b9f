"""The other end of a hand in parts: a virtual device for each of its maps, behind one virtual hand.

What the fingers feel goes to the pads, the load of both to the sensor at the wrist; what the gripper is
commanded comes out as a command to each finger that it presses with.
"""

import threading
import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from vegrip.messages import FingertipState, ForceCommand, Message
from vegrip.transport.hands.bench_endpoint import Joined, Part
from vegrip.transport.hands.wrist_load import GRAVITY

NAP: Final = 1e-3  # [s] between two looks at the devices


class VirtualBench(Joined):
    """States of ours in, packets of several devices out; the gripper's commands as force commands.

    Args:
        parts: whose endpoints are those of virtual devices.
        serves: the fingers that the gripper presses with; the first opposes the others.
        mass: what hangs at the wrist besides the object [kg].

    """

    def __init__(self, parts: Sequence[Part], serves: Sequence[str], mass: float = 0.0) -> None:
        super().__init__(parts)
        self._serves, self._mass = tuple(serves), mass
        self._felt: dict[str, FingertipState] = {}
        self._commands: list[Message] = []
        self._lock, self._over = threading.Lock(), threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)  # they answer before the hand moves
        self._thread.start()

    def receive(self, timeout: float) -> Sequence[Message]:
        """Wait up to ``timeout`` [s]; return what the gripper was commanded."""
        deadline = time.monotonic() + timeout
        while not self._commands and (left := deadline - time.monotonic()) > 0.0:
            time.sleep(min(left, NAP))
        with self._lock:
            messages, self._commands = self._commands, []
        self.arrivals = [time.monotonic_ns()] * len(messages)
        return messages

    def _serve(self) -> None:
        while not self._over.wait(NAP):
            with self._lock:
                for part in self._parts:
                    for command in part.endpoint.receive(0.0):
                        if isinstance(command, ForceCommand):
                            fingers = self._pressed(part, command)
                            self._commands += [replace(command, finger=finger) for finger in fingers]

    def send(self, message: Message) -> None:
        if not isinstance(message, FingertipState):
            return
        self._felt[message.finger] = message
        is_last = message.finger == self._serves[-1]
        with self._lock:
            self._feel(message, is_last=is_last)

    def _feel(self, message: FingertipState, *, is_last: bool) -> None:
        for part in self._parts:
            for theirs, ours in part.names.items():
                if (part.role == "sensor" and ours == message.finger) or (part.role == "drive" and is_last):
                    part.endpoint.send(replace(message, finger=theirs))
                elif part.role == "wrist" and is_last:
                    part.endpoint.send(self._at_wrist(message, theirs))

    def close(self) -> None:
        self._over.set()
        self._thread.join()
        super().close()

    def _pressed(self, part: Part, command: ForceCommand) -> Sequence[str]:
        if part.role == "drive" or command.finger not in part.names:
            return self._serves
        return (part.names[command.finger],)

    def _at_wrist(self, last: FingertipState, finger: str) -> FingertipState:
        """Return what is felt there; x and z of the first finger, which faces the others, are reversed."""
        felt = [self._felt[name] for name in self._serves if name in self._felt]
        turned = [(1.0 if one is not felt[0] else -1.0, one) for one in felt]
        x = sum(sign * one.tangential_force_x for sign, one in turned)
        torque = sum(sign * one.torque_z for sign, one in turned)
        y = sum(one.tangential_force_y for one in felt) - self._mass * GRAVITY
        return FingertipState(last.stamp, finger, last.seq, 0.0, x, y, torque_z=torque)
