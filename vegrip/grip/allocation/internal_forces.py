"""Internal forces of a grasp of any shape: the least additions that balance what the fingers need.

The normal forces N of the fingers act on the object with the wrench ``A N``; column i of A is

    [ n_i ; (p_i - p) x n_i / l ]      n_i inward normal, p_i place, p their mean, l their distance from it.

Internal forces are those without a wrench, the null space of A. Each finger needs ``m_i`` by itself; wanted
are the least additions d, relative to the needs, with which the normal forces become internal:

    minimise sum_i d_i^2 / m_i    subject to  A (m + d) = 0,  d >= 0.

Nothing is ever lowered. With ``y_i = d_i / sqrt(m_i)`` this is the non-negative least squares problem
``min |y|^2 + W^2 |A (m + y sqrt(m))|^2``, solved by an active set in finitely many steps [LawsonHanson1974]_
(:func:`scipy.optimize.nnls`). It always has a solution: where the fingers that are there cannot balance,
every need is met and the balance as well as it can be. For fingers against a thumb, without moments, it is
the closed form of :mod:`vegrip.grip.kernels.share`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vegrip.config import build, parameter
from vegrip.errors import ConfigError
from vegrip.types import Floats

BALANCE = 1e4
"""W: how much a balance that is missed counts against force that is added; it is met to about 1 / W^2."""

GREATEST = 1e9  # [N] needs beyond, or none that is a number, are given back as they are
MIN_NEED_N = 1e-3  # [N] a finger that needs nothing takes part with this much, or it could never help


@dataclass(frozen=True)
class ContactPlace:
    """Where a finger touches, in any frame fixed to the hand."""

    place: tuple[float, ...] = parameter((0.0, 0.0, 0.0), unit="m", doc="x, y, z")
    normal: tuple[float, ...] = parameter((0.0, 0.0, 1.0), unit="1", doc="into the object; any length")

    def __post_init__(self) -> None:
        vectors = np.array([*self.place, *self.normal], dtype=np.float64)
        if len(self.place) != 3 or len(self.normal) != 3 or not np.all(np.isfinite(vectors)):
            raise ConfigError("a contact's place and normal must each be three finite numbers")
        if not np.any(self.normal):
            raise ConfigError("a contact's normal must not be zero")


class InternalForces:
    """Shares the normal forces of a grasp; the last answer is kept, because needs change seldom."""

    def __init__(self, contacts: Mapping[str, ContactPlace]) -> None:
        self.names = tuple(contacts)
        self.grasp = grasp_map(tuple(contacts.values()))
        self._asked: dict[str, float] = {}
        self._answer: dict[str, float] = {}
        even = self.shared(dict.fromkeys(self.names, 1.0))
        left = self.grasp @ np.array([even[name] for name in self.names])
        if not np.linalg.norm(left) < 1e-3 * sum(even.values()):
            raise ConfigError(
                f"the fingers {', '.join(self.names)} cannot press against each other at these contacts;"
                " correct 'contacts', or leave it empty and name the 'thumb' that the others press against"
            )

    def shared(self, needs: Mapping[str, float]) -> dict[str, float]:
        """Return the normal forces [N] of all fingers in ``needs``: at least these, balanced if they can be.

        A finger without a contact here keeps its need. Never raises.
        """
        if needs == self._asked:
            return self._answer
        self._asked, self._answer = dict(needs), dict(needs)
        taking_part = [i for i, name in enumerate(self.names) if name in needs]
        least = np.array([max(needs[self.names[i]], MIN_NEED_N) for i in taking_part])
        if len(taking_part) > 1 and np.all(least < GREATEST):
            for i, force in zip(
                taking_part, self._least_additions(least, self.grasp[:, taking_part]), strict=True
            ):
                self._answer[self.names[i]] = max(force, needs[self.names[i]])
        return self._answer

    def _least_additions(self, least: Floats, grasp: Floats) -> list[float]:
        from scipy.optimize import nnls  # noqa: PLC0415 (slow to import; first asked for by the constructor)

        scale = np.sqrt(least)
        size = BALANCE * grasp
        rows = np.vstack([np.eye(len(least)), size * scale])
        try:
            y, _ = nnls(rows, np.concatenate([np.zeros(len(least)), -size @ least]))
        except RuntimeError:  # too many steps: what is needed is still right, only not balanced
            return [float(force) for force in least]
        return [float(force) for force in least + scale * y]


def grasp_map(contacts: tuple[ContactPlace, ...]) -> Floats:
    """Return A, (6, n): wrench per unit of normal force, moments in units of the size of the grasp."""
    place = np.array([contact.place for contact in contacts], dtype=np.float64)
    normal = np.array([contact.normal for contact in contacts], dtype=np.float64)
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    arm = place - place.mean(axis=0)
    size = float(np.sqrt((arm**2).sum(axis=1).mean()))
    moment = np.cross(arm, normal) / (size if size > 0.0 else 1.0)
    found: Floats = np.hstack([normal, moment]).T
    return found


def contacts_of(table: Mapping[str, Any], where: str) -> dict[str, ContactPlace]:
    """Read the contacts of a configuration: name -> {place, normal}."""
    return {
        name: build(ContactPlace, dict(entry), f"{where}.contacts.{name}") for name, entry in table.items()
    }
