"""From a model and a protocol, or the motion of a recording, to a recording; and a picture of that."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vegrip.errors import UsageError, suggestion
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import preprocess, without_lost_rows
from vegrip.identification.fit.problem import AT
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import CHANNELS, NOISE_NAMES, noise_name
from vegrip.identification.simulate.protocol import Protocol, Segment
from vegrip.model import ContactModel, Predictor
from vegrip.plotting import new_figure, save_figure
from vegrip.types import Floats

FIXED_POINT_ROUNDS = 3  # friction may depend on the speed of sliding, and force and radius on the load
MAX_STEP_S = 1e-3  # [s] the longest between two instants of the model
DEFAULT_NOISE: Mapping[str, float] = {
    "normal_force": 0.01,
    "displacement": 5e-6,
    "tangential_force": 0.01,
    "torque_z": 1e-4,
    "slip_speed": 5e-5,
}
"""Standard deviations of the usual sensors [SI]; what a sensor set does not name is not measured."""
LATERAL = ("tangential_force_x", "tangential_force_y", "torque_z", "slip", "slip_speed")
EPISODE_GAP_SHARE = 0.02  # of the duration, drawn between episodes in place of the pause


@dataclass(frozen=True)
class Piece:
    """A segment on the timeline: rows ``begin`` to ``end``, and the level it starts from if that is known."""

    segment: Segment
    begin: int
    end: int
    by_force: bool
    start: float | None  # [m] or [N]; None where the axis changes from depth to force or back
    stop: float | None  # None: as it started


@dataclass(frozen=True, eq=False)
class Timeline:
    """Instants of a protocol."""

    t: Floats  # (n,) [s], the pauses left out of the rows but not of the time
    episode: NDArray[np.int64]  # (n,) number
    pull: Floats  # (n, 3) velocity of the counter-surface x, y [m/s] and its spin [rad/s]
    pieces: tuple[Piece, ...]  # the segments, in order

    def imposed(self, depth: Floats, force: Floats) -> tuple[Floats, Floats]:
        """Return what is imposed, depth (n,) [m] and force (n,) [N], NaN where the other one is.

        ``depth`` and ``force`` are what is known of both so far; where the axis goes over from one to the
        other, a segment starts from there.
        """
        out = np.full((2, self.t.size), np.nan)
        for piece in self.pieces:
            known = force if piece.by_force else depth
            start = piece.start if piece.start is not None else float(known[piece.begin - 1])
            stop = start if piece.stop is None else piece.stop
            part = np.arange(1, piece.end - piece.begin + 1) / (piece.end - piece.begin)
            wave = np.sin(2.0 * np.pi * piece.segment.frequency * part * piece.segment.duration)
            path = start + part * (stop - start) + piece.segment.amplitude * wave
            out[int(piece.by_force), piece.begin : piece.end] = path
        return out[0], out[1]

    @property
    def changes(self) -> int:
        """How often the axis goes over between depth and force within one episode, at most."""
        count = np.zeros(int(self.episode.max()) + 1, dtype=int)
        for piece in self.pieces:
            count[self.episode[piece.begin]] += piece.start is None
        return int(count.max())


def timeline(protocol: Protocol, step: float) -> Timeline:
    """Return the instants of ``protocol``, ``step`` [s] apart; every segment has at least one."""
    t, episode, pull, pieces = [], [], [], []
    begin, time = 0, 0.0
    for number, segments in enumerate(protocol.episodes):
        by_force, level = False, 0.0
        ticks = 0
        for segment in segments:
            axis = by_force if segment.depth is None and segment.force is None else segment.force is not None
            stop = segment.force if axis else segment.depth
            count = max(1, round(segment.duration / step))
            start = level if axis == by_force else None if ticks else 0.0
            pieces.append(Piece(segment, begin, begin + count, axis, start, stop))
            by_force, level = axis, stop if stop is not None else level
            t.append(time + step * np.arange(ticks + 1, ticks + count + 1))
            pull.append(np.tile([segment.pull_x, segment.pull_y, segment.spin], (count, 1)))
            episode.append(np.full(count, number, dtype=np.int64))
            begin, ticks = begin + count, ticks + count
        time += ticks * step + protocol.pause
    return Timeline(np.concatenate(t), np.concatenate(episode), np.concatenate(pull), tuple(pieces))


def simulate_rubbing(model: ContactModel, line: Timeline, columns: dict[str, Floats]) -> dict[str, Floats]:
    """Return ``columns`` with tangential force x, y [N], torque [N m], slip and its speed [m/s].

    The load on a fingertip whose counter-surface moves rises elastically, then the contact slides. A Hertzian
    contact of an incompressible body is 2/3 as stiff tangentially as normally [Mindlin1949]_, and
    ``dN/dx = 3 N / (2 x)``, so a deflection (u_x, u_y, theta) since the motion began loads it with
    ``N / x (u_x, u_y, a^2 theta)``. Where that lies beyond the limit surface of the model, the contact slides
    and the deflection stays at the limit. A change of direction begins without a load.
    """
    none = np.zeros(line.t.size)
    loads = {"tangential_force_x": none, "tangential_force_y": none, "torque_z": none}
    full = {**columns, **loads, "slip": none, "slip_speed": none}
    moving, heading = np.any(line.pull != 0.0, axis=1), _heading(line)
    if not moving.any():
        return full
    table = Predictor(model, full, drive="displacement", load="model")(model.vector)
    deflection = np.where(moving, 1e-6, 0.0)  # [s] of motion: something to find the direction of the limit
    for _ in range(FIXED_POINT_ROUNDS):
        full |= _loads(table, heading, deflection)
        table = Predictor(model, full, drive="displacement", load="model")(model.vector)
        used = table[:, AT["utilisation"]]
        limit = np.where(used > 0.0, deflection / np.where(used > 0.0, used, 1.0), np.inf)
        touching = table[:, AT["contact_force"]] > 0.0
        deflection, sliding = _deflection(line, moving, limit, touching)
        velocity, a = line.pull, table[:, AT["contact_radius"]]
        speed = np.hypot(np.hypot(velocity[:, 0], velocity[:, 1]), 2.0 / 3.0 * a * velocity[:, 2])
        full |= {"slip": sliding.astype(np.float64), "slip_speed": np.where(sliding, speed, 0.0)}
    return full | _loads(table, heading, deflection)


def _heading(line: Timeline) -> Floats:
    """Return the last velocity (n, 3) at which the counter-surface moved in this episode."""
    out = np.zeros_like(line.pull)
    last = np.zeros(3)
    for piece in line.pieces:
        now = line.pull[piece.begin]
        if np.any(now != 0.0):
            last = now
        elif piece.begin == 0 or line.episode[piece.begin] != line.episode[piece.begin - 1]:
            last = np.zeros(3)
        out[piece.begin : piece.end] = last
    return out


def _loads(table: Floats, heading: Floats, deflection: Floats) -> dict[str, Floats]:
    N, x, a = (table[:, AT[name]] for name in ("contact_force", "indentation", "contact_radius"))
    stiffness = np.where((N > 0.0) & (x > 0.0), N / np.where(x > 0.0, x, 1.0), 0.0) * deflection
    fx, fy, torque = stiffness * heading[:, 0], stiffness * heading[:, 1], stiffness * a * a * heading[:, 2]
    return {"tangential_force_x": fx, "tangential_force_y": fy, "torque_z": torque}


def _deflection(
    line: Timeline, moving: NDArray[np.bool_], limit: Floats, touching: NDArray[np.bool_]
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the elastic deflection, as seconds of motion, and where the contact slides."""
    out, sliding = np.zeros(line.t.size), np.zeros(line.t.size, dtype=bool)
    for piece in line.pieces:
        fresh = piece.begin == 0 or line.episode[piece.begin] != line.episode[piece.begin - 1]
        turned = (
            not fresh and moving[piece.begin] and np.any(line.pull[piece.begin] != line.pull[piece.begin - 1])
        )
        now = 0.0 if fresh or turned else float(out[piece.begin - 1])
        for i in range(piece.begin, piece.end):
            if not touching[i]:
                now = 0.0
            elif moving[i]:
                now += float(line.t[i] - line.t[i - 1]) if i > piece.begin else 0.0
            if now > limit[i]:
                now, sliding[i] = float(limit[i]), bool(moving[i])
            out[i] = now
    return out, sliding


