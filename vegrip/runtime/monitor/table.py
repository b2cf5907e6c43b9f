"""The live table: one row per finger, one line per node, the log below. As wide and high as the terminal."""

import math

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from vegrip import messages
from vegrip.clock import NS
from vegrip.runtime.monitor.board import BUSY, Board, LogLine, words
from vegrip.runtime.monitor.rows import FRESH, FingerRow, NodeRow, Now, Presence

BAR = 24  # characters of the margin bar
NARROW_BAR = 13  # as long as "no news 59 min"
SMALL_COLUMNS = 74  # columns below which measured force and reason give way to health
WIDE_COLUMNS = 118  # columns from which on everything is shown
FRAME = 2  # lines
WAITING = "no node runs yet, and this waits for one; `vegrip launch demo` starts some"
ON_PURPOSE = "cyan"
FRICTION = {messages.PROBED: "probing friction", messages.KNOWN: "friction known"}
"""What is done on purpose, by :attr:`vegrip.messages.ModelHealth.friction`."""
LIMIT = {
    messages.LIMIT_NEAR: ("near the largest force", "yellow"),
    messages.LIMIT_REACHED: ("more than the largest force", "bold red"),
}
"""What is needed, by :attr:`vegrip.messages.ModelHealth.limit`."""
REASON_STYLE = {
    messages.Reason.SLIP: "bold red",
    messages.Reason.RAISE: "yellow",
    messages.Reason.FORECAST: "yellow",
    messages.Reason.RATE_LIMIT: "yellow",
    messages.Reason.MAX_LIMIT: "bold red",
    messages.Reason.INPUT_HOLD: "red",
    messages.Reason.FAIL_SAFE: "red",
    messages.Reason.UNTRUSTED: "magenta",
    messages.Reason.LOWER: "cyan",
}
PRESENCE_STYLE = {
    Presence.STARTING: "dim",
    Presence.RUNNING: "",
    Presence.SILENT: "bold red",
    Presence.GONE: "bold red",
    Presence.STOPPED: "dim",
}


def render(
    board: Board,
    now: int,
    title: str = "vegrip",
    footer: RenderableType | None = None,
    size: tuple[int, int] = (150, 50),
) -> Panel:
    """Return the whole screen as of ``now`` [ns], for a terminal of ``size`` (columns, lines)."""
    columns, lines = size
    wide = columns >= WIDE_COLUMNS
    parts: list[RenderableType] = [Text(WAITING)]
    if board.rows or board.nodes:
        parts = [
            _fingers(board, now, wide=wide, small=columns < SMALL_COLUMNS),
            _nodes(board, now, wide=wide),
        ]
    taken = len(board.rows) + len(board.nodes) + 2 + FRAME + 1
    if board.busy:
        parts.append(_one_line(Text(board.busy, "bold yellow")))
        taken += 1
    if footer is not None:
        parts.append(footer)
        taken += 1
    left = max(lines - taken, 1)
    parts += [log_line(line) for line in list(board.log)[-left:]]
    clock = f"{(now - board.start) / NS:.1f} s"
    return Panel(Group(*parts), title=title, subtitle=clock, padding=(0, 1))


def finger_lines(board: Board, now: int) -> list[str]:
    """Return a line for each finger that says something at ``now`` [ns], for files and pipes."""
    if not board.rows and not board.nodes:
        return [WAITING]
    lines = []
    for finger, row in board.rows.items():
        if row.fresh(messages.SlipMargin, now) is not None:
            cells = (str(cell) for cell in _cells(finger, row, now, wide=False, alarm=True))
            _, force, _, margin, bound, command, why, health = cells
            text = f"N {force} N, margin {margin}, bound {bound}, F {command} N {why}, {health}"
            lines.append(f"{(now - board.start) / NS:7.2f} s  {finger}: {text}")
    return lines


