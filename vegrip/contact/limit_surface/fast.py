"""The limit surface in a fraction of a microsecond: an ellipse times a fitted correction, compiled.

Load and slip are normalised: f = |f_t|/(mu N), m = m_n/(mu N a); speed v of the contact centre in contact
radii per second, spin omega [rad/s]. With the torsion limit M(k), gauge and support function are

    gauge(k, f, m)   = sqrt(f^2 + (m/M)^2) / (1 - w P(1/k, u))     u from (f, m/M)
    support(k, v, o) = sqrt(v^2 + (M o)^2) * (1 - w Q(1/k, u))     u from (v, M o)
    u = (A^2 - B^2)/(A^2 + B^2),   w = (1 - u^2)/4                 for a pair (A, B)

P and Q are polynomials (``make_table.py``) fitted from the inside: the radius is never outside the true
surface and at most 2.4e-5 inside, relative, for every k in [1, inf] and every angle; it is exact at pure
force and pure torsion. The slip direction is good to 6e-4 rad.

Compiled functions do not raise: a k below 1 or a NaN gives NaN. They use nothing but ``math`` and the tables
in this file, so that its text can be taken whole into generated code (numba's cache does not see a change in
a function called from another file).
"""

import math

import numpy as np
from numpy.typing import NDArray

from vegrip.compiled import njit

Array = NDArray[np.float64]

# begin table
# fmt: off
TORSION_TABLE = np.array([
    +0.5890486225500, -0.0935898614004, +0.0021156860871, +0.0046382262720,
    -0.0038814681282, +0.0028850212217, -0.0020836207726, +0.0014739120070,
    -0.0010201410491, +0.0006994076364, -0.0005005974030, +0.0003339922401,
    -0.0001233347322, +0.0000843733768, -0.0002885342127, +0.0001819205800,
    +0.0002522572164, -0.0001560696407, -0.0002870013327, +0.0001787735091,
    +0.0001430828343, -0.0000889680232, -0.0000416177209, +0.0000259388859,
])
RADIUS_TABLE = np.array([
    [
        +0.2355583263439, +0.0576900471515, +0.0556748967406, +0.0241063875463,
        +0.0068084121142, -0.0299145166501, +0.0301215244360, +0.2593330350039,
        -0.0587699070220, -0.9594492588497, -0.1247732000975, +1.5219230266972,
        +0.2901055604741, -1.1066952862682, -0.1396308469001, +0.3064806632621,
    ],
    [
        -0.0355531934925, +0.0025705525615, -0.0065140132765, +0.0033062949103,
        -0.0237575474693, -0.0123470952057, +0.2532112685433, +0.1210082854758,
        -0.9620699902831, -0.0690926896912, +1.9454952748164, -0.4426553416436,
        -1.9781337648984, +0.7172195054500, +0.7724779107607, -0.3132520847934,
    ],
    [
        -0.0024343104665, +0.0011597321534, -0.0044297232706, -0.0174566411791,
        -0.0215996797095, +0.3316740741776, +0.5085971799883, -2.3779592082841,
        -2.7240215329128, +8.0230733957760, +6.0365435992924, -13.7083691167643,
        -5.9583573342671, +11.4630098389958, +2.1661601128050, -3.7178346793529,
    ],
    [
        +0.0039285152216, -0.0022182627239, +0.0003414596315, -0.0018425916171,
        +0.0607610118996, +0.1093895637199, -0.5977469961023, -0.9134919430739,
        +2.5257447670425, +3.0035524318980, -5.1923435045983, -4.6895613860560,
        +5.0706966835956, +3.4676256389160, -1.8754015226445, -0.9715652073690,
    ],
    [
        -0.0050648581748, +0.0021463884262, +0.0068103771257, +0.0454112901327,
        +0.0170586848299, -0.9391490261475, -0.9491687444931, +6.8899828732026,
        +5.2310893085996, -23.8312668832999, -11.4689995340997, +41.6734350032840,
        +11.1592092753534, -35.4880944528747, -4.0055160686435, +11.6645396515431,
    ],
    [
        +0.0015421430735, +0.0010674652523, +0.0001863631330, +0.0018134348354,
        -0.0336051652536, -0.1004351513520, +0.3158795239325, +0.8184110509930,
        -1.3286705016343, -2.7805974722139, +2.7326159461079, +4.5600872584962,
        -2.6679086986758, -3.5732924674966, +0.9856435067355, +1.0715519512245,
    ],
    [
        +0.0009744929187, -0.0016276103332, -0.0047491294050, -0.0293597456547,
        +0.0087695436518, +0.6459643415269, +0.4307411462470, -4.7991806242681,
        -2.6147345116467, +16.6781019812924, +5.8617815868570, -29.2008497666841,
        -5.7332223690684, +24.8517809474086, +2.0558157546786, -8.1559846264237,
    ],
])
SUPPORT_TABLE = np.array([
    [
        +0.2328204897538, +0.0914891751369, -0.0235463132191, -0.1208842905593,
        -0.0614363463543, +0.5387333887433, -0.7536221053840, -5.7652342906138,
        +3.5793566563562, +26.1063079654866, -6.5170946210218, -59.4341891329019,
        +5.7682599172066, +73.1240266637532, -2.3559325319349, -46.5024259615661,
        +0.3158435537175, +11.9937356252637,
    ],
    [
        -0.0350133880853, -0.0053811553664, +0.0365325178965, +0.0694093802119,
        -0.1982566303892, -0.1311538915527, +3.5840304807869, +2.0798085463337,
        -21.2005935747964, -14.3944314915038, +58.4825821739740, +41.5105765879508,
        -83.8539114649633, -59.4153226323203, +60.5897752935783, +42.0501493762576,
        -17.4368469559327, -11.7633775067457,
    ],
    [
        -0.0031822697632, +0.0000095986240, -0.0210061541104, +0.1492422241668,
        +0.3501792530604, -3.3023128873400, -4.1183432773537, +26.7345623808136,
        +23.0513881921551, -106.7432080034382, -65.1000676550019, +234.2304166341040,
        +96.7969388911864, -287.5873920615762, -72.4679597592421, +185.0900234448044,
        +21.5345293349223, -48.5825259352056,
    ],
    [
        +0.0000392177824, +0.0016666024161, +0.0006500365942, -0.1965156264501,
        +0.1558348544568, +3.2441332476863, -2.9368566400962, -23.5087350940698,
        +18.8830541080449, +88.8423759465635, -57.1746964030249, -188.1257707336478,
        +88.8980492206337, +225.0104659927024, -68.7025603770953, -142.0142712577770,
        +20.9026851357955, +36.7650428579728,
    ],
    [
        -0.0035156175047, +0.0033478967703, +0.0473423994807, -0.1230601143296,
        -0.8659171383408, +2.7285509108574, +8.7848475732271, -23.2750278462012,
        -44.3528106357535, +98.4168262646950, +118.7120167863448, -228.2271569649149,
        -171.9593022381236, +294.8491789543505, +127.3090596820546, -198.7202942161241,
        -37.7256545631788, +54.3764379263312,
    ],
    [
        +0.0096379390351, -0.0043950972581, -0.0302914404085, +0.2505184986068,
        +0.1997871101149, -4.0601029032581, +0.3342305964104, +27.9958044351331,
        -9.8492316431108, -100.5569239319909, +41.5445374061133, +202.9063648453926,
        -75.9138610492496, -231.7807512617375, +64.8097985197217, +139.9671776723386,
        -21.1417007338337, -34.7303738352796,
    ],
    [
        -0.0000191524666, -0.0028503635332, -0.0256902108363, +0.0435247225269,
        +0.5389219994585, -0.8372396209989, -5.2789050860221, +7.5987641656435,
        +26.0364382941496, -34.5426161482713, -69.0825395875977, +85.4933969504998,
        +99.9973103649343, -116.8608283400131, -74.2743271527534, +82.6886694817119,
        +22.1226514893456, -23.6011452112538,
    ],
    [
        -0.0047045753655, +0.0034291850578, +0.0183562876168, -0.1152139598833,
        -0.1846035781380, +1.6750591111624, +0.3549587272739, -10.9273353746680,
        +3.5667344339643, +37.3444527608542, -19.4811963257587, -71.2085556599444,
        +38.5830581323412, +75.9963344239276, -34.3278188384152, -42.2928038710478,
        +11.4996186164148, +9.5218435685663,
    ],
])
# fmt: on
# end table


