"""What the paper's tables and figures are computed for."""

import math

from vegrip.contact.prony import Creep, Relaxation

RELAXATION = Relaxation([0.3], [3.1])  # fig. 4: c_0 = 0.7, c_1 = 0.3, nu_1 = 3.1 1/s
CREEP = Creep([0.3], [3.1])  # eq. (41), figs. 7, 8, 10
K0 = 2.0  # the profile at the instant of loading

TABLE_1_K = (*range(1, 11), 50, math.inf)
TABLE_2_K = (2.0, 2.2, 2.4, 2.5, 2.6, 2.8, 3.0, 3.2, 3.4, 3.5, 3.6, 3.8, 4.0)

TIMES = (0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, math.inf)  # [s]
CURVE_TIMES = (0.0, 0.1, 0.2, 0.5, 1.0, math.inf)  # [s] few enough to tell the curves apart

LIMIT_SURFACE_K = (2, 3, 4)
DISTANCES = (0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)  # [contact radii] of the COR
FIG_10_TIMES = (0.0, 0.2, 1.0, math.inf)  # [s]
FIG_10_DISTANCES = (0.0, 0.25, 0.5, 1.0, 2.0)  # [contact radii]
