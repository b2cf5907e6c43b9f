"""Whatever the sensors send, every command is a force within its limits and none expires unseen."""

import dataclasses
import math
import os

import numpy as np

from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.grip.node import GraspForce
from vegrip.grip.settings import ControlSettings
from vegrip.messages import FingertipState, ForceCommand
from vegrip.model import paper_model

SAMPLES = int(os.environ.get("VEGRIP_FUZZ", "6000"))
PERIOD = 2_000_000  # [ns]
POISON = (math.nan, math.inf, -math.inf, 1e300, -1e300, 5e-324, 0.0, -1.0, 1e9)
CHANNELS = [field.name for field in dataclasses.fields(FingertipState)][3:]


def sample(rng, count, stamp, finger):
    press = max(math.sin(1e-3 * count), 0.0)
    good = FingertipState(
        stamp, finger, count, 2.0 * press + 0.01 * rng.standard_normal(), 0.6 * press, 0.0, 1e-3 * press,
        1e-3 * press - 1e-5, 25.0, 0.0, 0.0, math.nan,
    )  # fmt: skip
    if rng.random() < 0.7:
        return good
    poisoned = {name: POISON[rng.integers(len(POISON))] for name in CHANNELS if rng.random() < 0.3}
    seq = int(rng.choice([count, count, 0, count - 1, 2**40]))
    return dataclasses.replace(good, seq=seq, **poisoned)


def test_every_command_is_a_force_within_its_limits():
    rng, settings = np.random.default_rng(1), ControlSettings()
    model = paper_model(8e-3)
    node = GraspForce("grasp", ("thumb", "index"), lambda _: ContactEstimator(model, SensorNoise()), settings)
    node.configure()
    node.activate()
    now, commands, last = 0, 0, {}
    for i in range(SAMPLES):
        now += PERIOD
        stamp = now + int(rng.choice([0, 0, 0, 0, -5, 1, 40]) * 1_000_000)
        finger = str(rng.choice(["thumb", "index", "index", "stranger"]))
        answers = [*node.on_message(sample(rng, i, stamp, finger), now), *node.on_tick(now)]
        for command in answers:
            if isinstance(command, ForceCommand):
                commands += 1
                assert math.isfinite(command.normal_force)
                assert settings.limits.min_force <= command.normal_force <= settings.limits.max_force
                assert command.expires > now
                last[command.finger] = command
        assert all(command.expires > now for command in last.values()), "renewed before it expires"
    assert commands > SAMPLES // 2
    assert set(last) == {"thumb", "index"}
    assert node.rejected["unknown finger"] > 0
