"""Steps along the columns of a root of the covariance, ``P = L L'``.

Only of what the model reads at an instant (``FELT``): the speed, where no effect asks for it, is left out.
"""

import math

from vegrip.estimator.kernels.generated import FELT, L0, P0, TRY0, Y0, Floats, M, N

WIDE = 1.7320508075688772  # sqrt(3), the kurtosis of a normal variable


def square_root(m: Floats) -> None:
    """Cholesky's L of the felt part of P; a direction without variance gives a column of zeros."""
    for i in range(M * M):
        m[L0 + i] = 0.0
    for j in range(M):
        pivot = m[P0 + j * N + j] if FELT[j] else 0.0
        for c in range(j):
            pivot -= m[L0 + j * M + c] * m[L0 + j * M + c]
        if FELT[j] and pivot > 1e-13 * m[P0 + j * N + j]:
            root = math.sqrt(pivot)
            m[L0 + j * M + j] = root
            for i in range(j + 1, M):
                if FELT[i]:
                    s = m[P0 + i * N + j]
                    for c in range(j):
                        s -= m[L0 + i * M + c] * m[L0 + j * M + c]
                    m[L0 + i * M + j] = s / root


def shifted(m: Floats, j: int, sign: float) -> None:
    """Put the state plus or minus column ``j`` of L into TRY."""
    for i in range(M):
        m[TRY0 + i] = m[Y0 + i] + sign * WIDE * m[L0 + i * M + j]
