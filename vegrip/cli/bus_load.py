"""``vegrip bus-load``: whether hands, rates and layout fit a CAN bus."""

import dataclasses
import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from vegrip.cli._options import JSON
from vegrip.cli._terminal import answer, printer, show, table
from vegrip.config import build
from vegrip.errors import UsageError

if TYPE_CHECKING:
    from vegrip.transport.canbus.traffic import Forecast, TrafficPlan


def bus_load(
    fingers: Annotated[int, typer.Option(help="Fingers of each hand.")] = 5,
    hands: Annotated[int, typer.Option(help="Hands on this bus, each with a grasp force node.")] = 1,
    rate: Annotated[float, typer.Option(help="States, and commands, per second and finger [Hz].")] = 500.0,
    layout: Annotated[str, typer.Option(help="fd or classic.")] = "fd",
    bitrate: Annotated[int, typer.Option(help="Nominal bit rate [bit/s].")] = 1_000_000,
    data_bitrate: Annotated[int, typer.Option(help="Bit rate of FD data [bit/s].")] = 5_000_000,
    report_rate: Annotated[float, typer.Option(help="Margins and estimates [Hz]; 0: none.")] = 50.0,
    health_rate: Annotated[float, typer.Option(help="ModelHealth [Hz]; 0: none.")] = 5.0,
    status_rate: Annotated[float, typer.Option(help="NodeStatus [Hz]; 0: none.")] = 1.0,
    state_parts: Annotated[int, typer.Option(help="Classic: frames of a state, 1 (forces) to 3.")] = 2,
    jitter: Annotated[float, typer.Option(help="How late the computers may send [s].")] = 0.0,
    queue: Annotated[
        str, typer.Option(help="Transmit queues: fifo (SocketCAN, virtual bus) or priority (mailboxes).")
    ] = "fifo",
    as_json: JSON = False,
) -> None:
    """Report how busy a CAN bus will be, how late each frame can arrive, and whether it fits.

    Example: vegrip bus-load --fingers 5 --rate 500 --layout fd --queue priority
    """
    from vegrip.transport.canbus.traffic import TrafficPlan, forecast_traffic

    if layout not in ("fd", "classic") or queue not in ("fifo", "priority"):
        raise UsageError("--layout is fd or classic, --queue is fifo or priority")
    table = {
        "fingers": fingers, "hands": hands, "rate": rate, "fd": layout == "fd", "bitrate": bitrate,
        "data_bitrate": data_bitrate, "report_rate": report_rate, "health_rate": health_rate,
        "status_rate": status_rate, "state_parts": state_parts, "jitter": jitter,
    }  # fmt: skip
    plan = build(TrafficPlan, table, "bus-load")
    forecast = forecast_traffic(plan, fifo=queue == "fifo")
    answer(_as_dict(plan, forecast, queue), lambda: _show(forecast, queue), as_json=as_json)


def _as_dict(plan: "TrafficPlan", forecast: "Forecast", queue: str) -> dict[str, Any]:
    frames = [
        {
            **{key: getattr(row, key) for key in ("name", "owner", "identifier", "sender", "rate")},
            "bytes": row.length,
            "longest_us": row.longest * 1e6,
            "wait_us": row.wait * 1e6,
            "response_us": row.response * 1e6,
            "fits": row.fits,
        }
        for row in forecast.rows
    ]
    said = {"load": forecast.load, "worst_load": forecast.worst_load, "fits": forecast.fits, "queue": queue}
    return {**said, "plan": dataclasses.asdict(plan), "frames": frames}


def _show(forecast: "Forecast", queue: str) -> None:
    out = table("frame", "of", "id", "bytes", "Hz", "longest/us", "wait/us", "response/us", "")
    for row in forecast.rows:
        out.add_row(
            row.name, row.owner, f"0x{row.identifier:03X}", str(row.length), f"{row.rate:g}",
            f"{row.longest * 1e6:.0f}", _microseconds(row.wait), _microseconds(row.response),
            "" if row.fits else "too late",
        )  # fmt: skip
    show(out)
    console = printer()
    console.print(
        f"load {forecast.load:.1%} with usual data, {forecast.worst_load:.1%} with the longest frames"
    )
    console.print(_verdict(forecast, queue))


def _microseconds(time: float) -> str:
    return f"{time * 1e6:.0f}" if math.isfinite(time) else "never"


def _verdict(forecast: "Forecast", queue: str) -> str:
    if forecast.fits:
        return "it fits: every frame arrives before the next one of its kind is sent"
    if forecast.worst_load >= 1.0:
        return "it does not fit: lower the rates, use FD, a higher bit rate, or another bus"
    late = sum(not row.fits for row in forecast.rows)
    remedy = "; or let the controllers order their queues by identifier" if queue == "fifo" else ""
    return (
        f"it does not always fit: {late} frames can be overtaken by the next of their kind; "
        f"lower --report-rate or --rate{remedy}"
    )
