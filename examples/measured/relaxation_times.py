"""One relaxation time against two, on the deepest hold of the silicone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from cases import DEEP, Array, read, rms, run
from matplotlib import pyplot as plt
from scipy.optimize import curve_fit


def relaxation_times(picture: Path) -> str:
    """Fit one and two exponentials to the hold, draw what they leave; then let the node have two."""
    recording = read(DEEP)
    rows = (recording.t >= DEEP.window[0]) & (recording.t <= DEEP.window[1])
    t, force = recording.t[rows] - recording.t[rows][0], recording.columns["normal_force"][rows]
    figure, axis = plt.subplots(figsize=(8, 3.2), layout="constrained")
    lines = [
        "| relaxation times | a fit to the hold leaves | time constants | node: mean NIS | model alone |",
        "|---|---|---|---|---|",
    ]
    for count, parameters in ((1, "silicone"), (2, "silicone_2")):
        guess = [force[-1], *[(force[0] - force[-1]) / count] * count, *(1.0, 0.2)[-count:]]
        fitted, _ = curve_fit(prony, t, force, p0=guess, maxfev=20000)
        left = 1e3 * (force - prony(t, *fitted))
        times = ", ".join(f"{1.0 / rate:.2g} s" for rate in sorted(fitted[1 + count :], reverse=True))
        axis.plot(t, left, label=f"{count} relaxation time{'s' if count > 1 else ''}: {times}")
        result = run(replace(DEEP, parameters=parameters), recording)
        alone = 1e3 * result.error(result.alone, DEEP.window)
        lines.append(
            f"| {count} | {rms(left):.1f} mN | {times} | {result.told()['nis']:.2f} | {alone:.0f} mN |"
        )
    axis.axhspan(-0.8, 0.8, color="0.85", label="noise of the sensor, 1 std")
    axis.set(xlabel="time since the end of the ramp [s]", ylabel="measured - fitted [mN]")
    axis.set_title("Deepest silicone hold: what the relaxation function cannot follow")
    axis.legend(fontsize="small")
    axis.grid(alpha=0.3)
    figure.savefig(picture, dpi=110)
    plt.close(figure)
    return "\n".join(lines)


def prony(t: Array, *parameters: float) -> Array:
    """Return ``N_inf + sum B_i exp(-nu_i t)``; parameters in this order, all B before all nu."""
    count = len(parameters) // 2
    amplitudes, rates = parameters[1 : 1 + count], parameters[1 + count :]
    return parameters[0] + np.sum(
        [b * np.exp(-nu * t) for b, nu in zip(amplitudes, rates, strict=True)], axis=0
    )
