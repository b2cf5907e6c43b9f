"""ROS 2 types are those of ROS 2: definitions and bytes are compared with those of rosbags."""

import pytest

from vegrip.bridges import ros2_types as ros2
from vegrip.messages import Condition, ForceCommand, Lifecycle, ModelHealth, NodeStatus, Reason

typesys = pytest.importorskip("rosbags.typesys")
STORE = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
STAMP = 1_700_000_000_000_000_005


@pytest.mark.parametrize("name", [name for name in ros2.STANDARD if name != ros2.LOG])
def test_a_standard_type_has_the_fields_of_its_release(name: str) -> None:
    read = typesys.get_types_from_msg(ros2.definition(name), name)
    for part, (constants, fields) in read.items():
        assert (constants, fields) == tuple(STORE.fielddefs[part]), part


def test_a_wrench_has_the_bytes_that_rosbags_writes() -> None:
    row = {"normal_force": "3.0", "tangential_force_x": "0.1", "torque_z": "0.001"}
    data = ros2.wrench_of(row, STAMP, "thumb")
    read = STORE.deserialize_cdr(data, ros2.WRENCH)
    assert (read.header.stamp.sec, read.header.stamp.nanosec) == (1_700_000_000, 5)
    assert (read.header.frame_id, read.wrench.force.z, read.wrench.torque.z) == ("thumb", 3.0, 1e-3)
    assert bytes(STORE.serialize_cdr(read, ros2.WRENCH)) == data


def test_compression_is_the_positive_z_of_a_wrench() -> None:
    row = {"normal_force": "2.5", "tangential_force_x": "0.5", "torque_z": ""}
    wrench = STORE.deserialize_cdr(ros2.wrench_of(row, 0, "index"), ros2.WRENCH).wrench
    assert (wrench.force.x, wrench.force.z) == (0.5, 2.5)
    assert wrench.force.y != wrench.force.y  # not measured
    assert wrench.torque.z != wrench.torque.z


def test_a_command_has_no_part_along_the_face() -> None:
    row = ros2.row_of(ForceCommand(1, "thumb", 0, 3.0, 0.0, Reason.HOLD, 9), 0)
    data = ros2.message_of(ros2.WRENCH, "/left/hand/thumb/force_command", ForceCommand, row, 0)
    said = STORE.deserialize_cdr(data, ros2.WRENCH)
    force, torque = said.wrench.force, said.wrench.torque
    assert (said.header.frame_id, force.x, force.y, force.z, torque.z) == ("thumb", 0.0, 0.0, 3.0, 0.0)


@pytest.mark.parametrize(
    ("message", "name", "level", "said"),
    [
        (ModelHealth(5, "thumb", 7, Condition.OK, 1.0, consistent=True), "vegrip/left/thumb", 0, "ok"),
        (ModelHealth(5, "thumb", 7, Condition.OK, 9.0, consistent=False), "vegrip/left/thumb", 1, "ok"),
        (ModelHealth(5, "thumb", 7, Condition.STALE, 1.0, consistent=True), "vegrip/left/thumb", 1, "stale"),
        (NodeStatus(5, "/left/grip", 1, Lifecycle.ACTIVE), "/left/grip", 0, "active"),
        (NodeStatus(5, "/left/grip", 1, Lifecycle.INACTIVE), "/left/grip", 1, "inactive"),
    ],
)
def test_a_finger_whose_model_fails_and_a_node_that_is_not_active_are_warnings(
    message, name: str, level: int, said: str
) -> None:
    row = ros2.row_of(message, 0)
    topic = "/left/hand/thumb/model_health"
    data = ros2.message_of(ros2.DIAGNOSTICS, topic, type(message), row, STAMP)
    read = STORE.deserialize_cdr(data, ros2.DIAGNOSTICS)
    (status,) = read.status
    assert (status.name, status.level, status.message) == (name, level, said)
    assert {one.key: one.value for one in status.values} == row
    assert bytes(STORE.serialize_cdr(read, ros2.DIAGNOSTICS)) == data


def test_a_topic_has_one_type_whatever_comes() -> None:
    ends = [
        (f"/hand/thumb/{kind.__name__}", kind) if kind is not NodeStatus else ("/diagnostics", kind)
        for kind in ros2.TYPES
    ]
    types: dict[str, set[str]] = {}
    for topic, kind in ends:
        for end, name in ros2.ends_of(topic, kind).items():
            types.setdefault(end, set()).add(name)
    assert types["/diagnostics"] == {ros2.DIAGNOSTICS}
    assert {len(names) for names in types.values()} == {1}
