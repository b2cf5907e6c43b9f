"""The thresholds of the verdict, all in one table: what each means, and where its value comes from.

========  ==========================================================================================
origin    where the value comes from
========  ==========================================================================================
trials    the blind trials of seeds 4 to 11, on which all of these were set together, none by itself;
          seed 12 was held out (``python -m validation.diagnosis_trials -n 200 --seed 12``, docs/diagnose.md)
measured  recordings of real contacts, where no law is exact (docs/measured.md)
speed     the time of a diagnosis: a larger value costs more of it (``vegrip bench diagnose``)
rule      a convention of statistics, or what sensors and geometry allow; not measured
========  ==========================================================================================

Thresholds of one effect stand in its file (:class:`vegrip.effects.Effect`).
"""

# What a candidate has to gain

MIN_GAIN_NATS = 8.0
"""[nats] of evidence that the first effect has to gain: it is one of thirty (origin: trials)."""
MIN_LATER_GAIN_NATS = 20.0
"""[nats] that a further effect has to gain where no regime stands out any more (origin: trials)."""
MIN_SHARE_OF_GAIN = 0.005
"""Of what was gained so far, that a further effect has to gain where no regime does (origin: trials)."""
MIN_SHARE_OF_GAIN_IN_MISFIT = 0.015
"""The same where a regime still stands out (origin: trials)."""
MIN_SHARE_OF_GAIN_TO_NOISE = 1e-3
"""The same of one that then leaves noise alone: what mends a form leaves some of it (origin: trials)."""
MIN_SHARE_OF_LEFT = 0.15
"""Of what is left, that a further effect has to gain where little is left (origin: trials)."""
LITTLE_LEFT_SHARE = 0.15
"""Of what was gained, below which what is left is little (origin: trials)."""
MIN_KIN_SHARE_OF_GAIN = 0.1
"""Of what was gained, that an effect has to gain beside one that it resembles (origin: trials)."""
SURELY_LEFT_STD = 2.0
"""Standard deviations of the noise's sum of squares, which do not count as left (origin: rule)."""

# What a candidate has to pass

MAX_NOISE_CHI2 = 1.5
"""Chi-square per regime up to which a misfit is noise (origin: trials)."""
MAX_LOST_SHARE = 0.2
"""Of the gain, that episodes which were held out may lose (origin: trials)."""
MAX_LOST_SHARE_OF_MOST = 0.5
"""The same where most of what is left is gained: another effect may rule episodes (origin: trials)."""
CHANCE_NATS = 5.0
"""[nats] that held-out episodes may lose by chance (origin: trials)."""
MOST_OF_LEFT_SHARE = 0.3
"""Of what is left, from which that is most of it (origin: trials)."""
MIN_STANDARD_ERRORS = 3.0
"""Standard errors by which an amount differs from nothing (origin: rule)."""
AT_BOUND_STD = 1e-3
"""Prior standard deviations from a bound, within which a parameter is at it (origin: rule)."""

NEAR_BOUND_STD = 0.3
"""The same, within which a parameter that was there before is near it (origin: measured)."""

# What is refitted, and followed

MAX_NAMED_EFFECTS = 4
"""Effects that are named together (origin: rule)."""
MAX_REFITS = 5
"""Candidates that the screen puts first (origin: speed)."""
MIN_SCREEN_SHARE = 0.05
"""Of the best one's gain on the screen, below which no refit is tried (origin: speed)."""
CONTENDER_SHARE = 0.4
"""Of the best one's gain, from which a candidate is fitted to the end (origin: speed)."""
SURELY_GAINED_SHARE = 0.5
"""Of what is left, that the cost falls at the least where noise alone remains: priors may cost as much
(origin: rule)."""
FAR_ERROR = 5.0
"""Error over noise, from which refits are long, and given up where they do not contend (origin: speed)."""
FORM_STD = 1.0
"""Of the share by which an accepted effect acts otherwise than its law in a channel that did not show it: it
may do nothing there, or twice as much (origin: rule)."""
PLACE_SHARE = 0.4
"""Of the gain of an accepted effect, from which on the screen another contests its place (origin: speed)."""
PLACE_COSINE = 0.7
"""Cosine of the signatures, from which it does too (origin: rule)."""
SECOND_START_SHARE = 0.2
"""Of the same gain, that it has to reach from the first start to be tried from another (origin: speed)."""
MAX_EXCHANGES = 3
"""Times that one effect takes the place of another before the next is looked for (origin: speed)."""

