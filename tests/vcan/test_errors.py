"""What a CAN controller reports with error frames is counted by name and told to everybody."""

import can
import pytest

from vegrip.clock import WallClock
from vegrip.messages import NodeStatus
from vegrip.runtime.echo import EchoNode, EchoParameters
from vegrip.runtime.runner import LoopSettings, Runner

BUS_OFF, CONTROLLER, PROTOCOL = 0x40, 0x04, 0x08  # classes of linux/can/error.h


def error(kind, controller=0):
    data = bytes([0, controller, 0, 0, 0, 0, 0, 0])
    return can.Message(arbitration_id=kind, is_error_frame=True, is_extended_id=False, data=data)


@pytest.mark.parametrize(
    ("frame", "name"),
    [
        (error(BUS_OFF), "bus_off"),
        (error(CONTROLLER, 0x10), "error_passive"),
        (error(CONTROLLER, 0x20), "error_passive"),
        (error(PROTOCOL), "error_frame"),
    ],
)
def test_an_error_frame_is_counted_by_what_it_says(endpoint, bus, frame, name):
    node, controller = endpoint(), bus()
    controller.send(frame)
    assert node.receive(0.2) == []
    assert node.rejected == {name: 1}


def test_a_node_that_hears_of_bus_off_goes_on_and_says_so_on_the_bus(endpoint, bus):
    settings = LoopSettings(tick_period=0.01, status_period=0.05)
    runner = Runner(EchoNode("grasp_force", EchoParameters()), endpoint(), WallClock(), settings)
    listener, controller = endpoint(), bus()
    runner.start()
    controller.send(error(BUS_OFF))
    statuses = []
    for _ in range(40):
        runner.step()
        statuses += [m for m in listener.receive(0.0) if isinstance(m, NodeStatus)]
    assert runner.status.rejected["bus_off"] == 1
    assert statuses[-1].rejected == {"other": 1}
    assert statuses[-1].state.name == "ACTIVE"
