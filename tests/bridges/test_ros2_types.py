"""ROS 2 types are those of ROS 2: definitions and bytes are compared with those of rosbags."""

import pytest

from vegrip.bridges import ros2_types as ros2

typesys = pytest.importorskip("rosbags.typesys")
STORE = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
STAMP = 1_700_000_000_000_000_005


@pytest.mark.parametrize("name", [name for name in ros2.PARTS if name != ros2.LOG])
def test_a_standard_type_has_the_fields_of_its_release(name: str) -> None:
    read = typesys.get_types_from_msg(ros2.definition(name), name)
    for part, (constants, fields) in read.items():
        assert (constants, fields) == tuple(STORE.fielddefs[part]), part


def test_a_wrench_has_the_bytes_that_rosbags_writes() -> None:
    data = ros2.wrench_message(STAMP, "thumb", (0.1, -0.2, 3.0), (0.0, 0.0, 1e-3))
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
