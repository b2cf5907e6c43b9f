"""What the model says of every channel of a recording: normal force, radius, and the load at which it slips.

The tangential channels are limits: while the contact slides, the measured load must lie on the limit surface,
so ``tangential_force`` and ``torque_z`` here are the loads at slip along the direction of the measured load.
Until it slides they are upper bounds, and ``utilisation`` says how near the load came.
"""

import copy
from collections.abc import Mapping
from typing import Literal, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vegrip.effects.contract import OUTSIDE
from vegrip.errors import ModelError
from vegrip.model.model import ContactModel
from vegrip.types import Floats

QUANTITIES = (
    "displacement",  # [m] as imposed, or found from the measured force
    "indentation",  # x [m]
    "elastic_force",  # N_e [N]
    "normal_force",  # [N] what the sensor shows
    "contact_force",  # N [N] that presses, in the friction channels
    "contact_radius",  # a [m]
    "pressure_exponent",  # k
    "friction_coefficient",  # mu
    "limit_force",  # [N] mu N
    "limit_torque",  # [N m] pure torsion
    "utilisation",  # load over limit, 1 = slips; NaN without load or contact
    "limit_radius",  # [N] distance to the limit surface along the measured load
    "tangential_force",  # [N] at slip
    "torque_z",  # [N m] at slip
)
"""What :func:`predict` returns, and the columns of the compiled result."""

Drive = Literal["displacement", "normal_force", "either"]
Load = Literal["measured", "model"]


class Recorded(Protocol):
    """What is needed of a recording, such as :class:`vegrip.identification.recording.Recording`."""

    @property
    def t(self) -> Floats:
        """(n,) [s], increasing."""

    @property
    def episode(self) -> NDArray[np.int64]:
        """(n,) number of the trial."""

    @property
    def columns(self) -> Mapping[str, Floats]:
        """Channel -> (n,), NaN where missing."""


class Predictor:
    """A recording made ready for one list of effects, to be evaluated for many values of their parameters.

    Args:
        model: its effects and initial states count, its values do not.
        recording: with the columns of a recording, or a mapping of them with ``t`` and perhaps ``episode``.
        drive: the channel that is given; the other one is predicted. A displacement that is missing within an
            episode is taken linear. ``either``: the displacement where there is one, else the normal force.
        load: what presses in the friction channels: the model's force corrected by what the sensor shows
            beyond it (so that an error of the normal force is not counted twice), or the model's force alone.
        asked: (n,) what is wanted of each row: 2 all quantities, 1 those up to the radius, 0 those
            before the radius; the others are NaN. All when not given.
        plain: run as uncompiled Python, for debugging.

    """

    def __init__(
        self,
        model: ContactModel,
        recording: Recorded | Mapping[str, ArrayLike],
        *,
        drive: Drive = "displacement",
        load: Load = "measured",
        asked: Floats | None = None,
        plain: bool = False,
    ) -> None:
        columns = _columns(recording)
        if drive != "either" and drive not in columns:
            raise ModelError(f"the recording has no {drive}; let another channel drive the model")
        self.t = columns["t"]
        n = self.t.size
        episode = columns.get("episode", np.zeros(n))
        self._first = np.r_[1.0, np.diff(episode) != 0.0][:n]
        none = np.full(n, np.nan)
        self._force = columns.get("normal_force", none)
        self._load = self._force if load == "measured" else none
        self._motion = _motion(self.t, episode, columns["displacement"] if drive != "normal_force" else None)
        if drive == "either":
            self._motion[np.isnan(columns["displacement"]) & np.isfinite(self._force)] = np.nan, 0.0
        self.is_by_force = bool(np.isnan(self._motion).any())
        self._outside = _outside(columns, n, model.reference_temperature)
        self._asked = np.full(n, 2.0) if asked is None else asked
        self._run_by(model, plain=plain)

    def _run_by(self, model: ContactModel, *, plain: bool) -> None:
        self._span = np.array([-model.reference_depth, model.tip_radius])
        lasting = [float(s.lasting) for e in model.effects for s in e.states]
        self._fresh = np.stack([model.initial_states, np.array(lasting)])
        self._batch = model.compiled(plain=plain)

    def of(self, model: ContactModel) -> "Predictor":
        """Return the same recording, not copied, for a model of the same reference temperature."""
        new = copy.copy(self)
        new._run_by(model, plain=False)
        return new

    def __call__(
        self,
        vector: Floats,
        zeros: tuple[ArrayLike, ArrayLike] = (0.0, 0.0),
        speed: Floats | None = None,
    ) -> Floats:
        """Return (n, 14), columns :data:`QUANTITIES`, for ``vector`` as :attr:`ContactModel.vector`.

        ``zeros``: what the sensors of displacement [m] and normal force [N] show where there is none, a
        number or (n,) each. It is taken off what was measured; the force that comes out is without it.
        ``speed`` (n,) [m/s] replaces that of the displacement.
        """
        motion, beside = self._motion, (self.t, self._first)
        zero, bias = (np.asarray(one, dtype=np.float64) for one in zeros)
        load, force = self._load - bias, self._force - bias
        if self.is_by_force or np.any(zero):
            motion = np.stack([motion[:, 0] - zero, motion[:, 1]], axis=1)
        if speed is not None:
            motion = np.stack([motion[:, 0], speed], axis=1)
        if self.is_by_force:
            self._batch.depths(vector, self._fresh, *beside, motion, force, self._outside, self._span)
        out = np.empty((len(QUANTITIES), self.t.size))
        self._batch.channels(vector, self._fresh, *beside, motion, load, self._outside, self._asked, out)
        return out.T


