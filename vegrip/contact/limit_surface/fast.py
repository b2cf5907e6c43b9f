"""The limit surface in a fraction of a microsecond: an ellipse times a fitted correction, compiled.

Load and slip are normalised: f = |f_t|/(mu N), m = m_n/(mu N a); speed v of the contact centre in contact
radii per second, spin omega [rad/s]. With the torsion limit M(k), gauge and support function are

    gauge(k, f, m)   = sqrt(f^2 + (m/M)^2) / (1 - w P(1/k, u))     u from (f, m/M)
    support(k, v, o) = sqrt(v^2 + (M o)^2) * (1 - w Q(1/k, u))     u from (v, M o)
    u = (A^2 - B^2)/(A^2 + B^2),   w = (1 - u^2)/4                 for a pair (A, B)

P and Q are polynomials, fitted from the inside (``tools/``): the radius is never outside the true
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

NEWTON_STEPS = 60
NEWTON_NEAR = 3e-4  # so near to the solution the next step is right to 1e-8, and need not be checked

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
        +0.2355583276610, +0.0576899190208, +0.0556713924091, +0.0240805072851,
        +0.0067748367107, -0.0296321022015, +0.0309966143193, +0.2586988679619,
        -0.0634260435224, -0.9607484242757, -0.1143477418104, +1.5286633727296,
        +0.2795124312402, -1.1154687815930, -0.1356128624630, +0.3102303743159,
    ],
    [
        -0.0355531878666, +0.0025728240237, -0.0064706043639, +0.0034990744446,
        -0.0242900036119, -0.0161035006285, +0.2555562573763, +0.1462760706390,
        -0.9667290675237, -0.1502894460491, +1.9504439096781, -0.3088775483436,
        -1.9812584680509, +0.6084070465142, +0.7734803966391, -0.2786504736455,
    ],
    [
        -0.0024347291434, +0.0011550898950, -0.0043826691991, -0.0168495688015,
        -0.0211375515246, +0.3233004188315, +0.4967543098967, -2.3323533634672,
        -2.6606691867351, +7.8976071303969, +5.8964998232880, -13.5266150018498,
        -5.8197607617122, +11.3325518049894, +2.1153379145434, -3.6816848598517,
    ],
    [
        +0.0039283820474, -0.0022258023583, +0.0002351640548, -0.0022148879349,
        +0.0622273763410, +0.1172209708992, -0.6056391951281, -0.9672886030006,
        +2.5468682887382, +3.1780146689232, -5.2235449208100, -4.9787401565511,
        +5.0951685031043, +3.7042439287540, -1.8833062659977, -1.0473251926739,
    ],
    [
        -0.0050637557439, +0.0021599381597, +0.0067151537782, +0.0439881777053,
        +0.0159136383274, -0.9191989344715, -0.9222505445516, +6.7766982387069,
        +5.0883066579307, -23.5040129688166, -11.1545837932900, +41.1744806895726,
        +10.8493493107681, -35.1097978016156, -3.8924597220992, +11.5529585233014,
    ],
    [
        +0.0015422983077, +0.0010731849152, +0.0002490661391, +0.0019695520589,
        -0.0345670839447, -0.1041707225432, +0.3218400419510, +0.8447684962517,
        -1.3471653570002, -2.8667808253731, +2.7631773533167, +4.7034830082464,
        -2.6933513980080, -3.6911199065185, +0.9939807183968, +1.1095108044024,
    ],
    [
        +0.0009737801609, -0.0016368411685, -0.0046972721276, -0.0284944256013,
        +0.0095140472983, +0.6337660468669, +0.4143773890764, -4.7286960950769,
        -2.5286173328656, +16.4705306692412, +5.6726743420532, -28.8783828768544,
        -5.5472685170519, +24.6027351789761, +1.9881277976206, -8.0811024692534,
    ],
])
SUPPORT_TABLE = np.array([
    [
        +0.2328204897538, +0.0914891751369, -0.0235463132192, -0.1208842905578,
        -0.0614363463515, +0.5387333887167, -0.7536221054142, -5.7652342904219,
        +3.5793566565303, +26.1063079647924, -6.5170946215877, -59.4341891315825,
        +5.7682599182351, +73.1240266624882, -2.3559325328980, -46.5024259610693,
        +0.3158435540756, +11.9937356252437,
    ],
    [
        -0.0350133880853, -0.0053811553664, +0.0365325178967, +0.0694093802162,
        -0.1982566303924, -0.1311538916529, +3.5840304808509, +2.0798085472293,
        -21.2005935753231, -14.3944314954981, +58.4825821759630, +41.5105765977322,
        -83.8539114686750, -59.4153226456701, +60.5897752969087, +42.0501493857612,
        -17.4368469570785, -11.7633775094904,
    ],
    [
        -0.0031822697632, +0.0000095986244, -0.0210061541086, +0.1492422241456,
        +0.3501792530216, -3.3023128870464, -4.1183432769122, +26.7345623790258,
        +23.0513881894872, -106.7432079980117, -65.1000676462837, +234.2304166260500,
        +96.7969388757985, -287.5873920571816, -72.4679597455004, +185.0900234462089,
        +21.5345293300773, -48.5825259368983,
    ],
    [
        +0.0000392177824, +0.0016666024164, +0.0006500365949, -0.1965156264916,
        +0.1558348544301, +3.2441332485310, -2.9368566399389, -23.5087351011176,
        +18.8830541081934, +88.8423759764046, -57.1746964061585, -188.1257708033501,
        +88.8980492290390, +225.0104660835989, -68.7025603859425, -142.0142713196747,
        +20.9026851390984, +36.7650428750886,
    ],
    [
        -0.0035156175047, +0.0033478967693, +0.0473423994781, -0.1230601142766,
        -0.8659171382962, +2.7285509103232, +8.7848475724576, -23.2750278444575,
        -44.3528106292884, +98.4168262660213, +118.7120167609205, -228.2271569860299,
        -171.9593021884895, +294.8491790045169, +127.3090596353292, -198.7202942657814,
        -37.7256545462906, +54.3764379444605,
    ],
    [
        +0.0096379390350, -0.0043950972589, -0.0302914404078, +0.2505184986928,
        +0.1997871101285, -4.0601029047553, +0.3342305960960, +27.9958044462003,
        -9.8492316409218, -100.5569239740131, +41.5445373988330, +202.9063649333672,
        -75.9138610364668, -231.7807513637668, +64.8097985082890, +139.9671777333003,
        -21.1417007297506, -34.7303738497800,
    ],
    [
        -0.0000191524666, -0.0028503635325, -0.0256902108354, +0.0435247224967,
        +0.5389219994518, -0.8372396208296, -5.2789050856236, +7.5987641665332,
        +26.0364382895690, -34.5426161595368, -69.0825395675488, +85.4933969922865,
        +99.9973103239658, -116.8608284137182, -74.2743271133778, +82.6886695448576,
        +22.1226514749909, -23.6011452323337,
    ],
    [
        -0.0047045753654, +0.0034291850583, +0.0183562876151, -0.1152139599286,
        -0.1846035781179, +1.6750591118142, +0.3549587273960, -10.9273353785329,
        +3.5667344315819, +37.3444527717933, -19.4811963146292, -71.2085556740219,
        +38.5830581092493, +75.9963344279714, -34.3278188160823, -42.2928038642141,
        +11.4996186082318, +9.5218435640305,
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
def torsion_gradient(k: float) -> tuple[float, float]:
    """Torsion limit with its derivative: (M(k), dM/dk)."""
    if not k >= 1.0:
        return math.nan, math.nan
    value, by_t = _torsion(2.0 / k - 1.0)
    return value, -2.0 * by_t / (k * k)


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
    by_f = value * f / square + by_u * 4.0 * f * b * b / (square * square)
    by_b = value * b / square - by_u * 4.0 * f * f * b / (square * square)
    by_t = value / ratio * w * p_t - by_b * b * limit_t / limit
    return value, -2.0 * by_t / (k * k), by_f, by_b / limit


@njit
def radius_gradient(k: float, psi: float) -> tuple[float, float, float]:
    """Radius along the load angle psi with its derivatives: (radius, d/dk, d/dpsi)."""
    return radius_gradient_towards(k, math.cos(psi), math.sin(psi))


@njit
def radius_gradient_towards(k: float, c: float, s: float) -> tuple[float, float, float]:
    """Return the same towards the unit load (c, s) = (cos(psi), sin(psi))."""
    value, by_k, by_f, by_m = gauge_gradient(k, c, s)
    least = 1.0 / value
    return least, -by_k * least * least, (by_f * s - by_m * c) * least * least


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
    f = ratio * v / ellipse + by_u * 4.0 * v * b * b / (square * square)
    by_b = ratio * b / ellipse - by_u * 4.0 * v * v * b / (square * square)
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
def least_normal_force(
    force: float,
    torque: float,
    mu: float,
    radius: float,
    k: float,
    at: float = 1.0,
    radius_power: float = 0.0,
    k_power: float = 0.0,
) -> float:
    """Normal force [N] at which the load (force [N], torque [N m]) is on the limit surface.

    The contact changes with the force as a = radius (N/at)^radius_power, k = k (N/at)^k_power; with both
    powers 0 the answer is mu^-1 times the gauge. For a margin s below the surface give mu (1 - s).
    Newton's method in ln N, kept between bounds; NaN for mu, radius or at <= 0, radius_power <= -1, or a k(N)
    that falls below 1. 0 without load.
    """
    force, torque = abs(force), abs(torque)
    if not (mu > 0.0 and radius > 0.0 and at > 0.0 and radius_power > -1.0 and k >= 1.0):
        return math.nan
    if not 0.0 < force + torque < math.inf:
        return (force + torque) / mu
    if radius_power == 0.0 and k_power == 0.0:
        return gauge(k, force, torque / radius) / mu
    # forces in units of at; start from the two pure loads as if the surface were an ellipse
    f, m = force / (mu * at), torque / (mu * at * radius)
    y = math.log(math.hypot(f, (m / torsion_limit(k)) ** (1.0 / (1.0 + radius_power))))
    low, high = -math.inf, math.inf
    for _ in range(NEWTON_STEPS):
        n = math.exp(y)
        k_now, f_now, m_now = k * n**k_power, f / n, m * n ** -(1.0 + radius_power)
        value, by_k, by_f, by_m = gauge_gradient(k_now, f_now, m_now)
        over = math.log(value)
        slope = (k_power * by_k * k_now - (1.0 + radius_power) * by_m * m_now - by_f * f_now) / value
        if not abs(over) > NEWTON_NEAR:  # also leaves with a NaN
            return at * math.exp(y - over / slope)
        low, high = (y, high) if over > 0.0 else (low, y)
        y -= over / slope
        if not low < y < high:
            y = 0.5 * (low + high)
    return math.nan


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
    """Torsion limit and its derivative in t = 2/k - 1: even and odd powers side by side, by Horner's rule."""
    q = t * t
    even = odd = even_q = odd_q = 0.0
    for i in range(len(TORSION_TABLE) - 2, -1, -2):
        even_q = even_q * q + even
        odd_q = odd_q * q + odd
        even = even * q + TORSION_TABLE[i]
        odd = odd * q + TORSION_TABLE[i + 1]
    return even + t * odd, odd + 2.0 * t * (even_q + t * odd_q)


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
    """Sum of table[i, j] t^i u^j with its derivatives in t and u; even and odd powers of u side by side."""
    q = u * u
    value = by_t = by_u = 0.0
    for i in range(table.shape[0] - 1, -1, -1):
        even = odd = even_q = odd_q = 0.0
        for j in range(table.shape[1] - 2, -1, -2):
            even_q = even_q * q + even
            odd_q = odd_q * q + odd
            even = even * q + table[i, j]
            odd = odd * q + table[i, j + 1]
        by_t = by_t * t + value
        value = value * t + (even + u * odd)
        by_u = by_u * t + (odd + 2.0 * u * (even_q + u * odd_q))
    return value, by_t, by_u
