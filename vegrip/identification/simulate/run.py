"""From a model and a protocol, or the motion of a recording, to a recording."""

from collections.abc import Mapping

import numpy as np

from vegrip.errors import UsageError
from vegrip.identification.fit.noise import noise_of
from vegrip.identification.fit.preprocess import prepare
from vegrip.identification.recording import Fingertip, Recording
from vegrip.identification.recording.channels import CHANNELS, NOISES, noise_name
from vegrip.identification.simulate.protocol import Protocol
from vegrip.identification.simulate.rubbing import AT, rubbed
from vegrip.identification.simulate.timeline import Floats, Timeline, timeline
from vegrip.model import ContactModel, Predictor
from vegrip.spelling import suggestion

STEP = 1e-3  # [s] the longest between two instants of the model
SENSORS: Mapping[str, float] = {
    "normal_force": 0.01,
    "displacement": 5e-6,
    "tangential_force": 0.01,
    "torque_z": 1e-4,
    "slip_speed": 5e-5,
}
"""Standard deviations of the usual sensors [SI]; what a sensor set does not name is not measured."""

LATERAL = ("tangential_force_x", "tangential_force_y", "torque_z", "slip", "slip_speed")


def simulate(
    model: ContactModel,
    protocol: Protocol,
    *,
    sensors: Mapping[str, float] = SENSORS,
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
    several = max(1, int(np.ceil(1.0 / (rate * STEP))))
    line = timeline(protocol, 1.0 / (rate * several))
    warm = model.reference_temperature if temperature is None else temperature
    given = {
        "t": line.t,
        "episode": line.episode.astype(np.float64),
        "temperature": np.full(line.t.size, warm),
    }
    depth = _motion(model, line, given)
    exact = _quantities(model, rubbed(model, line, {**given, "displacement": depth}))
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
    the model, elsewhere the tangential loads are as they were measured.
    """
    noise = noise_of(recording)
    measured = prepare(recording, noise)
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
    told = {name: table[:, AT[name]] for name in ("normal_force", "contact_radius")}
    return {name: columns[name] for name in ("displacement", "temperature", *LATERAL)} | told


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
    unknown = sensors.keys() - set(NOISES)
    if unknown:
        name = min(unknown)
        raise UsageError(f"there is no sensor {name}; {suggestion(name, NOISES)}")
    if not {"normal_force", "displacement"} <= sensors.keys():
        raise UsageError("the sensors need normal_force and displacement; nothing could be fitted without")
