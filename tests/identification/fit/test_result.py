"""What a fit says of its misfit."""

from types import SimpleNamespace

import numpy as np
import pytest

from vegrip.identification.fit.result import Fit, _about_misfit


@pytest.mark.parametrize(
    ("error", "tolerance", "said"),
    [
        (0.45, 0.0, ["too large"]),
        (0.55, 0.0, []),
        (1.05, 0.0, []),
        (1.15, 0.0, ["1.15 times the noise"]),
        (9.5, 0.0, ["9.50 times the noise"]),
        (10.5, 0.0, ["10.50 times the noise", "--tolerance 0.01"]),
        (10.5, 0.01, ["10.50 times the noise"]),
    ],
)
def test_what_is_left_of_the_noise_is_told_as_far_as_it_matters(error, tolerance, said) -> None:
    noise = SimpleNamespace(tolerance=tolerance)
    depth = 1e-3 * np.sin(np.linspace(0.0, np.pi, 200))
    columns = {"displacement": depth, "normal_force": 1e4 * depth**1.5}
    recording = SimpleNamespace(
        columns=columns, episode=np.zeros(200, dtype=np.int64), fingertip=SimpleNamespace(radius=9e-3)
    )
    problem = SimpleNamespace(measured=SimpleNamespace(noise=noise, recording=recording))
    channels = {"normal_force": SimpleNamespace(rmse=1e-3)}  # [N] of 0.3
    fit = SimpleNamespace(error=error, problem=problem, channels=channels)
    told = list(_about_misfit(fit, advise=False))
    assert len(told) == len(said)
    assert all(part in text for part, text in zip(said, told, strict=True))


def test_standard_errors_are_the_roots_of_the_variances() -> None:
    problem = SimpleNamespace(unknowns=SimpleNamespace(names=("K", "p", "c1")))
    fitted = SimpleNamespace(problem=problem, covariance=np.diag([0.04, 0.0, -1e-20]))
    assert Fit.std.fget(fitted) == pytest.approx({"K": 0.2, "p": 0.0, "c1": 0.0})