# What the recording must allow

MIN_CONTACT_ROWS = 50
"""Rows in contact, below which nothing can be said (origin: rule)."""
BRIEF_CONTACT_S = 1.0
"""[s] in contact, below which effects are not distinguished (origin: rule)."""
STILL_ROWS = 20
"""Rows of one displacement, from which on it may be a sensor that stands still (origin: rule)."""
MIN_STILL_RISE = 0.2
"""Of the largest force, by which it rises meanwhile; of a tip that is held it only falls (origin: rule)."""
MAX_CLOCK_SHIFT_S = 1.0
"""[s] between the clocks that is looked for (origin: rule)."""
MIN_VISIBLE_SHIFT_S = 0.015
"""[s] from which a shift of the clocks is seen by eye (origin: rule)."""
MIN_VISIBLE_SHIFT_SAMPLES = 2.5
"""Samples, of which a visible shift has to be more as well (origin: rule)."""
MAX_SENSOR_LAG_S = 0.2
"""[s] by which a sensor may be late; more is a fault of the clocks (origin: rule)."""
MIN_RATE_CORRELATION = 0.3
"""Correlation of the rates, below which a lag means nothing (origin: rule)."""
MIN_SHIFT_NATS = 20.0
"""[nats] that a shift of the clocks has to gain (origin: trials)."""
SHIFT_ADVANTAGE_SHARE = 0.1
"""Of the best effect's gain, by which a shift has to beat it (origin: trials)."""
MAX_DEPTH_RADII = 0.9
"""Of the radius, beyond which the indentation cannot be one (origin: rule)."""
RADIUS_TOLERANCE = 0.1
"""Of the stated radius of the tip, by which it may be wrong before a law of the contact is (origin: rule)."""
MAX_JUMPS = 3
"""Jumps of a zero that are taken off a recording, another size of one counted anew (origin: speed)."""

# What is one motion, and what another

BRUSH_SHARE = 0.2
"""Of the greatest depth, below which a contact is a brush and no press (origin: rule)."""
SAME_MOTION = (1.25, 1.5, 1.5)
"""Ratios of depth, speed and 1 + way, up to which two presses are the same motion (origin: measured)."""

# What the verdict is

MAX_ERROR_BY_REGIME = 1.05
"""Error over noise that named effects may leave where some of it depends on the regime (origin: trials)."""
MAX_ERROR_EVEN = 1.1
"""The same where none of it does (origin: trials)."""
MAX_EXCESS_SHARE = 0.1
"""Or this share of the excess of the squared error over the noise's (origin: trials)."""
MAX_ERROR = 1.15
"""And no more than this (origin: trials)."""
MIN_CURVE_NATS = 40.0
"""[nats] of a curve over one variable, from which a misfit that no regime shows is one (origin: trials)."""
MIN_POINTING_NATS = 20.0
"""[nats] of a curve, below which it points nowhere (origin: trials)."""
MIN_CURVE_SHARE = 0.1
"""Of the evidence that was gained, from which a curve is more than the form of a law (origin: trials)."""
PATCHWORK_EFFECTS = 3
"""Effects after which, with something still standing out, none of them is what is there (origin: trials)."""
INDISTINGUISHABLE_NATS = 5.0
"""[nats] within which candidates cannot be distinguished (origin: trials)."""
INDISTINGUISHABLE_SHARE = 1e-3
"""Of the gain, the same: no model of a measured contact is exact (origin: measured)."""
ROUGH_SHARE = 1e-2
"""The same where the forms of the laws leave more than noise anyhow (origin: measured)."""
MAX_EXACT_ERROR = 1.02
"""Error over noise, from which they do (origin: rule)."""
SAME_CHANGE_COSINE = 0.95
"""Cosine of what two candidates do, from which only the form of a law differs (origin: trials)."""
FORM_NATS = 20.0
"""[nats] from which the form of a law decides (origin: trials)."""
FORM_SHARE = 0.25
"""Of the gain, from which it decides (origin: trials)."""
