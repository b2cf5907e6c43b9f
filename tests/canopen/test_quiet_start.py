"""A good start alarms nobody: fingers that come a moment later are waited for, not missed."""

import logging

from .conftest import GRASP, INDEX, THUMB, eventually

LIMIT = 0.5  # [s]
BEATS = 5  # of ours, 0.2 s each: longer than the limit


def test_fingers_that_come_later_than_the_limit_of_a_heartbeat_raise_no_alarm(grasp, fingers, other, caplog):
    caplog.set_level(logging.INFO, "vegrip")
    beats, emergencies = [], []
    other.subscribe(0x700 + GRASP, lambda *_: beats.append(1))
    other.subscribe(0x80 + GRASP, lambda _, data, __: emergencies.append(bytes(data)))
    ours = grasp(heartbeat_limit=LIMIT, first_heartbeat=600.0)
    eventually(lambda: len(beats) > BEATS)
    assert "waits for thumb (node 32), index (node 33)" in caplog.text
    assert not [record for record in caplog.records if record.levelno >= logging.WARNING]
    assert not [data for data in emergencies if any(data)]
    assert "heartbeat_lost" not in ours.endpoint.rejected
    fingers(THUMB)
    fingers(INDEX)
    eventually(lambda: ours.state == "ACTIVE")
