"""Laws of logging."""

import logging

from vegrip.runtime.process import OncePerSecond, node_logs


def record(line, text="x"):
    return logging.LogRecord("vegrip", logging.WARNING, "file.py", line, text, None, None)


def test_a_source_line_speaks_once_a_second_and_tells_how_often_it_would_have():
    now = [0.0]
    limit = OncePerSecond(lambda: now[0])
    let_through = []
    for i in range(2500):
        now[0] = i * 0.001
        entry = record(1)
        if limit.filter(entry):
            let_through.append((now[0], entry.msg))
    assert [time for time, _ in let_through] == [0.0, 1.0, 2.0]
    assert "999 more" in let_through[1][1]


def test_source_lines_do_not_silence_each_other():
    limit = OncePerSecond(lambda: 5.0)
    assert [limit.filter(record(line)) for line in (1, 2, 1, 3)] == [True, True, False, True]


def test_logs_bear_the_name_of_the_node_and_handlers_are_taken_away_again(capsys):
    before = list(logging.getLogger().handlers)
    with node_logs("/left/grip"):
        logging.getLogger("vegrip.x").info("hello")
    assert "INFO /left/grip: hello" in capsys.readouterr().err
    assert logging.getLogger().handlers == before
