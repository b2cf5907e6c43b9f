"""Over a foreign layout the estimates are those over our own, within the rounding of its signals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.transport.maps.hands import PLAIN_DBC, PLAIN_MAP, load, seeded, written
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.messages import FingertipState
from vegrip.model import paper_model
from vegrip.transport.codec import CanCodec, Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan
from vegrip.transport.maps.checksums import make_crc

FINE = PLAIN_DBC.replace("0|16@1- (0.01,0) [-300|300]", "0|16@1- (0.0005,0) [-16|16]")
FINE = FINE.replace("16|16@1- (0.01,0) [-300|300]", "16|16@1- (0.0005,0) [-16|16]")
FINE = FINE.replace("32|16@1- (0.01,0) [-300|300]", "32|16@1- (0.0005,0) [-16|16]")
ALL = PLAIN_MAP.replace('signal = "Tip1.Fx"', 'signal = "Tip1.Fx"\nzero_is_measured = true')
ALL = ALL.replace('signal = "Pos1.Tz"', 'signal = "Pos1.Tz"\nzero_is_measured = true')
ALL = ALL.replace('signal = "Pos1.Depth"', 'signal = "Pos1.Depth"\nzero_is_measured = true')
ALL = ALL.replace('signal = "Tip1.Fy"', 'signal = "Tip1.Fy"\nzero_is_measured = true')
ALL = ALL.replace(
    "[fingers.thumb.command]",
    '[fingers.thumb.slip]\nsignal = "Pos1.Slip"\nzero_is_measured = true\n[fingers.thumb.command]',
)
CRC = make_crc(8, 0x2F, 0xFF, 0xFF, reflected=False)


def motion():
    """A press, a hold and a pull at 200 Hz, rounded to what the foreign signals hold."""
    rng = seeded(5)
    t = np.arange(0.0, 3.0, 0.005)
    depth = np.interp(t, [0.0, 0.3, 0.9], [-2e-4, -2e-4, 1e-3])
    force = paper_model(tip_radius=8e-3).simulate(t, depth).normal_force
    pull = 0.3 * force * np.clip(t - 1.0, 0.0, 1.0)
    for n in range(t.size):
        yield FingertipState(
            stamp=1_000_000_000 + n * 5_000_000,
            finger="thumb",
            seq=n,
            normal_force=round((force[n] + rng.gauss(0, 0.01)) / 5e-4) * 5e-4,
            tangential_force_x=round((pull[n] + rng.gauss(0, 0.01)) / 5e-4) * 5e-4,
            tangential_force_y=round(rng.gauss(0, 0.01) / 5e-4) * 5e-4,
            torque_z=round(rng.gauss(0, 2e-4) / 1e-4) * 1e-4,
            displacement=round((depth[n] + rng.gauss(0, 5e-6)) / 1e-6) * 1e-6,
            slip=0.0,
        )


def test_estimates_over_their_layout_equal_those_over_ours_within_rounding(tmp_path):
    database = load(FINE)
    theirs = MappedCodec(open_plan(written(tmp_path, FINE, ALL)))
    sender, ours = (CanCodec(("thumb",), fd=True) for _ in range(2))
    tip, noise = paper_model(tip_radius=8e-3), SensorNoise(normal_force=0.01, displacement=5e-6)
    one, other = ContactEstimator(tip, noise), ContactEstimator(tip, noise)
    worst = 0.0
    for state in motion():
        (frame,) = sender.encode(state)
        mine = ours.decode(frame._replace(stamp=state.stamp))
        slow = {"Depth": 1e3 * state.displacement, "Tz": state.torque_z, "Slip": 0}
        theirs.decode_all(Frame(272, database.encode_message("Pos1", slow), False, state.stamp))
        fast = {"Fz": state.normal_force, "Fx": state.tangential_force_x, "Fy": state.tangential_force_y}
        data = bytearray(database.encode_message("Tip1", {**fast, "Cnt": state.seq % 16, "Crc": 0}))
        data[7] = CRC(data[:7])
        (mapped,) = theirs.decode_all(Frame(256, bytes(data), False, state.stamp))
        assert replace(mapped, seq=0).stamp == mine.stamp
        a, b = one.update(mine), other.update(mapped)
        for name in (
            "normal_force",
            "contact_radius",
            "pressure_exponent",
            "friction_coefficient",
            "limit_force",
        ):
            x, y = getattr(a, name), getattr(b, name)
            if math.isfinite(x.value) and math.isfinite(y.value):
                worst = max(worst, abs(x.value - y.value) / max(abs(x.std), 1e-9))
    assert a.in_contact
    assert worst < 1e-3  # of a standard deviation
    assert one.slip_margin().lower_bound == pytest.approx(other.slip_margin().lower_bound, abs=1e-4)
