"""One message of every kind that a running hand sends."""

import math

from vegrip import messages
from vegrip.messages import Condition, Estimate, FingertipState, ModelHealth, NodeStatus, SlipMargin

SENT = [
    FingertipState(1_500_000_000, "thumb", 3, normal_force=1.25, displacement=-1e-5),
    SlipMargin(2, "thumb", 4, Estimate(0.5, 0.1, valid=True, age=0.01), 0.25, 0.95, time_to_slip=math.inf),
    messages.ContactEstimate(3, "thumb", 5, in_contact=True, channels=messages.Channel.FORCE),
    messages.ForceCommand(4, "thumb", 6, 2.0, 0.5, messages.Reason.SLIP, 9),
    ModelHealth(5, "thumb", 7, Condition.STALE, 1.5, channel="normal_force", suspect="ä, umlaut"),
    messages.LearnedParameter(6, "thumb", 8, "mu", Estimate(0.5)),
    NodeStatus(7, "/grip", 9, messages.Lifecycle.ACTIVE, 500.0, rejected={"crc": 2, "value": 1}),
    messages.GraspStatus(8, "/grip", 10, messages.GraspPhase.HELD, "held"),
    messages.DeviceReport(9, "thumb", 11, friction=0.5),
]
