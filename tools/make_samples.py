"""Make the sample files anew, in ``vegrip/identification/samples``: ``python -m tools.make_samples``."""

import gzip
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import can
import cantools.database
import numpy as np

from vegrip.clock import NS
from vegrip.identification import samples
from vegrip.identification.samples import (
    FOREIGN_DATABASE,
    FOREIGN_LOG,
    LATER_TABLE,
    SAMPLE_LOG,
    SAMPLE_RADIUS_M,
    SAMPLE_TABLE,
    recording,
)
from vegrip.model import paper_model
from vegrip.transport.codec import CanCodec
from vegrip.transport.maps.checksums import make_crc
from vegrip.virtual.bench.protocol import Episode, Segment, hold, slip, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.sensor import SENSED_CHANNELS, Sensors
from vegrip.virtual.settings import FingertipSettings, SensorSettings

SAMPLES = Path(samples.__file__).parent
SEED = 3
SAMPLE_RATE_HZ = 100.0  # [Hz]
LOGGED = 6.0  # [s] of the recording that go into the log
PRESS_DEPTH_M = 1.6e-3  # [m]
TIP = FingertipSettings(
    radius=SAMPLE_RADIUS_M, amplitudes=(0.25,), rates=(2.0,), friction=0.7, bristle_stiffness=1e10
)
SOFTER = 0.89  # times the stiffness of the same fingertip later, and
LATER_ZERO_N = 14e-3  # [N] that the force sensor then shows without a load
HIDDEN_EFFECTS = {"adhesion": {"force": 0.05, "stretch": 0.06 * PRESS_DEPTH_M}}  # [N], [m]
CSV_HEADER = "time_s,trial,depth_mm,force_mN,pull_x_mN,pull_y_mN,turn_mNm,sliding,slip_mm_s"
FORMAT = "%.4f,%d,%.4f,%.1f,%.1f,%.1f,%.2f,%d,%.3f"


def protocol() -> tuple[Episode, ...]:
    """Return presses at two speeds, holds at two depths, and two pulls, with clear air around each."""
    away = Segment(0.6, depth=-0.25 * PRESS_DEPTH_M)
    episodes = (
        hold(PRESS_DEPTH_M, 5.0),
        triangles(PRESS_DEPTH_M, 0.5 * PRESS_DEPTH_M, 1),
        triangles(0.7 * PRESS_DEPTH_M, 4.0 * PRESS_DEPTH_M, 3),
        hold(0.4 * PRESS_DEPTH_M, 3.0),
        slip(1.0, 0.5, pull=0.5 * PRESS_DEPTH_M),
        slip(2.5, 0.5, pull=0.5 * PRESS_DEPTH_M),
    )
    return tuple((away, *episode, away) for episode in episodes)


def table(*, is_later: bool = False) -> str:
    """Return the table of the test rig; ``is_later``: after the pad softened and the sensor's zero moved."""
    sensors = SensorSettings(rate=SAMPLE_RATE_HZ, force_bias=2e-3)
    first = Sensors(sensors, ("tip",), np.random.default_rng(SEED)).bias[0]  # the same sensors later
    tip = replace(TIP, reference_force=SOFTER * TIP.reference_force) if is_later else TIP
    noise = replace(sensors, force_bias=0.0, displacement_bias=0.0) if is_later else sensors
    columns = run_trial(
        tip, protocol(), noise, SEED + is_later, hidden=HIDDEN_EFFECTS, rings=8, spokes=16, truth=False
    ).columns
    if is_later:
        for name, bias in zip(SENSED_CHANNELS, first, strict=True):
            if name in columns:
                columns[name] = columns[name] + bias + LATER_ZERO_N * (name == "normal_force")
    chosen = [
        columns["t"],
        columns["episode"],
        1e3 * columns["displacement"],
        1e3 * columns["normal_force"],
        1e3 * columns["tangential_force_x"],
        1e3 * columns["tangential_force_y"],
        1e3 * columns["torque_z"],
        columns["slip"],
        1e3 * columns["slip_speed"],
    ]
    rows = (FORMAT % tuple(row) for row in np.array(chosen).T)
    return "\n".join((CSV_HEADER, *rows)) + "\n"


