"""States of a made-up finger that lead through every branch: air, loading, holding, slip, air."""

import math
from collections.abc import Iterator

from vegrip.messages import NAN, FingertipState

PERIOD = 2_000_000  # [ns]
COUNT = 120


def dummy_states(finger: str) -> Iterator[FingertipState]:
    """Yield states that make everything compile that the node will run."""
    for i in range(COUNT):
        press = math.sin(math.pi * max(0, i - 20) / (COUNT - 40)) if 20 < i < COUNT - 20 else 0.0
        yield FingertipState(
            stamp=i * PERIOD,
            finger=finger,
            seq=i,
            normal_force=2.0 * press + 1e-3 * math.sin(i),
            tangential_force_x=0.6 * press,
            tangential_force_y=0.1 * press,
            torque_z=NAN if i == 70 else 1e-3 * press,
            displacement=1e-3 * press,
            temperature=25.0,
            slip=1.0 if 60 < i < 64 else 0.0,
            slip_speed=1e-3 if 60 < i < 64 else 0.0,
            contact_radius=NAN,
        )
