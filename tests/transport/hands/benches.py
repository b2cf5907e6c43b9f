"""Made-up hands in parts for the tests: two pads and a gripper, each with a virtual device on a pty."""

import time
from contextlib import ExitStack
from pathlib import Path

from vegrip.clock import NS
from vegrip.messages import FingertipState, ForceCommand, Reason
from vegrip.transport.open import Hand, open_endpoint

PAD = """
rate = 500.0
[transport]
kind = "serial"
address = "{port}"
[packets.p]
start = "AA 55"
length = 16
[packets.p.fields]
fz = "f32 le @2 * 1 N"
fx = "f32 le @6 * 1 N"
fy = "f32 le @10 * 1 N"
count = "u16 le @14"
[fingers.{finger}.normal_force]
signal = "p.fz"
zero_is_measured = true
[fingers.{finger}.tangential_force_x]
signal = "p.fx"
zero_is_measured = true
[fingers.{finger}.tangential_force_y]
signal = "p.fy"
zero_is_measured = true
"""

GRIPPER = """
rate = 50.0
[transport]
kind = "serial"
address = "{port}"
[drive]
resolution = 0.84
rate = 50.0
delay = 0.03
minimum = {minimum}
maximum = 235.0
hysteresis = 0.5
[packets.told]
start = "D0"
length = 5
[packets.told.fields]
force = "f32 le @1 * 1 N"
[packets.felt]
start = "D1"
length = 5
[packets.felt.fields]
force = "f32 le @1 * 1 N"
[fingers.gripper.normal_force]
signal = "felt.force"
zero_is_measured = true
[fingers.gripper.command]
signal = "told.force"
"""


def write_bench(folder: Path, *, minimum: float = 20.0, extra: str = "") -> Path:
    """Write the maps of two pads and a gripper, and the launch file of their bench; return its path."""
    for finger in ("left", "right"):
        (folder / f"{finger}.toml").write_text(PAD.format(finger=finger, port=folder / f"tty_{finger}"))
    (folder / "gripper.toml").write_text(GRIPPER.format(port=folder / "tty_gripper", minimum=minimum))
    path = folder / "bench.toml"
    path.write_text(f'sensors = ["left.toml", "right.toml"]\ndrive = "gripper.toml"\n{extra}')
    return path


class Devices:
    """The virtual devices of a bench."""

    def __init__(self, folder: Path, stack: ExitStack, names=("left", "right", "gripper")):
        self.told: list[float] = []  # [N] as the gripper was
        self._of, self._stacks, self._seq = {}, {}, 0
        self._folder, self._stack = folder, stack
        for name in names:
            self.plug(name)

    def plug(self, name):
        table = {
            "kind": "device",
            "map": str(self._folder / f"{name}.toml"),
            "address": str(self._folder / f"tty_{name}"),
        }
        self._stacks[name] = self._stack.enter_context(ExitStack())
        self._of[name] = self._stacks[name].enter_context(open_endpoint(table, Hand((name,))))

    def unplug(self, name):
        self._stacks[name].close()
        del self._of[name]

    def feel(self, **forces):
        """Let devices feel normal forces [N] now."""
        self._seq += 1
        for name, force in forces.items():
            if name in self._of:
                stamp = time.monotonic_ns()
                self._of[name].send(FingertipState(stamp, name, self._seq, force, 0.5, 0.1))
        self.serve()

    def serve(self):
        for name, device in self._of.items():
            heard = device.receive(0.0)
            if name == "gripper":
                self.told += [each.normal_force for each in heard if isinstance(each, ForceCommand)]


def command(finger, force, now, seq=1):
    return ForceCommand(now, finger, seq, force, 0.0, Reason.HOLD, now + NS // 10)