def write_log(path: Path) -> None:
    """Write the first seconds of the recording as CAN FD frames of the thumb."""
    codec = CanCodec(("thumb",), fd=True)
    with can.BLFWriter(str(path)) as log:
        for state in recording().states("thumb"):
            if state.stamp < LOGGED * NS:
                for frame in codec.encode(state):
                    log.on_message_received(
                        can.Message(
                            timestamp=state.stamp / NS,
                            arbitration_id=frame.arbitration_id,
                            data=frame.data,
                            is_fd=True,
                            is_extended_id=False,
                        )
                    )


def foreign_motion(seed: int = SEED) -> dict[str, np.ndarray]:
    """Return what the left tip of the foreign gripper does, in SI: rest, press, shear, twist, noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 10.0, 1.0 / SAMPLE_RATE_HZ)
    depth = np.interp(
        t, [0, 2.2, 3.0, 4.4, 4.8, 5.2, 6.0, 9.6, 9.9], np.array([-3, -3, 12, 12, -3, -3, 12, 12, -3]) * 1e-4
    )
    shear = np.interp(t, [5.9, 6.5, 7.5, 7.9], [0.0, 0.35, 0.35, 0.0])
    twist = np.interp(t, [8.0, 8.5, 9.2, 9.5], [0.0, 2e-3, 2e-3, 0.0])
    force = paper_model(SAMPLE_RADIUS_M).simulate(t, depth).normal_force
    return {
        "t": t,
        "displacement": depth + 2e-6 * rng.standard_normal(t.size),
        "normal_force": force + 0.02 * rng.standard_normal(t.size),
        "tangential_force_x": shear * force + 0.02 * rng.standard_normal(t.size),
        "tangential_force_y": 0.05 * force + 0.02 * rng.standard_normal(t.size),
        "torque_z": twist * (force > 0.1) + 2e-4 * rng.standard_normal(t.size),
    }


def foreign_frames(motion: Mapping[str, np.ndarray], number: int) -> Iterator[can.Message]:
    """Yield what tip ``number`` of the foreign gripper sends: loads and motion in turn, in its units."""
    database: Any = cantools.database.load_string((SAMPLES / FOREIGN_DATABASE).read_text(), "dbc")
    name, crc = ("TIP_L", "TIP_R")[number], make_crc(8, 0x31, 0xFF, 0, reflected=False)
    grams = 1.0 / 9.80665e-3  # [gf/N]
    for n, t in enumerate(motion["t"]):
        at = {key: float(values[n]) for key, values in motion.items()}
        motions = {"Stroke": -1e3 * at["displacement"], "Spin": 1e2 * at["torque_z"], "Slipping": 0}
        loads = {
            "LoadA": 30.0 - grams * at["normal_force"],
            "LoadB": grams * at["tangential_force_y"],
            "LoadC": grams * at["tangential_force_x"],
        }
        for page, values in ((1, motions), (0, loads)):
            signals = {"Page": page, "AliveCtr": (2 * n + 1 - page) % 16, "Check": 0, **values}
            data = bytearray(database.encode_message(name, signals, strict=False))
            data[7] = crc(data[:7])
            stamp = t + 1e-3 * (1 - page) + 2e-4 * number
            yield can.Message(timestamp=stamp, arbitration_id=785 + number, data=data, is_extended_id=False)


def write_foreign(path: Path) -> None:
    """Write ten seconds of the foreign gripper, of which only the left tip is touched."""
    left = foreign_motion()
    rng = np.random.default_rng(SEED + 1)
    noise = {"displacement": 2e-6, "torque_z": 2e-4}
    right = {k: v[0] + noise.get(k, 0.02) * rng.standard_normal(v.size) for k, v in left.items()} | {
        "t": left["t"]
    }
    messages = sorted(
        (*foreign_frames(left, 0), *foreign_frames(right, 1)), key=lambda message: message.timestamp
    )
    with can.BLFWriter(str(path)) as log:
        for message in messages:
            log.on_message_received(message)


def make(folder: Path) -> None:
    """Write all into ``folder``."""
    write_foreign(folder / FOREIGN_LOG)
    folder.joinpath(f"{SAMPLE_TABLE}.gz").write_bytes(gzip.compress(table().encode(), mtime=0))
    folder.joinpath(f"{LATER_TABLE}.gz").write_bytes(gzip.compress(table(is_later=True).encode(), mtime=0))
    write_log(folder / SAMPLE_LOG)


if __name__ == "__main__":
    make(SAMPLES)
