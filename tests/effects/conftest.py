"""A motion that shows every effect, and models with one effect more than the paper's."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from vegrip.effects import effect
from vegrip.effects.contract import INPUTS
from vegrip.model import BASE, ContactModel, Simulation, paper_model

RADIUS = 0.008
DEPTH = RADIUS / 10.0


@dataclass(frozen=True)
class Motion:
    """What is imposed, from outside."""

    t: np.ndarray
    displacement: np.ndarray
    temperature: np.ndarray
    tangential_force: np.ndarray
    torque: np.ndarray
    slip_speed: np.ndarray
    tangential_direction: np.ndarray

    def through(self, model: ContactModel, *, plain: bool = False) -> Simulation:
        return model.simulate(
            self.t,
            self.displacement,
            temperature=self.temperature,
            tangential_force=self.tangential_force,
            torque=self.torque,
            slip_speed=self.slip_speed,
            tangential_direction=self.tangential_direction,
            plain=plain,
        )

    def inputs(self) -> np.ndarray:
        """What the compiled model takes, shape (n, 8)."""
        f, angle, depth = self.tangential_force, self.tangential_direction, self.displacement
        of = {
            "delta": depth,
            "speed": np.diff(self.displacement, prepend=self.displacement[:1])
            / np.diff(self.t, prepend=-1.0),
            "temperature": self.temperature,
            "tangential_force": f,
            "torque": self.torque,
            "slip_speed": self.slip_speed,
            "tangential_force_x": f * np.cos(angle),
            "tangential_force_y": f * np.sin(angle),
        }
        return np.ascontiguousarray(np.stack([of[name] for name in INPUTS], axis=1))

    def first(self, n: int) -> "Motion":
        return Motion(*(getattr(self, name)[:n] for name in self.__dataclass_fields__))


def with_load(t: np.ndarray, depth: np.ndarray) -> Motion:
    """Add temperature, tangential load and slip to a motion ``depth`` [x_ref]."""
    slip = np.where((t % 3.0) > 2.5, 2e-3 * (1.0 + np.sin(1.3 * t)), 0.0)
    return Motion(
        t=t,
        displacement=DEPTH * depth,
        temperature=23.0 + 12.0 * np.sin(0.9 * t),
        tangential_force=0.2 * (1.0 + np.sin(1.7 * t)) * (depth > 0.0),
        torque=1e-4 * np.sin(2.1 * t),
        slip_speed=slip,
        tangential_direction=0.3 + 0.5 * np.sin(0.4 * t),
    )


@pytest.fixture(scope="session")
def rich() -> Motion:
    """Air, presses, holds, triangles, a small fast sine, pull-off, a slow stroke in air: 20 s, 200 Hz."""
    corners = [
        (0.0, -0.3), (0.3, -0.3), (0.4, 1.0), (2.4, 1.0), (2.6, -0.4), (3.0, -0.4), (3.1, 2.2), (5.5, 2.2),
        (6.0, -0.4), (6.5, -0.4), (7.0, 0.6), (7.5, 0.0), (8.2, 1.3), (8.9, 0.1), (9.9, 2.4), (10.9, 0.2),
        (11.1, 0.9), (11.3, 0.1), (11.4, 0.8), (14.0, 0.8), (17.0, -0.4), (20.0, -0.3),
    ]  # fmt: skip
    t = np.arange(4000) * 0.005
    at, depth = np.array(corners).T
    shaken = np.where((t > 12.0) & (t < 14.0), 0.1 * np.sin(2.0 * np.pi * 8.0 * t), 0.0)
    return with_load(t, np.interp(t, at, depth) + shaken)


@pytest.fixture(scope="session")
def smooth() -> Callable[..., Motion]:
    """The same smooth motion through air and contact, at any step."""

    def sampled(dt: float, duration: float = 3.0) -> Motion:
        t = np.arange(round(duration / dt)) * dt
        motion = with_load(t, 0.7 - 1.0 * np.cos(4.4 * t) + 0.3 * np.sin(14.0 * t))
        force = 0.2 * (1.0 + np.sin(1.7 * t))
        slip = 1e-3 * (1.0 + np.sin(1.3 * t))
        return Motion(
            t,
            motion.displacement,
            motion.temperature,
            force,
            motion.torque,
            slip,
            motion.tangential_direction,
        )

    return sampled


@cache
def _model(name: str) -> ContactModel:
    model = paper_model(RADIUS)
    return model if name in BASE else model.with_effect(effect(name))


@pytest.fixture(scope="session")
def model_with() -> Callable[[str], ContactModel]:
    """Give the model of the paper with one more effect (or as it is)."""
    return _model