def _fingers(board: Board, now: int, *, wide: bool, small: bool) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0), header_style="bold", expand=False)
    table.add_column("finger", min_width=7, no_wrap=True)
    if not small:
        _numbers(table, ("N [N]", 5))
    if wide:
        _numbers(table, ("a [mm]", 9), ("k", 9), ("mu", 9))
    bar = BAR if wide else NARROW_BAR
    table.add_column("margin, its bound |" if wide else "margin, |", min_width=bar, no_wrap=True)
    _numbers(table, ("margin", 6), ("bound", 5), ("F [N]", 5))
    if not small:
        table.add_column("why", min_width=10, no_wrap=True)
    reports = wide and any(row.newest(messages.DeviceReport) is not None for row in board.rows.values())
    if reports:  # what the device itself says of its contacts
        _numbers(table, ("its mu", 6), ("its F", 5))
    if wide:
        _numbers(table, ("age", 6))
    table.add_column("health", min_width=10)  # gives way first
    for finger, row in board.rows.items():
        stopped = row.source in board.nodes and board.nodes[row.source].presence is Presence.STOPPED
        cells = _cells(finger, row, now, wide=wide, alarm=not stopped)
        if reports:
            its = row.fresh(messages.DeviceReport, now) or messages.DeviceReport(0, finger, 0)
            cells[-2:-2] = [_number(its.friction, 2), _number(its.grip_force, 2)]
        table.add_row(*([cells[0], *cells[2:-2], cells[-1]] if small else cells))
    return table


def _numbers(table: Table, *columns: tuple[str, int]) -> None:
    for header, width in columns:
        table.add_column(Text(header), justify="right", min_width=width, no_wrap=True)


def _cells(finger: str, row: FingerRow, now: int, *, wide: bool, alarm: bool) -> list[RenderableType]:
    said = row.now(now)
    contact, margin, command = (
        said.contact or messages.ContactEstimate(0, finger, 0),
        said.margin,
        said.command,
    )
    learned = [
        _estimate(contact.contact_radius, 2, 1e3),
        _estimate(contact.pressure_exponent, 2),
        _estimate(contact.friction_coefficient, 2),
    ]
    measured = said.state.normal_force if said.state is not None else contact.normal_force.value
    return [
        finger,
        _number(measured, 2),
        *(learned if wide else []),
        _bar(said, BAR if wide else NARROW_BAR, alarm=alarm),
        _number(margin.margin.value if margin else math.nan, 2, valid=margin is None or margin.margin.valid),
        _number(margin.lower_bound if margin else math.nan, 2),
        _number(command.normal_force if command else math.nan, 2),
        Text(words(command.reason), REASON_STYLE.get(command.reason, "")) if command else "",
        *([_age(row, now)] if wide else []),
        _one_line(_health(said.health, is_new=row.announced is None)),
    ]


def _number(value: float, digits: int, *, valid: bool = True) -> Text:
    return Text(f"{value:.{digits}f}" if math.isfinite(value) else "-", "" if valid else "dim")


def _estimate(estimate: messages.Estimate, digits: int, scale: float = 1.0) -> Text:
    if not math.isfinite(estimate.value):
        return Text("-")
    spread = f"±{scale * estimate.std:.{digits}f}" if math.isfinite(estimate.std) else "±?"
    return Text(f"{scale * estimate.value:.{digits}f}{spread}", "" if estimate.valid else "dim")


def _bar(said: Now, width: int, *, alarm: bool) -> Text:
    margin, contact = said.margin, said.contact
    if margin is None:
        if not math.isfinite(said.margin_age):
            return Text("no margin yet", "dim")
        return Text(f"no news {spoken(said.margin_age)}", "bold red" if alarm else "dim")
    if not math.isfinite(margin.margin.value):
        return Text("no contact" if contact is not None and not contact.in_contact else "-", "dim")
    value, bound = min(max(margin.margin.value, 0.0), 1.0), margin.lower_bound
    full = round(width * value)
    colour = ON_PURPOSE if said.lets_go else _colour(bound if math.isfinite(bound) else value)
    text = Text("█" * full, colour)
    text.append("·" * (width - full), "dim")
    if math.isfinite(bound):
        at = min(max(round(width * bound), 0), width - 1)
        text = Text.assemble(text[:at], ("|", "bold reverse"), text[at + 1 :])
    return text


def _colour(margin: float) -> str:
    if margin < 0.05:
        return "red"
    return "yellow" if margin < 0.15 else "green"