def simulate(
    model: ContactModel,
    protocol: Protocol,
    *,
    sensors: Mapping[str, float] = DEFAULT_NOISE,
    rate: float = 200.0,
    seed: int = 0,
    temperature: float | None = None,
) -> Recording:
    """Put ``model`` through ``protocol`` and measure it at ``rate`` [Hz].

    Args:
        model: whose values are the truth.
        protocol: what is imposed; between its samples the motion is straight.
        sensors: std of the white noise by channel, 0 = exact, SI; channels that are not there are not
            measured. Slip is felt where there is a ``slip_speed``.
        rate: of the samples [Hz].
        seed: of the noise; the same seed gives the same recording, bit for bit.
        temperature: [degrees Celsius] all the time, the model's reference when not given.

    """
    _check(sensors)
    several = max(1, int(np.ceil(1.0 / (rate * MAX_STEP_S))))
    line = timeline(protocol, 1.0 / (rate * several))
    warm = model.reference_temperature if temperature is None else temperature
    given = {
        "t": line.t,
        "episode": line.episode.astype(np.float64),
        "temperature": np.full(line.t.size, warm),
    }
    depth = _motion(model, line, given)
    exact = _quantities(model, simulate_rubbing(model, line, {**given, "displacement": depth}))
    rows = slice(several - 1, None, several)
    columns = {name: values[rows] for name, values in exact.items()}
    measured = _measured(columns, sensors, np.random.default_rng(seed))
    source: dict[str, str | int | float | bool] = {
        "made_by": "vegrip simulate",
        "protocol": protocol.name,
        "model": ", ".join(effect.name for effect in model.effects),
        "seed": seed,
    }
    tip = Fingertip(model.tip_radius)
    positive = {name: std for name, std in sensors.items() if std > 0.0}
    return Recording(protocol.name, line.t[rows], line.episode[rows], measured, tip, positive, source)


