"""Make the sample files anew, beside this module: ``python -m vegrip.identification.samples.make``."""

import gzip
from pathlib import Path

import can
import numpy as np

from vegrip.clock import NS
from vegrip.identification.samples import LOG, RADIUS, TABLE, recording
from vegrip.transport.codec import CanCodec
from vegrip.virtual.bench.protocol import Episode, Segment, hold, slip, triangles
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import FingertipSettings, SensorSettings

SEED = 3
RATE = 100.0  # [Hz]
LOGGED = 6.0  # [s] of the recording that go into the log
DEPTH = 1.6e-3  # [m]
TIP = FingertipSettings(radius=RADIUS, amplitudes=(0.25,), rates=(2.0,), friction=0.7, bristle_stiffness=1e10)
HIDDEN = {"adhesion": {"force": 0.05, "stretch": 0.06 * DEPTH}}  # [N], [m]
HEADER = "time_s,trial,depth_mm,force_mN,pull_x_mN,pull_y_mN,turn_mNm,sliding,slip_mm_s"
FORMAT = "%.4f,%d,%.4f,%.1f,%.1f,%.1f,%.2f,%d,%.3f"


def protocol() -> tuple[Episode, ...]:
    """Return presses at two speeds, holds at two depths, and two pulls, with clear air around each."""
    away = Segment(0.6, depth=-0.25 * DEPTH)
    episodes = (
        hold(DEPTH, 5.0),
        triangles(DEPTH, 0.5 * DEPTH, 1),
        triangles(0.7 * DEPTH, 4.0 * DEPTH, 3),
        hold(0.4 * DEPTH, 3.0),
        slip(1.0, 0.5, pull=0.5 * DEPTH),
        slip(2.5, 0.5, pull=0.5 * DEPTH),
    )
    return tuple((away, *episode, away) for episode in episodes)


def table() -> str:
    """Return the table of the test rig."""
    sensors = SensorSettings(rate=RATE, force_bias=2e-3)
    columns = run_trial(
        TIP, protocol(), sensors, SEED, hidden=HIDDEN, rings=8, spokes=16, truth=False
    ).columns
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
    return "\n".join((HEADER, *rows)) + "\n"


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


def make(folder: Path) -> None:
    """Write all into ``folder``."""
    folder.joinpath(f"{TABLE}.gz").write_bytes(gzip.compress(table().encode(), mtime=0))
    write_log(folder / LOG)


if __name__ == "__main__":
    make(Path(__file__).parent)
