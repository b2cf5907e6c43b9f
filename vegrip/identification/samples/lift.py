"""Two fingers that lift half a kilogram three times, as pads read it that read a tenth too low: a session.

The first lift is shared evenly, in the second the thumb carries most, in the third the index does.
"""

from pathlib import Path
from typing import Final

import numpy as np

from vegrip.identification.recording import Fingertip, Recording, write_recording
from vegrip.identification.recording.writer import SESSION
from vegrip.identification.sensors import GRAVITY
from vegrip.whole_file import write_whole

MASS_KG: Final = 0.5
GAINS: Final = {"thumb": 0.93, "index": 0.87}  # read / true
SHARES_OF_THUMB: Final = (0.5, 0.85, 0.2)
RATE_HZ: Final = 100.0
TIMES_S: Final = (
    0.0,
    1.0,
    1.4,
    1.8,
    2.4,
    5.6,
    6.0,
    6.3,
    7.0,
)  # open, touch, grip, lift, ..., put down, released
GRIP_N: Final = 9.0
NOISE_N: Final = 0.01
SEED: Final = 5


def write_lift(folder: Path) -> None:
    """Write the session."""
    rng = np.random.default_rng(SEED)
    each = np.arange(0.0, TIMES_S[-1], 1.0 / RATE_HZ)
    grip = GRIP_N * np.interp(each, TIMES_S, [0, 0, 1, 1, 1, 1, 1, 0, 0])
    carried = MASS_KG * GRAVITY * np.interp(each, TIMES_S, [0, 0, 0, 0, 1, 1, 0, 0, 0])
    t = np.arange(len(SHARES_OF_THUMB) * len(each)) / RATE_HZ
    for name, gain in GAINS.items():
        shares = [share if name == "thumb" else 1.0 - share for share in SHARES_OF_THUMB]
        read = gain * np.concatenate([share * carried for share in shares])
        down = rng.uniform(-np.pi, np.pi)  # in the frame of the finger
        true = {
            "normal_force": np.tile(grip, len(shares)),
            "tangential_force_x": read * np.cos(down) + rng.normal(0.0, 0.2),
            "tangential_force_y": read * np.sin(down) + rng.normal(0.0, 0.2),
        }
        columns = {key: np.round(value + rng.normal(0.0, NOISE_N, len(t)), 4) for key, value in true.items()}
        episode = np.zeros(len(t), dtype=np.int64)
        tip = Fingertip(9e-3, name)
        write_recording(Recording(f"lift {name}", t, episode, columns, tip), folder / name)
    write_whole(folder / SESSION, 'name = "lift"\n')
