"""The simulated fingertip against recordings made by somebody else's brute-force simulator."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import least_squares

from vegrip.identification.recording import read_recording
from vegrip.virtual.fingertip import Fingertips
from vegrip.virtual.settings import FingertipSettings


@pytest.mark.slow
def test_fitted_fingertip_leaves_nothing_but_sensor_noise(measured) -> None:
    """Holds at three depths; the noise of the displacement is felt through the stiffness."""
    recording = read_recording(measured("hidden-effects") / "nothing")
    noise = recording.sensors
    holds = [recording.select(recording.episode == e) for e in (0, 1, 2)]

    def tip(x: np.ndarray) -> FingertipSettings:
        return replace(
            FingertipSettings(radius=recording.fingertip.radius),
            reference_force=float(np.exp(x[0])),
            exponent=float(x[1]),
            amplitudes=(float(x[2]),),
            rates=(float(np.exp(x[3])),),
        )

    def residuals(x: np.ndarray) -> np.ndarray:
        soft, parts = Fingertips([tip(x)], 5e-3), []
        for hold in holds:
            soft.reset()
            depth = hold.columns["displacement"] - 1e-6 * x[4]
            force = np.array([soft.press(np.array([d]))[0] for d in depth])
            slope = (soft.elastic_force(depth + 1e-6) - soft.elastic_force(depth - 1e-6)) / 2e-6
            std = np.hypot(noise["normal_force"], slope * noise["displacement"])
            parts.append((force - hold.columns["normal_force"] - 1e-3 * x[5]) / std)
        return np.concatenate(parts)

    fit = least_squares(residuals, [0.0, 1.5, 0.3, 1.0, 0.0, 0.0], diff_step=1e-3, max_nfev=12)
    assert np.sqrt(np.mean(fit.fun**2)) == pytest.approx(1.0, abs=0.05)
    deepest = fit.fun[-len(holds[-1]) :][200:1100]  # held: slow misfit would show here
    assert np.abs(deepest.reshape(-1, 100).mean(axis=1)).max() < 4.0 / np.sqrt(100)
