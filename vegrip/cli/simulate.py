"""``vegrip simulate``: a recording as a model would give it."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vegrip.cli._options import JSON
from vegrip.cli._outputs import FORCE, Outputs, claim_recording
from vegrip.cli._terminal import print_json, printer
from vegrip.errors import UsageError

if TYPE_CHECKING:
    from vegrip.model import ContactModel

MODEL = Annotated[Path, typer.Argument(help="Model file.")]
OUT = Annotated[Path, typer.Option("-o", "--output", help="Folder of the recording to write.")]
PROTOCOL = Annotated[
    Path | None, typer.Option("--protocol", help="Protocol file (TOML); else presses, creep, sines, slips.")
]
LIKE = Annotated[
    Path | None, typer.Option("--like", metavar="RECORDING", help="Take motion and sensors of a recording.")
]
WITH = Annotated[
    list[str] | None, typer.Option("--with", metavar="EFFECT", help="Put an effect in, at its declared size.")
]
NOISE = Annotated[
    list[str] | None,
    typer.Option(
        "--noise", metavar="CHANNEL=STD", help="Noise of a sensor, SI; 0 is exact, 'none' takes it away."
    ),
]
RATE = Annotated[float, typer.Option("--rate", min=1.0, max=1e5, help="Samples per second [Hz].")]
SEED = Annotated[int, typer.Option("--seed", min=0, help="Of the noise.")]
WARM = Annotated[float | None, typer.Option("--temperature", help="[degC]; else the model's reference.")]
PLOT = Annotated[Path | None, typer.Option("--plot", metavar="PNG", help="Draw the protocol and the forces.")]


def simulate(
    model: MODEL,
    output: OUT,
    force: FORCE = False,
    protocol: PROTOCOL = None,
    like: LIKE = None,
    with_effects: WITH = None,
    noise: NOISE = None,
    rate: RATE = 200.0,
    seed: SEED = 0,
    temperature: WARM = None,
    plot: PLOT = None,
    as_json: JSON = False,
) -> None:
    """Run a model through a protocol and write what sensors would have measured, as a recording.

    Which sensors there are, and their noise: normal_force, displacement, tangential_force, torque_z and
    slip_speed as usual; add contact_radius or temperature with --noise contact_radius=5e-5.

    Example: vegrip sample press.toml && vegrip simulate press.toml --noise contact_radius=5e-5 -o pressed
    """
    from vegrip.cli._recordings import print_recording
    from vegrip.display.recording import describe
    from vegrip.identification.recording import read_recording, write_recording
    from vegrip.identification.recording.session import replaced
    from vegrip.identification.simulate import like as simulate_like
    from vegrip.identification.simulate import read_protocol
    from vegrip.identification.simulate import simulate as simulate_model
    from vegrip.identification.simulate.protocol import standard
    from vegrip.identification.simulate.run import draw_simulation

    if like is not None and (protocol is not None or noise or plot is not None):
        raise UsageError(
            "--like takes motion and sensors from a recording; leave --protocol, --noise and --plot out"
        )
    truth, sensors = _model(model, with_effects or []), _sensors(noise or [])
    with Outputs(force=force) as outputs:
        claim_recording(output, force=force)
        outputs.picture(plot)
        if like is not None:
            made = simulate_like(truth, read_recording(like), seed=seed)
        else:
            what = read_protocol(protocol) if protocol is not None else standard(truth)
            made = simulate_model(truth, what, sensors=sensors, rate=rate, seed=seed, temperature=temperature)
            outputs.write(plot, partial(draw_simulation, what, {model.stem: truth}))
        with replaced(output):
            write_recording(replace(made, name=output.resolve().name), output)
        made = read_recording(output)
        if as_json:
            print_json({"recording": str(output), **describe(made)})
            return
        print_recording(made, output)
        printer(stderr=True).print(f"simulated, seed {seed}")


def _model(path: Path, extra: list[str]) -> "ContactModel":
    from vegrip.effects import effect
    from vegrip.model import read_model

    model = read_model(path)
    for name in extra:
        if name in {one.name for one in model.effects}:
            raise UsageError(f"{path}: has {name} already; change its value in the file")
        model = model.with_effect(effect(name))
    return model


def _sensors(noise: list[str]) -> dict[str, float]:
    from vegrip.identification.simulate import DEFAULT_NOISE

    sensors = dict(DEFAULT_NOISE)
    for text in noise:
        name, _, value = text.partition("=")
        if value == "none":
            sensors.pop(name, None)
            continue
        try:
            sensors[name] = float(value)
        except ValueError:
            raise UsageError(
                f"--noise {text}: write it like normal_force=0.01 (SI), or displacement=none"
            ) from None
        if not 0.0 <= sensors[name] < 1e3:
            raise UsageError(f"--noise {text}: a standard deviation is zero or more")
    return sensors