@njit
def torsion_limit(k: float) -> float:
    """Greatest pure torque m = M(k), as :func:`vegrip.contact.limit_surface.reference.torsion_limit`."""
    if not k >= 1.0:
        return math.nan
    return _torsion(2.0 / k - 1.0)[0]


@njit
def gauge(k: float, f: float, m: float) -> float:
    """Load over limit: 1 on the limit surface, below 1 inside, proportional to the load; any signs."""
    if not k >= 1.0:
        return math.nan
    t = 2.0 / k - 1.0
    b = m / _torsion(t)[0]
    square = f * f + b * b
    if not 0.0 < square < math.inf:
        return square
    u = (f * f - b * b) / square
    return math.sqrt(square) / (1.0 - 0.25 * (1.0 - u * u) * _value(RADIUS_TABLE, t, u))


@njit
def radius(k: float, psi: float) -> float:
    """Distance from the origin to the surface along f = r cos(psi), m = r sin(psi)."""
    return 1.0 / gauge(k, math.cos(psi), math.sin(psi))


@njit
def gauge_gradient(k: float, f: float, m: float) -> tuple[float, float, float, float]:
    """Gauge with its derivatives: (gauge, d/dk, d/df, d/dm); (0, 0, 0, 0) without load.

    (d/df, d/dm) is the outward normal, along the slip (v, omega) that starts when the gauge reaches 1.
    """
    if not k >= 1.0:
        return math.nan, math.nan, math.nan, math.nan
    t = 2.0 / k - 1.0
    limit, limit_t = _torsion(t)
    b = m / limit
    square = f * f + b * b
    if not 0.0 < square < math.inf:
        return square, 0.0 * square, 0.0 * square, 0.0 * square
    ellipse = math.sqrt(square)
    u = (f * f - b * b) / square
    w = 0.25 * (1.0 - u * u)
    p, p_t, p_u = _derivatives(RADIUS_TABLE, t, u)
    ratio = 1.0 - w * p
    value = ellipse / ratio
    by_u = -value / ratio * (0.5 * u * p - w * p_u)
    by_f = value * f / square + by_u * 4.0 * f * b * b / square**2
    by_b = value * b / square - by_u * 4.0 * f * f * b / square**2
    by_t = value / ratio * w * p_t - by_b * b * limit_t / limit
    return value, -2.0 * by_t / (k * k), by_f, by_b / limit