def predict(
    model: ContactModel,
    recording: Recorded | Mapping[str, ArrayLike],
    *,
    drive: Drive = "displacement",
    load: Load = "measured",
    plain: bool = False,
) -> dict[str, Floats]:
    """Return what ``model`` says of every sample of ``recording``, (n,) by the names of :data:`QUANTITIES`.

    Episodes start recovered. See :class:`Predictor` for the arguments and errors.
    """
    table = Predictor(model, recording, drive=drive, load=load, plain=plain)(model.vector)
    return dict(zip(QUANTITIES, table.T, strict=True))


def _columns(recording: Recorded | Mapping[str, ArrayLike]) -> dict[str, Floats]:
    if not isinstance(recording, Mapping):
        recording = {"t": recording.t, "episode": recording.episode, **recording.columns}
    return {name: np.ascontiguousarray(values, dtype=np.float64) for name, values in recording.items()}


def _motion(t: Floats, episode: Floats, displacement: Floats | None) -> Floats:
    """Return indentation and speed (n, 2); NaN and 0 where the force drives.

    The speed is that at the sample, between those of the steps before and after: that of the step before is
    half a step old, and a friction that follows it turns a sample late.
    """
    motion = np.stack([np.full(t.size, np.nan), np.zeros(t.size)], axis=1)
    if displacement is None:
        return motion
    for number in np.unique(episode):
        rows = np.flatnonzero(episode == number)
        known = rows[np.isfinite(displacement[rows])]
        if known.size:
            motion[rows, 0] = np.interp(t[rows], t[known], displacement[known])
            steps = np.diff(motion[rows, 0]) / np.diff(t[rows])
            motion[rows[1:], 1] = steps
            motion[rows[:1], 1] = steps[:1]
            motion[rows[1:-1], 1] = 0.5 * (steps[:-1] + steps[1:])
    return motion


def _outside(columns: Mapping[str, Floats], n: int, temperature: float) -> Floats:
    """Return what effects may feel, (n, 6); what is not measured is held, as it is on line."""
    none = np.full(n, np.nan)
    x, y = columns.get("tangential_force_x", none), columns.get("tangential_force_y", none)
    x, y = np.where(np.isnan(x) & ~np.isnan(y), 0.0, x), np.where(np.isnan(y) & ~np.isnan(x), 0.0, y)
    speed = columns.get("slip_speed", none)
    if "slip" in columns:
        speed = np.where(columns["slip"] == 0.0, 0.0, speed)  # noise is not sliding
    given = {
        "temperature": columns.get("temperature", none),
        "tangential_force": np.hypot(x, y),
        "torque": columns.get("torque_z", none),
        "slip_speed": speed,
        "tangential_force_x": x,
        "tangential_force_y": y,
    }
    start = {"temperature": temperature}
    return np.stack([_held(given[name], start.get(name, 0.0)) for name in OUTSIDE], axis=1)


def _held(values: Floats, start: float) -> Floats:
    """Replace NaN by the last value before it, ``start`` where there is none."""
    last = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(values.size), -1))
    return np.where(last >= 0, values[last], start)