def like(model: ContactModel, recording: Recording, *, seed: int = 0) -> Recording:
    """Return what ``model`` would have measured in the motion of ``recording``, with the same sensors.

    The motion is that behind the noisy displacement; where the contact slid its load lies on the limit of
    the model, elsewhere the tangential loads are as they were measured. A gap of the displacement stays one.
    """
    noise, recording = noise_of(recording), without_lost_rows(recording)
    measured = preprocess(recording, noise)
    given = {"t": recording.t, "episode": recording.episode.astype(np.float64), **measured.columns}
    table = Predictor(model, given, load="model")(model.vector)
    out = dict(recording.columns)
    sensors = {
        name: float(getattr(noise, name)) for name in ("normal_force", "displacement", "contact_radius")
    }
    exact = {
        "displacement": measured.motion.displacement,
        "normal_force": table[:, AT["normal_force"]],
        "contact_radius": table[:, AT["contact_radius"]],
    }
    exact = {name: values for name, values in exact.items() if name in out}
    out |= _measured(exact, sensors, np.random.default_rng(seed))
    slides = np.nan_to_num(recording.columns.get("slip", np.zeros(len(recording)))) == 1.0
    used = table[:, AT["utilisation"]]
    factor = np.where(slides & (used > 0.0), 1.0 / np.where(used > 0.0, used, 1.0), 1.0)
    out |= {name: out[name] * factor for name in LATERAL[:3] if name in out}
    missing = {name: np.where(np.isnan(recording.columns[name]), np.nan, out[name]) for name in out}
    source: dict[str, str | int | float | bool] = {
        "made_by": "vegrip simulate", "motion_of": recording.name,
        "model": ", ".join(effect.name for effect in model.effects), "seed": seed,
    }  # fmt: skip
    return Recording(
        f"{recording.name} simulated", recording.t, recording.episode, missing,
        recording.fingertip, recording.sensors, source, recording.start,
    )  # fmt: skip


def _motion(model: ContactModel, line: Timeline, given: Mapping[str, Floats]) -> Floats:
    """Return the indentation that is imposed, or that the imposed force leads to [m]."""
    depth = force = np.zeros(line.t.size)
    for _ in range(line.changes + 1):
        imposed, pressed = line.imposed(depth, force)
        columns = {**given, "displacement": imposed, "normal_force": pressed}
        table = Predictor(model, columns, drive="either", load="model")(model.vector)
        depth, force = table[:, AT["displacement"]], table[:, AT["normal_force"]]
    return depth


