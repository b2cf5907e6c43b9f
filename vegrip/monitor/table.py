"""The live table: one row per finger, one line per node, the log below."""

import math

from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from vegrip.clock import NS
from vegrip.messages import Condition, Estimate, NodeStatus, Reason
from vegrip.monitor.board import Board, LogLine, Row, words

BAR = 24  # characters of the margin bar
REASON_STYLE = {
    Reason.SLIP: "bold red",
    Reason.RAISE: "yellow",
    Reason.FORECAST: "yellow",
    Reason.RATE_LIMIT: "yellow",
    Reason.MAX_LIMIT: "bold red",
    Reason.INPUT_HOLD: "red",
    Reason.FAIL_SAFE: "red",
    Reason.UNTRUSTED: "magenta",
    Reason.LOWER: "cyan",
}


def render(board: Board, now: int, title: str = "vegrip", footer: RenderableType | None = None) -> Panel:
    """Return the whole screen as of ``now`` [ns]."""
    parts: list[RenderableType] = [_fingers(board, now), _nodes(board)]
    if board.log:
        parts.append(Group(*(_line(line) for line in board.log)))
    if footer is not None:
        parts.append(footer)
    clock = f"{(now - board.start) / NS:.1f} s"
    return Panel(Group(*parts), title=title, subtitle=clock, padding=(0, 1))


def _fingers(board: Board, now: int) -> Table:
    table = Table(box=None, padding=(0, 1), header_style="bold", expand=False)
    for header, width in (("finger", 8), ("N [N]", 7), ("a [mm]", 11), ("k", 10), ("mu", 10)):
        table.add_column(Text(header), justify="left" if header == "finger" else "right", min_width=width)
    table.add_column("margin, its lower bound |", min_width=BAR + 6)
    table.add_column(Text("command [N]"), justify="right", min_width=11)
    table.add_column("why", min_width=10)
    table.add_column("health", min_width=12)
    for finger, row in board.rows.items():
        table.add_row(*_cells(finger, row), style="dim" if row.silent(now) else "")
    return table


def _cells(finger: str, row: Row) -> list[RenderableType]:
    contact, command = row.contact, row.command
    unknown = Estimate()
    force = contact.normal_force.value if contact is not None else math.nan
    if row.state is not None:
        force = row.state.normal_force
    return [
        finger,
        _number(force, 2),
        _estimate(contact.contact_radius if contact else unknown, 2, 1e3),
        _estimate(contact.pressure_exponent if contact else unknown, 2),
        _estimate(contact.friction_coefficient if contact else unknown, 2),
        _margin(row),
        _number(command.normal_force if command else math.nan, 2),
        Text(words(command.reason), REASON_STYLE.get(command.reason, "")) if command else "",
        _health(row),
    ]


def _number(value: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{value:.{digits}f}"


def _estimate(estimate: Estimate, digits: int, scale: float = 1.0) -> Text:
    if not math.isfinite(estimate.value):
        return Text("-")
    spread = f"±{scale * estimate.std:.{digits}f}" if math.isfinite(estimate.std) else "±?"
    return Text(f"{scale * estimate.value:.{digits}f}{spread}", "" if estimate.valid else "dim")


def _margin(row: Row) -> Text:
    margin = row.margin
    if margin is None or not math.isfinite(margin.margin.value):
        return Text("no contact" if row.contact is not None and not row.contact.in_contact else "-", "dim")
    value = min(max(margin.margin.value, 0.0), 1.0)
    bound = margin.lower_bound
    text = Text()
    full = round(BAR * value)
    text.append("█" * full, _colour(bound if math.isfinite(bound) else value))
    text.append("·" * (BAR - full), "dim")
    if math.isfinite(bound):
        at = min(max(round(BAR * bound), 0), BAR - 1)
        text = Text.assemble(text[:at], ("|", "bold reverse"), text[at + 1 :])
    text.append(f" {margin.margin.value:5.2f}", "" if margin.margin.valid else "dim")
    return text


def _colour(margin: float) -> str:
    if margin < 0.05:
        return "red"
    return "yellow" if margin < 0.15 else "green"


def _health(row: Row) -> Text:
    health = row.health
    if health is None:
        return Text("-", "dim")
    if health.condition > Condition.DEGRADED:
        return Text(words(health.condition), "bold red")
    if not health.consistent and health.channel:
        where = f"{health.channel} in {health.regime}" if health.regime else health.channel
        return Text(f"{health.suspect or 'misfit'}: {where}", "yellow")
    return Text(words(health.condition), "green" if health.condition == Condition.OK else "yellow")


def _nodes(board: Board) -> Table:
    table = Table(box=None, padding=(0, 1), header_style="bold")
    for header in ("node", "state", "in [Hz]", "out [Hz]", "latency p50 / p99 / max [us]", "late", "dropped"):
        table.add_column(Text(header), justify="left" if header in ("node", "state") else "right")
    table.add_column("refused")
    for status in board.nodes.values():
        table.add_row(*_status(status))
    return table


def _status(status: NodeStatus) -> list[str]:
    latency = " / ".join(
        _number(value, 0) for value in (status.latency_p50, status.latency_p99, status.latency_max)
    )
    return [
        status.node,
        status.state.name.lower(),
        _number(status.rate_in, 0),
        _number(status.rate_out, 0),
        latency,
        str(status.deadline_misses),
        str(status.dropped),
        ", ".join(f"{name} {count}" for name, count in status.rejected.items() if count) or "-",
    ]


def _line(line: LogLine) -> Text:
    return Text.assemble((f"{line.time:7.2f} s  ", "dim"), (line.text, line.style))
