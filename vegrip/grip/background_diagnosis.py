"""Who is behind a misfit: when the health of a finger fails for a while, another process looks for it.

The loop only keeps the last contacts of each finger, thinned out, in arrays of fixed size. Once a finger's
model is said to fail, a side thread hands them to a process of low priority, which diagnoses them as ``vegrip
diagnose`` would, from the finger's own model; ModelHealth reports what it finds until it looks again. With
a model that explains what is measured no process is ever started.
"""

import io
import logging
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vegrip.clock import NS
from vegrip.estimator.memory import CHANNELS
from vegrip.host.realtime import SideTask
from vegrip.messages import FingertipState, ModelHealth
from vegrip.model import ContactModel
from vegrip.model.file import model_text
from vegrip.runtime.background import run_behind
from vegrip.types import Flags, Floats


@dataclass(frozen=True, slots=True)
class KeptStates:
    """States that the compiled step accepted, in their order.

    Args:
        finger: whose they are.
        stamps: [ns], shape (n,).
        numbers: their counters, shape (n,).
        values: what was measured, in the order of FingertipState, and 1 where it touched; shape (n, 10).

    """

    finger: str
    stamps: NDArray[np.int64]
    numbers: NDArray[np.int64]
    values: Floats

    def __len__(self) -> int:
        return len(self.stamps)

    def __iter__(self) -> Iterator[FingertipState]:
        rows = zip(self.stamps.tolist(), self.numbers.tolist(), self.values.tolist(), strict=True)
        return (FingertipState(stamp, self.finger, seq, *values[:-1]) for stamp, seq, values in rows)

    def after(self, stamp: int) -> list[FingertipState]:
        """Return the states at the end whose stamps [ns] are all later than ``stamp``."""
        early = np.flatnonzero(self.stamps <= stamp)
        part: Any = slice(int(early[-1]) + 1 if len(early) else 0, None)
        return list(KeptStates(self.finger, self.stamps[part], self.numbers[part], self.values[part]))


DIAGNOSED_CHANNELS = (
    "displacement",
    "normal_force",
    "tangential_force_x",
    "tangential_force_y",
    "torque_z",
    "slip",
    "slip_speed",
    "temperature",
    "contact_radius",
)
_MEASURED = [CHANNELS.index(name) for name in DIAGNOSED_CHANNELS]
RING_SAMPLES = 10_000  # samples of a finger
SAMPLE_SPACING_S = 0.005  # [s] least time between two of them
KEPT_AIR_S = 1.0  # [s] of air after a contact that is kept, and
AIR_SAMPLES = 32  # samples before the next one; the rest shows nothing
NEVER_NS = -(10**18)  # [ns]
MIN_SAMPLES = 4_000  # samples before a diagnosis starts
FAILING_FOR_S = 10.0  # [s] for which the health has failed before
REPEAT_AFTER_S = 120.0  # [s] from one look at a finger to the next


class SampleRing:
    """The last contacts of one finger: a ring of ``RING_SAMPLES`` samples, written in place.

    Of a longer stay in the air only the end is kept, over and over: contacts begin with it.
    """

    def __init__(self) -> None:
        self._values = np.full((RING_SAMPLES, len(DIAGNOSED_CHANNELS)), np.nan)
        self._stamps = np.zeros(RING_SAMPLES, dtype=np.int64)
        self._touching = np.zeros(RING_SAMPLES, dtype=bool)
        self._clear()

    def _clear(self) -> None:
        self._count = self._rolling = 0
        self._last = self._touched = NEVER_NS  # [ns]

    def note(self, kept: KeptStates) -> None:
        """Keep of these states those for which it is time."""
        touching = kept.values[:, -1] > 0.0
        for i, (stamp, touches) in enumerate(zip(kept.stamps.tolist(), touching.tolist(), strict=True)):
            if stamp < self._last:
                self._clear()  # the sender's clock began anew
            if touches:
                self._touched = stamp
            if stamp - self._last >= SAMPLE_SPACING_S * NS:
                self._keep(stamp, kept.values[i, _MEASURED], touches)

    def _keep(self, stamp: int, values: Any, touching: bool) -> None:
        self._last = stamp
        if stamp - self._touched > KEPT_AIR_S * NS:
            at = (self._count + self._rolling % AIR_SAMPLES) % RING_SAMPLES
            self._rolling += 1
        else:
            self._count += min(self._rolling, AIR_SAMPLES)
            at, self._rolling = self._count % RING_SAMPLES, 0
            self._count += 1
        self._stamps[at], self._touching[at] = stamp, touching
        self._values[at] = values

    def __len__(self) -> int:
        return min(self._count, RING_SAMPLES)

    def columns(self, until: int | None = None) -> dict[str, Floats]:
        """Return copies in order of time: ``t`` [s] and what was measured, up to the stamp ``until`` [ns].

        They begin in the middle of a stay in the air: a fit takes its memory as recovered there. The
        loop may go on writing meanwhile: what is out of order is put in order, what is later is left out.
        """
        count = self._count
        order = np.arange(max(count - RING_SAMPLES, 0), count) % RING_SAMPLES
        order = order[np.argsort(self._stamps[order], kind="stable")]
        stamps, values, touching = self._stamps[order], self._values[order], self._touching[order]
        keep = np.diff(stamps, prepend=stamps[:1] - 1) > 0
        if until is not None:
            keep &= stamps <= until
        keep[: _middle_of_first_air(touching)] = False
        t = (stamps[keep] - stamps[keep][:1]) / NS
        known = {c: values[keep, i] for i, c in enumerate(DIAGNOSED_CHANNELS)}
        return {"t": t, **{c: v for c, v in known.items() if not np.all(np.isnan(v))}}


