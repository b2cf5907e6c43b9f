"""The generated module of a finger: the estimator's text, the control's below it, and frames from the DBC.

``VEGRIP_KERNEL`` says what runs it, as for the estimator alone.
"""

import ctypes
import logging
from collections.abc import Callable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, Final

from vegrip.c99 import BYTES, LONG, LONGS, MEMORY
from vegrip.c99.bridge import Lengths
from vegrip.c99.kinds import Kind
from vegrip.effects.contract import Effect
from vegrip.estimator.compiled import clock_parts, estimator_parts
from vegrip.estimator.memory import CHANNELS
from vegrip.estimator.origins import Origins
from vegrip.grip import grasp_memory
from vegrip.grip.layout import FORCE_CHANNELS, MECHANICAL_CHANNELS, WINDOW_SLOTS, FingerLayout
from vegrip.grip.wires import ENTRIES, FRAME_ENTRIES, MESSAGE_ENTRIES, NODE_ENTRIES
from vegrip.model import ContactModel, native, writer
from vegrip.model.composer import compose
from vegrip.transport.codec.kernel_text import wire_text

HERE: Final = Path(__file__).parent / "kernels"
ROWS: Final = HERE.with_name("rows.c")
INPUT_KERNELS: Final = ("bits", "frame_bytes", "receive", "stillness", "noise", "watchdog")
GRIP_KERNELS: Final = (
    "demand", "takeover", "margin_grip", "fail_safe", "limits", "share", "control",
    "finger_step", "reports",
)  # fmt: skip
SHARED_FRICTION: Final = (
    "friction_numbers", "friction_belief", "drive_lag", "load_lead", "slip_channels", "slip_witness",
    "force_release",
)  # fmt: skip
"""Texts of :mod:`vegrip.grip`: the friction of a grasp, which a node also looks at."""

LOAD_CHANNELS: Final = ("tangential_force_x", "tangential_force_y", "torque_z")
SUFFICIENT_CHANNELS: Final = ("normal_force", "displacement")
FingerKernels = Any
"""A generated module, or what stands for it: :class:`vegrip.model.native.ModuleC`."""

Step = Callable[[Any, int, int, int], int]
"""Frame, its length, arrival and present time [ns] -> what was done, in bits."""

log = logging.getLogger(__name__)


def finger_module(
    model: ContactModel, finger: FingerLayout, *, ellipse: bool = False, mode: str = ""
) -> FingerKernels:
    """Return the compiled finger step of a model; ``mode`` goes before ``VEGRIP_KERNEL``."""
    return native.run_by(
        mode or _mode(), finger_text(model.effects, finger, ellipse), entries_of(finger),
        finger_places(model).place, ROWS.read_text(encoding="utf-8"), single=single_lengths(finger),
        usual=ctypes.c_int,
    )  # fmt: skip


def bound_step(module: FingerKernels, f: Any, t: Any, g: Any, out: Any) -> Step:
    """Return the step of ``module`` on arrays that stay where they are and are kept by the caller."""
    if not isinstance(module, native.ModuleC):
        step = module.finger_step
        return lambda frame, length, arrival, now: step(f, t, g, frame, length, arrival, now, out)
    call, at_f, at_t, at_g, answer = module.entry("finger_step"), *map(native.address, (f, t, g, out))

    def step_c(frame: Any, length: int, arrival: int, now: int) -> int:
        done: int = call(at_f, at_t, at_g, native.address(frame), length, arrival, now, answer)
        return done

    return step_c


def compile_now(module: FingerKernels, finger: FingerLayout, f: Any, t: Any, out: Any) -> None:
    """Let numba compile what a node calls of ``module``, for arrays like these; C and Python have no need to.

    numba compiles a function when it is called first, and that would be within the loop: a minute without a
    command. Nothing is called here, so that the arrays stay as they are.
    """
    if isinstance(module, native.ModuleC):
        return
    from numba import typeof  # noqa: PLC0415 (only where numba is what runs)
    from numba.core.dispatcher import Dispatcher  # noqa: PLC0415

    given = {MEMORY: f, LONGS: t, BYTES: out, LONG: 0}
    entries = entries_of(finger)
    for name in (*FRAME_ENTRIES, *MESSAGE_ENTRIES):
        function = getattr(module, name, None)
        if isinstance(function, Dispatcher) and name in entries:
            kinds = entries[name]
            function.compile(tuple(typeof(given[kind]) for kind in kinds))  # type: ignore[no-untyped-call]


def _mode() -> str:
    mode = native.kernel_mode()
    return "c" if mode == "c-float" else mode


def single_lengths(finger: FingerLayout) -> Lengths:
    """Return how long the memories of each entry are, for a step that computes in single precision."""
    needs = f"(int)a1[{finger.wholes['SETUP_FINGERS']}]"
    lengths = (finger.n_reals, grasp_memory.SIZE if finger.is_shared else needs, len(CHANNELS))
    return {name: lengths[: kinds.count(MEMORY)] for name, kinds in entries_of(finger).items()}


def finger_places(model: ContactModel) -> Origins:
    return Origins(model.effects, (HERE,))


@lru_cache(maxsize=32)
def finger_text(effects: tuple[Effect, ...], finger: FingerLayout, ellipse: bool) -> str:
    """Return the text of the module."""
    kernels = [path.read_text(encoding="utf-8") for path in kernels_of(finger)]
    known = [*clock_parts(finger), constants(), wire_text()]
    if finger.is_shared:
        known.append(grasp_memory.constants())
    parts = [*estimator_parts(finger.filter, ellipse=ellipse), *known]
    names = [effect.name for effect in effects]
    return writer.write(compose(effects), names, [*parts, *kernels], tuple(entries_of(finger)))


def kernels_of(finger: FingerLayout) -> list[Path]:
    """Return the files of the step, in their order."""
    friction = [HERE / "alone.py"]
    if finger.is_shared:
        friction = [HERE.with_name(f"{name}.py") for name in SHARED_FRICTION]
        friction += [HERE / "friction_shared.py", HERE / "choice.py"]
    before, behind = ([HERE / f"{name}.py" for name in some] for some in (INPUT_KERNELS, GRIP_KERNELS))
    messages = [HERE / "finger_message.py"] if finger.is_shared else []
    return [*before, HERE.with_name("confirmed_load.py"), *friction, *behind, *messages]


def entries_of(finger: FingerLayout) -> Mapping[str, tuple[Kind, ...]]:
    return NODE_ENTRIES if finger.is_shared else ENTRIES


def constants() -> str:
    """Return what the kernels know beside places."""
    return "\n".join([
        f"MECHANICAL = {MECHANICAL_CHANNELS}",
        f"FORCES = {FORCE_CHANNELS}",
        f"USUAL_SLOTS = {WINDOW_SLOTS}",
        f"LOADING = {bits_of(LOAD_CHANNELS)}",
        f"SUFFICIENT = {bits_of(SUFFICIENT_CHANNELS)}",
    ])  # fmt: skip


def bits_of(channels: tuple[str, ...] | frozenset[str]) -> int:
    return sum(1 << CHANNELS.index(name) for name in channels)
