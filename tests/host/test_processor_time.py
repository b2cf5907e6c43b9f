"""What a process took of the processor."""

import math
import os
import time

import pytest

from vegrip.host.realtime import processor_time


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="needs /proc")  # noqa: PTH110
def test_it_is_what_the_process_itself_counts() -> None:
    end = time.process_time() + 0.1
    while time.process_time() < end:
        pass
    assert processor_time(os.getpid()) == pytest.approx(time.process_time(), abs=0.03)


def test_it_is_not_known_of_a_process_that_is_not_there() -> None:
    assert math.isnan(processor_time(2**22 + 1))