def _middle_of_first_air(touching: Flags) -> int:
    """Return the row in the middle of the first stay in the air that is long enough, or else of the longest.

    A model that fails may lose the touch for some rows in the midst of a contact: that is no air.
    """
    edges = np.flatnonzero(np.diff(touching, prepend=True, append=True))
    starts, ends = edges[::2], edges[1::2]
    if not starts.size:
        return 0
    rows = ends - starts
    chosen = np.argmax(rows >= min(AIR_SAMPLES, rows.max()))
    return int(starts[chosen] + ends[chosen]) // 2


class NoDiagnosis:
    """No search for the cause of a misfit: health is reported as it is."""

    def note(self, kept: KeptStates) -> None:
        """Keep nothing."""

    def annotate(self, health: ModelHealth) -> ModelHealth:
        return health

    def forget(self, finger: str) -> None:
        """Nothing is known."""


class BackgroundDiagnosis(NoDiagnosis):
    """Diagnoses the misfit of one finger at a time, in another process.

    Args:
        models: gives the models by finger, as they are set now.
        noise: std of the sensors by the names of ``[sensors]`` of a recording.
        node: whose log it writes to.

    """

    def __init__(
        self, models: Callable[[], Mapping[str, ContactModel]], noise: Mapping[str, float], node: str
    ) -> None:
        self._models, self._noise = models, dict(noise)
        self._logger = logging.getLogger(f"vegrip.{node}")
        self._samples: dict[str, SampleRing] = {}
        self._suspect: dict[str, str] = {}
        self._failing: dict[str, int] = {}  # [ns] since when
        self._asked: dict[str, int] = {}  # [ns] when last
        self.busy: SideTask | None = None

    def note(self, kept: KeptStates) -> None:
        self._samples.setdefault(kept.finger, SampleRing()).note(kept)

    def annotate(self, health: ModelHealth) -> ModelHealth:
        """Return ``health`` with the suspect; begin to look when it has failed for long enough."""
        finger, now = health.finger, health.stamp
        if health.consistent or not health.channel:
            self._failing.pop(finger, None)
            self._suspect.pop(finger, None)
            return health
        since = self._failing.setdefault(finger, now)
        if (
            now - since >= FAILING_FOR_S * NS
            and now - self._asked.get(finger, NEVER_NS) >= REPEAT_AFTER_S * NS
        ):
            self._ask(finger, now)
        return replace(health, suspect=self._suspect.get(finger, ""))

    def forget(self, finger: str) -> None:
        """Begin anew: what was felt stays, what was said of it does not."""
        for known in (self._suspect, self._failing, self._asked):
            known.pop(finger, None)

    def _ask(self, finger: str, now: int) -> None:
        samples = self._samples.get(finger)
        if samples is None or len(samples) < MIN_SAMPLES or (self.busy is not None and self.busy.is_alive()):
            return
        self._asked[finger] = now
        self.busy = SideTask(self._look, finger, now, samples)
        self.busy.start()

    def _look(self, finger: str, asked: int, samples: SampleRing) -> None:
        columns = samples.columns(asked)
        if not {"normal_force", "displacement"} <= columns.keys():
            return  # a fit compares the one with the other
        try:
            found = diagnose_in_subprocess(columns, self._models()[finger], self._noise)
        except Exception as error:  # noqa: BLE001 (nothing that goes wrong here may end the node)
            self._logger.warning("%s: the look for a suspect failed: %s", finger, error)
            return
        if self._asked.get(finger) != asked:
            return  # the finger has got another model meanwhile
        self._logger.info(
            "%s: %s", finger, found or "nothing is missing after a fit: the model's values are off"
        )
        self._suspect[finger] = found


def diagnose_in_subprocess(
    columns: Mapping[str, Floats], model: ContactModel, noise: Mapping[str, float]
) -> str:
    """Have another process diagnose ``columns``; return the leading suspect."""
    known = {name: std for name, std in noise.items() if std > 0.0 and math.isfinite(std)}
    felt = io.BytesIO()
    np.savez(felt, model=np.array(model_text(model)), **columns)  # type: ignore[arg-type]
    sensors = [f"{name}={std!r}" for name, std in known.items()]
    done = run_behind(
        "vegrip.runtime.workers.diagnosis_worker", sensors, patience=600.0, given=felt.getvalue()
    )
    if done.returncode:
        raise RuntimeError((done.stderr.strip().splitlines() or ["it died"])[-1])
    return done.stdout.strip()
