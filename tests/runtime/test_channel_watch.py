"""What a finger measures is known after its first states, and what that costs is said once."""

from vegrip.identification.sensors import lacking
from vegrip.messages import FingertipState
from vegrip.runtime.channel_watch import STATES, ChannelWatch

SLOW = {
    "tangential_force_x": 0.1,
    "tangential_force_y": 0.1,
    "torque_z": 0.0,
    "displacement": 1e-3,
    "slip": 0.0,
}


def state(n, finger="thumb", **values):
    return FingertipState(n, finger, n, normal_force=1.0, **values)


def told(watch, **values):
    for n in range(STATES):
        watch.note(state(n, **values))
    return list(watch.news())


def test_a_finger_without_tangential_force_is_told_once():
    watch = ChannelWatch(lacking)
    sentence, *_ = told(watch)
    assert sentence.startswith("thumb: no slip margin and no grip command")
    assert told(watch) == []


def test_a_channel_that_comes_with_slower_messages_counts():
    watch = ChannelWatch(lacking)
    for n in range(STATES):
        slow = (
            {
                "tangential_force_x": 0.1,
                "tangential_force_y": 0.1,
                "torque_z": 0.0,
                "displacement": 1e-3,
                "slip": 0.0,
            }
            if n % 10 == 9
            else {}
        )
        watch.note(state(n, **slow))
    assert list(watch.news()) == []


def test_what_was_said_at_the_start_is_not_said_again():
    said = told(ChannelWatch(lacking))
    assert told(ChannelWatch(lacking, said)) == []


def test_made_up_names_do_not_make_the_table_grow():
    watch = ChannelWatch(lacking)
    for n in range(2000):
        watch.note(state(n, finger=f"f{n}"))
    assert len(watch._open) + len(watch._known) <= 256


def test_a_finger_is_fresh_once_when_those_that_speak_are_known():
    watch = ChannelWatch(lacking)
    for n in range(STATES):
        watch.note(state(n, slip=0.0))
        if n:
            watch.note(state(n, "index"))
    assert list(watch.fresh()) == []
    watch.note(state(STATES, "index"))
    assert list(watch.fresh()) == [
        ("thumb", frozenset({"normal_force", "slip"})),
        ("index", frozenset({"normal_force"})),
    ]
    assert list(watch.fresh()) == []
