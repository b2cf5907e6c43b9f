"""From the frames of a foreign gripper to commands in its units: the whole node, in the time of the log."""

import can
import cantools.database
import pytest

from vegrip.cli import main
from vegrip.estimator import ContactEstimator, SensorNoise
from vegrip.grip.node import GraspForce
from vegrip.grip.settings import ControlSettings
from vegrip.identification.samples import FOREIGN_DATABASE, FOREIGN_LOG, SAMPLES
from vegrip.messages import ForceCommand, ModelHealth, SlipMargin
from vegrip.model import paper_model
from vegrip.transport.codec import Frame
from vegrip.transport.mapped.codec import MappedCodec
from vegrip.transport.mapped.plan import open_plan

GRAM = 9.80665e-3  # [N]


@pytest.fixture
def hand(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in (FOREIGN_DATABASE, FOREIGN_LOG):
        SAMPLES[name].write(tmp_path / name)
    windows = ["--rest", "0..2", "--press", "2..5", "--shear", "5..8", "--twist", "8..10"]
    assert (
        main(["connect", FOREIGN_DATABASE, "-o", "hand.toml", "--log", FOREIGN_LOG, *windows, "--json"]) == 0
    )
    return tmp_path


def test_a_gripper_nobody_has_seen_has_its_margin_and_is_commanded_within_limits(hand):
    plan = open_plan(hand / "hand.toml")
    codec = MappedCodec(plan)
    settings = ControlSettings()
    noise = SensorNoise(normal_force=0.02, displacement=2e-6, tangential_force=0.02, torque_z=2e-4)
    node = GraspForce(
        "grasp_force", ("left", "right"), lambda _: ContactEstimator(paper_model(8e-3), noise), settings
    )
    node.configure()
    node.activate()
    margins, frames, healths = [], [], []
    with can.BLFReader(str(hand / FOREIGN_LOG)) as log:
        messages = list(log)
    for message in messages:
        now = round(message.timestamp * 1e9)
        for state in codec.decode_all(Frame(message.arbitration_id, bytes(message.data), False, now)):
            for answer in node.on_message(state, now):
                margins += [answer] if isinstance(answer, SlipMargin) and answer.finger == "left" else []
                healths += [answer] if isinstance(answer, ModelHealth) else []
                if isinstance(answer, ForceCommand):
                    frames += [(now, frame) for frame in codec.encode(answer)]
        node.on_tick(now)
    begin = messages[0].timestamp
    sheared = [m for m in margins if 6.6 < m.stamp / 1e9 - begin < 7.4]
    assert sheared
    assert all(m.margin.valid and m.lower_bound < m.margin.value for m in sheared)
    assert all(
        0.2 < m.margin.value < 0.8 for m in sheared
    )  # sheared with 0.35 of the force, at mu of about 0.7
    database = cantools.database.load_string((hand / FOREIGN_DATABASE).read_text(), "dbc")
    forces = [database.decode_message(f.arbitration_id, f.data)["Effort_L"] * GRAM for _, f in frames]
    assert len(forces) > 500
    limits = settings.limits
    assert all(0.0 <= force <= limits.max_force + GRAM for force in forces)
    during = [f for (now, _), f in zip(frames, forces, strict=True) if 6.6 < now / 1e9 - begin < 7.4]
    assert min(during) > 0.3
    assert codec.rejected == {}
    assert {health.condition.name for health in healths[20:]} <= {"OK", "DEGRADED", "MISSING"}
