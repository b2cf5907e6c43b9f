"""Every number of what a grasp learns of friction and slip: its unit, its meaning, and where it is from.

Where nothing else is said, a number was set by hand on the cases of ``tests/law`` (seeds 1 to 4, friction
0.25 and 0.6) and the lifts of one pair of pads (docs/measured.md). What is stated by a parameter of the grip
is not here. One that is used for several things is named for the first.
"""

RARE = 0.02  # probability of what is rare: friction changed, a channel is faulty, a sound one misses a slide
EVEN = 0.5  # probability of what is as likely as not: an unknown channel is dead, a slide is believed or not
SURE = 0.95  # probability from which on a hypothesis is acted on

# friction
SCATTER = 0.1  # std of ln mu from one slide to the next: [SavescuLatashZatsiorsky2008]_, 0.96 +- 0.09
CHANGE_STD = 0.4  # std of ln mu added where friction has changed: a wet pad has 0.4 to 0.9 of the dry one's
COMMON = 0.8  # share of the slow drift of ln mu that is common to all fingers: they hold one object
CREDIBLE = 2.0  # standard deviations from the mean of friction, up to which a load that held is believed
OUTLIER = 5.0  # standard deviations (or ln) beyond which nothing is noise, nor counts for more
HELD_TIME = 10.0  # [s] in which ln u that was held falls by one

# slip channels
LOOK = 0.01  # [s] that what a channel says stays the same, and in which forces are averaged: a sample or two
FALSE = 1e-4  # probability that a sound channel says slip in a look in which nothing slides; least of any p
RENEWED = 100.0  # [s] in which a channel goes back to what is usual; looks over which its rate is averaged

# the load as a witness
FOLLOWS = 0.3  # d ln T / d ln N between that of an object that holds, 0, and of one that slides, 1
RISE = 0.02  # of ln T or ln u, below which nothing is seen
BLIND = 0.15  # of ln T or ln N, by which an object has slid too far before it is seen
GOES_AWAY = 2.0  # d ln T / d ln N beyond which the load goes away by itself
GRAVITY = 9.81  # [m/s^2] of an object whose whole weight is missing
HIDDEN = 1.1e-4  # [m] of a slide that the load has not shown yet, while force is lowered
QUICK = 5.0  # [1/s] of ln N, with which it shows within 0.7 mm; what rises faster may be a wrong value
RETURN = 0.15  # [s] in which a grip is back and a load steady, and after which a report is of another slide

# letting go of force
ANSWERED = 0.045  # [s] from a slide to its end by the drives and channels for which a cost is stated
COST = 2.0  # [s] of the least force, that a slide which is noticed costs
WORTH = 0.08  # of the force, that is held in any case: knowing friction does not save it, since it changes
LEAD = 0.35  # [s] with which the grip follows: what is asked leads what is by no more of the rate
QUIET_CHANGE = 0.05  # relative change of a load from which on it changes
PAUSE = 0.5  # [s] of rest after a slide; loads and what the witness has seen are followed within it

UNSURE = 1.0 - SURE  # probability below which a hypothesis is dropped
USUAL = 1.0 - EVEN - RARE  # probability that a channel of which nothing is known is sound
DETECTS = 1.0 - RARE  # probability that a sound channel reports a slide
NAMED_AT = RARE  # probability of a sound channel below which it is named
NEARLY_NONE = 1e-6  # below it a probability, a variance or a precision is rounding
