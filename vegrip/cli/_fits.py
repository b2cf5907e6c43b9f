"""What the commands that fit models share: reading, noise, tables."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from vegrip.cli._terminal import counted, figures, print_sentences, printer, progress

if TYPE_CHECKING:
    from vegrip.identification.diagnosis.data_checks import Doubt
    from vegrip.identification.fit import Fit
    from vegrip.identification.fit.problem import Problem
    from vegrip.identification.recording import Recording
    from vegrip.model import ContactModel


def judged(recording: "Recording", tolerance: float, has_own_zeros: bool) -> dict[str, Any]:
    """Return ``noise`` and ``zeros``, by which every command decides what an error is."""
    from vegrip.identification.fit import noise_of

    zeros = "episode" if has_own_zeros else "recording"
    return {"noise": noise_of(recording).tolerant(tolerance), "zeros": zeros}


def error_options(has_own_zeros: bool, tolerance: float) -> list[str]:
    return [
        *["--zeros-each-episode"] * has_own_zeros,
        *(["--tolerance", f"{tolerance:g}"] if tolerance else []),
    ]


def opened(
    recording: Path, model: Path | None, *, hold_back: str = "", only: str = ""
) -> "tuple[Recording, ContactModel | None]":
    """Read a recording, all of it or some of its episodes, and, if there is one, a model."""
    from vegrip.identification.recording import read_recording
    from vegrip.identification.recording.data import select_episodes
    from vegrip.model import read_model

    start = read_model(model) if model is not None else None
    with progress("read") as report:
        whole = read_recording(recording, progress=counted(report))
    return select_episodes(whole, only=only, without=hold_back), start


def doubted(problem: "Problem") -> "list[Doubt]":
    """Return what is wrong with the recording itself.

    Raises:
        RecordingError: nothing in it touches.

    """
    from vegrip.identification.diagnosis.data_checks import check_before_search, refuse_unusable

    refuse_unusable(problem.measured.recording, problem.measured)
    return list(check_before_search(problem))


def print_fit(fit: "Fit") -> None:
    """Print values with their standard errors, errors by channel, and warnings."""
    console = printer()
    told = fit.as_dict()
    text = ("parameter", "unit", "in SI", "effect")
    table = figures("parameter", "value", "std", "unit", "in SI", "effect", left=text)
    for name, one in told["parameters"].items():
        is_log = one["scale"] == "log"
        spread = f"{100.0 * one['std']:.2g} %" if is_log else f"{one['std']:.2g}"
        si = f"{one['si']['value']:.3g} {one['si']['unit']}" if "si" in one else ""
        table.add_row(name, f"{one['value']:.5g}", spread, one["unit"], si, one["effect"])
    console.print(table)
    console.print(channel_table(told["channels"]))
    console.print(f"all channels: {told['error']:.3f} times the noise")
    zeros = told["zeros"]
    console.print(
        f"zeros: displacement {zeros['displacement']:.3g} m, normal force {zeros['normal_force']:.3g} N"
    )
    print_noise(told["noise"])
    print_sentences(told["warnings"])


def print_noise(noise: dict[str, Any]) -> None:
    """Say how large the noise of every channel was taken to be, and where that comes from."""
    console = printer()
    for channel, source in noise["source"].items():
        size = f"{noise[channel]:.3g}, " if noise.get(channel) else ""
        slow = f", {noise['slow_time']:.2g} s" if channel == "slow_force" and noise["slow_force"] else ""
        console.print(f"noise of {channel}: {size}{source}{slow}")
    if noise.get("tolerance"):
        console.print(f"and {100.0 * noise['tolerance']:.3g} % of each episode's peak force, as asked for")


def channel_table(channels: dict[str, Any]) -> Any:
    """Return a table of errors by channel."""
    head = ("channel", "rmse", "noise", "ratio", "white (p)", "in 95 % band")
    table = figures(*head, left=("channel",))
    for name, one in channels.items():
        cells = (f"{one['rmse']:.3g}", f"{one['noise']:.3g}", f"{one['ratio']:.3f}")
        table.add_row(name, *cells, f"{one['whiteness_p']:.2g}", f"{100.0 * one['coverage95']:.1f} %")
    return table