def _age(row: FingerRow, now: int) -> Text:
    ages = [
        age
        for kind in (messages.SlipMargin, messages.ForceCommand)
        if math.isfinite(age := row.age(kind, now))
    ]
    if not ages:
        return Text("-", "dim")
    return Text(spoken(max(ages)), "" if max(ages) <= FRESH else "bold red")


def spoken(age: float) -> str:
    """Return an age [s] as one says it."""
    if age < 1.0:
        return f"{age:.1f} s"
    if age < 60.0:
        return f"{age:.0f} s"
    return f"{age / 60.0:.0f} min" if age < 5940.0 else f"{age / 3600.0:.0f} h"


def _health(health: messages.ModelHealth | None, *, is_new: bool) -> Text:
    if health is None:
        return Text("-", "dim")
    if health.condition > messages.Condition.DEGRADED:
        is_awaited = is_new and health.condition <= messages.Condition.MISSING
        return Text("no input yet", "dim") if is_awaited else Text(words(health.condition), "bold red")
    if health.limit in LIMIT:
        return Text(*LIMIT[health.limit])
    is_beyond = health.regime == messages.BEYOND_FIT
    if health.channel and (is_beyond or not health.consistent):
        where = f"{health.channel} in {health.regime}" if health.regime and not is_beyond else health.channel
        probing = "probing, " if health.friction == messages.PROBED else ""
        what = "beyond the fit" if is_beyond else health.suspect or "misfit"
        return Text(f"{probing}{what}: {where}", "yellow")
    if health.friction:
        return Text(FRICTION.get(health.friction, f"friction {health.friction}"), ON_PURPOSE)
    return Text(words(health.condition), "green" if health.condition == messages.Condition.OK else "yellow")


def _nodes(board: Board, now: int, *, wide: bool) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0), header_style="bold")
    table.add_column("node", no_wrap=True, min_width=13)
    table.add_column("state", no_wrap=True, min_width=12)
    _numbers(table, ("in [Hz]", 7), ("out [Hz]", 8))
    _numbers(table, ("latency p50 / p99 / max [us]", 28) if wide else ("p99 [us]", 8))
    _numbers(table, ("late", 6))
    if wide:
        _numbers(table, ("dropped", 7))
    table.add_column("refused")  # gives way first
    for name, row in board.nodes.items():
        table.add_row(*_node(name, row, now, wide=wide), style=PRESENCE_STYLE[row.presence])
    return table


def _node(name: str, row: NodeRow, now: int, *, wide: bool) -> list[RenderableType]:
    if row.status is None or row.presence is not Presence.RUNNING:
        there = row.presence is Presence.RUNNING
        return [name, "starting" if there else f"{row.presence.value} {spoken(row.age(now))}"]
    status = row.status
    quantiles = (status.latency_p50, status.latency_p99, status.latency_max)
    latency = " / ".join(_number(value, 0).plain for value in (quantiles if wide else quantiles[1:2]))
    state = status.state.name.lower()
    return [
        name,
        Text(f"{state} {spoken(row.age(now))}", "yellow") if row.is_overdue(now) else state,
        _number(status.rate_in, 0),
        _number(status.rate_out, 0),
        latency,
        _late(row),
        *([str(status.dropped)] if wide else []),
        _one_line(_refusals(row, now)),
    ]


def _late(row: NodeRow) -> Text:
    if row.late_share > 0.0:
        share = row.late_share
        return Text(f"{100.0 * share:.1f} %", "yellow" if share > BUSY else "")
    return Text(f"{row.late:.0f}/s" if row.late > 0.0 else "0")


def _refusals(row: NodeRow, now: int) -> Text:
    recent = row.refusals(now)
    if recent:
        return Text(", ".join(f"{name} {count}" for name, count in recent.items()), "yellow")
    before = sum(row.status.rejected.values()) if row.status is not None else 0
    said = f"none now ({before} before)" if row.is_compared else f"{before} since its start"
    return Text(said if before else "-", "dim")


def log_line(line: LogLine) -> Text:
    return _one_line(Text.assemble((f"{line.time:7.2f} s  ", "dim"), (line.text, line.style)))


def _one_line(text: Text) -> Text:
    text.no_wrap, text.overflow = True, "ellipsis"
    return text
