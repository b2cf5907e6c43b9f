"""Steps along the columns of a root of the covariance, ``P = L L'``."""

import math

from vegrip.estimator.kernels.generated import L0, P0, TRY0, Y0, Floats, M, N

WIDE = 1.7320508075688772  # sqrt(3), the kurtosis of a normal variable


def square_root(m: Floats) -> None:
    """Cholesky's L of the moving part of P; a direction without variance gives a column of zeros."""
    for j in range(M):
        for i in range(M):
            m[L0 + i * M + j] = 0.0
        pivot = m[P0 + j * N + j]
        for c in range(j):
            pivot -= m[L0 + j * M + c] * m[L0 + j * M + c]
        if pivot > 1e-13 * m[P0 + j * N + j]:
            root = math.sqrt(pivot)
            m[L0 + j * M + j] = root
            for i in range(j + 1, M):
                s = m[P0 + i * N + j]
                for c in range(j):
                    s -= m[L0 + i * M + c] * m[L0 + j * M + c]
                m[L0 + i * M + j] = s / root


def shifted(m: Floats, j: int, sign: float) -> None:
    """Put the state plus or minus column ``j`` of L into TRY."""
    for i in range(M):
        m[TRY0 + i] = m[Y0 + i] + sign * WIDE * m[L0 + i * M + j]