@njit
def radius_gradient(k: float, psi: float) -> tuple[float, float, float]:
    """Radius along the load angle psi with its derivatives: (radius, d/dk, d/dpsi)."""
    c, s = math.cos(psi), math.sin(psi)
    value, by_k, by_f, by_m = gauge_gradient(k, c, s)
    return 1.0 / value, -by_k / value**2, (by_f * s - by_m * c) / value**2


@njit
def support(k: float, v: float, omega: float) -> float:
    """Greatest friction power/(mu N a) over the surface for the slip (v, omega): max of f v + m omega."""
    return support_gradient(k, v, omega)[0]


@njit
def support_gradient(k: float, v: float, omega: float) -> tuple[float, float, float]:
    """Support function and the load that resists the slip: (support, f, m), with f, m on the surface."""
    if not k >= 1.0:
        return math.nan, math.nan, math.nan
    t = 2.0 / k - 1.0
    limit = _torsion(t)[0]
    b = omega * limit
    square = v * v + b * b
    if not 0.0 < square < math.inf:
        return square, 0.0 * square, 0.0 * square
    u = (v * v - b * b) / square
    w = 0.25 * (1.0 - u * u)
    q, _, q_u = _derivatives(SUPPORT_TABLE, t, u)
    ellipse = math.sqrt(square)
    ratio = 1.0 - w * q
    by_u = ellipse * (0.5 * u * q - w * q_u)
    f = ratio * v / ellipse + by_u * 4.0 * v * b * b / square**2
    by_b = ratio * b / ellipse - by_u * 4.0 * v * v * b / square**2
    return ellipse * ratio, f, by_b * limit


@njit
def point(k: float, d: float) -> tuple[float, float]:
    """Point (f, m) of the surface for a centre of rotation at distance d [contact radii], d in [0, inf]."""
    scale = 1.0 / math.hypot(1.0, d)  # 0 at d = inf
    _, f, m = support_gradient(k, 1.0 if scale == 0.0 else d * scale, scale)
    return f, m


@njit
def cor_distance(k: float, f: float, m: float) -> float:
    """Distance [contact radii] of the centre of rotation of the slip that the load starts; inf for m = 0."""
    _, _, by_f, by_m = gauge_gradient(k, f, m)
    return math.inf if by_m == 0.0 else abs(by_f / by_m)


@njit
def gauges(k: Array, f: Array, m: Array) -> Array:
    """Gauge of many loads; k, f, m of one shape (n,)."""
    out = np.empty(len(f))
    for i in range(len(f)):
        out[i] = gauge(k[i], f[i], m[i])
    return out


@njit
def radii(k: Array, psi: Array) -> Array:
    """Radius along many load angles; k, psi of one shape (n,)."""
    out = np.empty(len(psi))
    for i in range(len(psi)):
        out[i] = radius(k[i], psi[i])
    return out


@njit
def _torsion(t: float) -> tuple[float, float]:
    """Torsion limit and its derivative in t = 2/k - 1, by Horner's rule."""
    value = slope = 0.0
    for i in range(len(TORSION_TABLE) - 1, -1, -1):
        slope = slope * t + value
        value = value * t + TORSION_TABLE[i]
    return value, slope


@njit
def _value(table: Array, t: float, u: float) -> float:
    """Sum of table[i, j] t^i u^j."""
    value = 0.0
    for i in range(table.shape[0] - 1, -1, -1):
        row = 0.0
        for j in range(table.shape[1] - 1, -1, -1):
            row = row * u + table[i, j]
        value = value * t + row
    return value


@njit
def _derivatives(table: Array, t: float, u: float) -> tuple[float, float, float]:
    """Sum of table[i, j] t^i u^j with its derivatives in t and u."""
    value = by_t = by_u = 0.0
    for i in range(table.shape[0] - 1, -1, -1):
        row = row_u = 0.0
        for j in range(table.shape[1] - 1, -1, -1):
            row_u = row_u * u + row
            row = row * u + table[i, j]
        by_t = by_t * t + value
        value = value * t + row
        by_u = by_u * t + row_u
    return value, by_t, by_u
