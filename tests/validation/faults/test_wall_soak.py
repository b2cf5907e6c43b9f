"""What counts as a leak in the soak of real processes; the soak itself is ``make soak-wall``."""

import os

import pytest

from validation.faults.wall_clock_soak import Footprint

MB = 1_000_000


USUAL = {"memory": 200 * MB, "descriptors": 20, "threads": 5}


def footprint(seconds, **course):
    times = [float(t) for t in range(seconds)]
    courses = {name: [value] * seconds for name, value in USUAL.items()}
    courses |= {name: [round(law(t)) for t in times] for name, law in course.items()}
    return Footprint("node", times, **courses)


@pytest.mark.parametrize(
    ("seconds", "course", "found"),
    [
        (180, {}, []),
        (180, {"memory": lambda t: 200 * MB + 2 * MB * t / 60}, ["node grows by 2.0 MB/min"]),
        (180, {"memory": lambda t: 200 * MB + 5 * MB * min(t, 60) / 60}, []),  # caches that fill
        (40, {"memory": lambda t: 200 * MB + 9 * MB * t / 60}, []),  # too young to tell
        (180, {"descriptors": lambda t: 20 + t / 10}, ["node has 34 descriptors, and had 29"]),
        (180, {"descriptors": lambda t: 20 + 9 * (t % 30 < 5)}, []),  # open for a moment
        (180, {"threads": lambda t: 5 + (t > 20)}, []),
    ],
)
def test_what_goes_on_growing_is_a_leak_and_what_levels_off_is_none(seconds, course, found):
    assert list(footprint(seconds, **course).complaints()) == found


def test_a_living_process_is_looked_at_and_a_dead_one_left_as_it_was():
    used = Footprint("self")
    used.look(os.getpid())
    used.look(2**22 + 1)
    assert len(used.time) == 1
    assert used.memory[0] > MB
    assert used.descriptors[0] >= 3
    assert used.threads[0] >= 1
