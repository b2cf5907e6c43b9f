"""Steps along the columns of a root of the covariance, ``P = L L'``.

Only of what the model reads (``FELT``): the speed, where no effect asks for it, is left out.
"""

import math

from vegrip.estimator.kernels.generated import *

WIDE = 1.7320508075688772  # sqrt(3), the kurtosis of a normal variable


def square_root(m: Floats, p: int) -> None:
    """Cholesky's L of the felt part of the covariance at ``p``; no variance gives a column of zeros."""
    for i in range(N * N):
        m.l[i] = 0.0
    for j in range(N):
        pivot = m[p + j * N + j] if FELT[j] else 0.0
        for c in range(j):
            pivot -= m.l[j * N + c] * m.l[j * N + c]
        if FELT[j] and pivot > 1e-13 * m[p + j * N + j]:
            root = math.sqrt(pivot)
            m.l[j * N + j] = root
            for i in range(j + 1, N):
                if FELT[i]:
                    s = m[p + i * N + j]
                    for c in range(j):
                        s -= m.l[i * N + c] * m.l[j * N + c]
                    m.l[i * N + j] = s / root


def shift_along_root(m: Floats, y: int, j: int, sign: float) -> None:
    """Put the state ``y`` plus or minus column ``j`` of L into TRY."""
    for i in range(N):
        m.tried[i] = m[y + i] + sign * WIDE * m.l[i * N + j]


def bend_variance(difference: float) -> float:
    """Variance that a bend adds, from the difference of the changes on both sides of a root.

    ``(rise - fall)^2 (h^2 - 1) / (4 h^4)`` for steps of h standard deviations.
    """
    square = WIDE * WIDE
    return difference * difference * (square - 1.0) / (4.0 * (square * square))
