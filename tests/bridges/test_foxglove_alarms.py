"""An alarm is two lines of the log: when it begins and when it is over."""

from vegrip.bridges.foxglove_alarms import AlarmLog
from vegrip.web.live.alarms import Alarm, Level

S = 1_000_000_000  # [ns] of a second
SLIP = Alarm("slip thumb", Level.BAD, "slip is felt", "thumb")
LIMIT = Alarm("limit index", Level.WARN, "the largest force is reached", "index")


def said(log, active, seconds):
    return [(line.level, line.name, line.text) for line in log.update(active, round(seconds * S))]


def test_an_alarm_that_lasts_is_told_once_and_then_that_it_is_over() -> None:
    log = AlarmLog()
    assert said(log, [SLIP], 0.0) == [("error", "thumb", "slip is felt")]
    assert said(log, [SLIP, LIMIT], 1.0) == [("warning", "index", "the largest force is reached")]
    assert said(log, [SLIP], 2.5) == []
    assert said(log, [SLIP], 3.5) == [("info", "index", "over: the largest force is reached")]
    assert said(log, [], 6.0) == [("info", "thumb", "over: slip is felt")]


def test_an_alarm_that_flickers_faster_than_it_is_read_is_one() -> None:
    log = AlarmLog()
    lines = [said(log, [SLIP] if number % 2 == 0 else [], 0.1 * number) for number in range(50)]
    assert sum(map(len, lines)) == 1