def _quantities(model: ContactModel, columns: Mapping[str, Floats]) -> dict[str, Floats]:
    table = Predictor(model, columns, load="model")(model.vector)
    outputs = {name: table[:, AT[name]] for name in ("normal_force", "contact_radius")}
    return {name: columns[name] for name in ("displacement", "temperature", *LATERAL)} | outputs


def _measured(
    exact: Mapping[str, Floats], sensors: Mapping[str, float], rng: np.random.Generator
) -> dict[str, Floats]:
    """Return what the sensors show: white noise on each channel, magnitudes not below zero."""
    out = {}
    for name, values in exact.items():
        kind = noise_name(name)
        if name == "slip":
            if "slip_speed" in sensors:
                out[name] = values
        elif kind in sensors:
            seen = values + sensors[kind] * rng.standard_normal(values.size)
            out[name] = np.maximum(seen, 0.0) if name in ("slip_speed", "contact_radius") else seen
    return {name: out[name] for name in CHANNELS if name in out}


def _check(sensors: Mapping[str, float]) -> None:
    unknown = sensors.keys() - set(NOISE_NAMES)
    if unknown:
        name = min(unknown)
        raise UsageError(f"there is no sensor {name}; {suggestion(name, NOISE_NAMES)}")
    if not {"normal_force", "displacement"} <= sensors.keys():
        raise UsageError("the sensors need normal_force and displacement; nothing could be fitted without")


def draw_simulation(protocol: Protocol, models: dict[str, ContactModel], path: Path) -> None:
    """Draw ``protocol`` with the forces that ``models`` (by name) answer, and how they differ."""
    exact = dict.fromkeys(DEFAULT_NOISE, 0.0)
    found = {name: simulate(model, protocol, sensors=exact) for name, model in models.items()}
    one = next(iter(found.values()))
    t, loads = _drawn_time(one), bool(np.any(one.columns["slip"] > 0.0))
    rows = 2 + (len(found) > 1) + loads
    figure, axes = new_figure(rows, size=(10, 2.1 * rows), share_x=True)
    axes[0].plot(t, 1e3 * _cut(one, one.columns["displacement"]), "k", lw=1)
    axes[0].set_ylabel("depth [mm]")
    axes[0].set_title(f"{protocol.name}, {protocol.duration:.0f} s with pauses of {protocol.pause:g} s")
    for name, recording in found.items():
        axes[1].plot(t, _cut(recording, recording.columns["normal_force"]), lw=1, label=name)
    axes[1].set_ylabel("normal force [N]")
    axes[1].legend(fontsize=8)
    if len(found) > 1:
        base = one.columns["normal_force"]
        for i, (name, recording) in enumerate(found.items()):
            if i:
                difference = 1e3 * (recording.columns["normal_force"] - base)
                axes[2].plot(
                    t, _cut(one, difference), lw=1, color=f"C{i}", label=f"{name} - {next(iter(found))}"
                )
        axes[2].set_ylabel("before refits [mN]")
        axes[2].legend(fontsize=8)
    if loads:
        axes[-1].plot(
            t, _cut(one, np.hypot(one.columns["tangential_force_x"], one.columns["tangential_force_y"])), lw=1
        )
        axes[-1].set_ylabel("tangential [N]")
    axes[-1].set_xlabel("time without the pauses [s]")
    save_figure(figure, path)


def _drawn_time(recording: Recording) -> np.ndarray:
    """Return the time without pauses, one NaN row between episodes."""
    step = float(np.median(np.diff(recording.t)))
    length = len(recording) * step
    shift = np.r_[0, np.cumsum(np.diff(recording.episode) != 0)] * EPISODE_GAP_SHARE * length
    return _cut(recording, step * np.arange(len(recording)) + shift)


def _cut(recording: Recording, values: np.ndarray) -> np.ndarray:
    """Return ``values`` with a gap where an episode begins, so that no line crosses it."""
    starts = np.flatnonzero(np.diff(recording.episode)) + 1
    return np.insert(values.astype(float), starts, np.nan)
