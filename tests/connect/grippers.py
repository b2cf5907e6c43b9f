"""A gripper on a stiff object whose gain, delay, steps and play are known, in simulated time.

A play operator of half its width either way, as of a gear or a tendon; a pure delay; a first-order loop.
"""

import math
from collections import deque

import numpy as np

from vegrip.clock import NS
from vegrip.messages import FingertipState, ForceCommand
from vegrip.transport.endpoint import NONE_BROKEN, Endpoint


class Gripper:
    """What the jaws press with; ``step`` is to be called at increasing times."""

    loosens = True  # where a smaller force is asked for

    def __init__(self, *, gain=1.0, offset=0.0, delay=0.05, play=0.0, step=0.0, lag=0.0, noise=0.02, seed=0):
        self.gain, self.offset, self.delay, self.play = gain, offset, delay, play
        self.steps, self.lag, self.noise = step, lag, noise
        self.random = np.random.default_rng(seed)
        self.coming, self.set, self.middle, self.force, self.then = deque(), 0.0, 0.0, 0.0, 0.0
        self.largest = 0.0  # [N] that it pressed with

    def tell(self, setting, now):
        self.coming.append((now + self.delay, setting))

    def feel(self, now):
        """Return the force that each pad reads [N]."""
        while self.coming and self.coming[0][0] <= now:
            self.set = self.coming.popleft()[1]
        wanted = 0.0
        if self.set > 0.0:
            steps = math.floor(self.set / self.steps + 1e-9) * self.steps if self.steps else self.set
            wanted = self.gain * steps + self.offset
        if self.loosens or wanted > self.middle or self.set == 0.0:
            self.middle = min(max(self.middle, wanted - self.play / 2), wanted + self.play / 2)
        wanted = self.middle if self.set > 0.0 else 0.0
        share = 1.0 if self.lag == 0.0 else 1.0 - math.exp(-(now - self.then) / self.lag)
        self.force += (wanted - self.force) * share
        self.then, self.largest = now, max(self.largest, self.force)
        return self.force + self.noise * self.random.standard_normal()


class Pad(Endpoint):
    """A pad of ``gripper`` that is heard ``rate`` times a second, until ``dies`` [s]."""

    rejected = NONE_BROKEN  # nothing goes wrong

    def __init__(self, name, gripper, clock, rate=250.0, dies=math.inf):
        self.name, self.gripper, self.times, self.dies = name, gripper, clock, dies
        self.period, self.due, self.seq, self.closed = round(NS / rate), 0, 0, False
        self.scale = 1.0  # by which it reads wrong

    def receive(self, timeout):  # noqa: ARG002
        now = self.times.now()
        self.arrivals = []
        if now < self.due or now / NS > self.dies:
            return []
        self.due = now + self.period
        self.seq += 1
        self.arrivals = [now]
        return [FingertipState(now, self.name, self.seq, self.scale * self.gripper.feel(now / NS))]

    def send(self, message):
        pass

    def close(self):
        self.closed = True


class Line(Endpoint):
    """The drive of ``gripper``."""

    device_faults = frozenset()
    obeys = True
    rejected = NONE_BROKEN

    def __init__(self, gripper, clock):
        self.gripper, self.times, self.told, self.closed = gripper, clock, [], False

    def receive(self, timeout):  # noqa: ARG002
        return []

    def send(self, message):
        assert isinstance(message, ForceCommand)
        assert message.expires > self.times.now()
        self.told.append(message.normal_force)
        self.gripper.tell(message.normal_force, self.times.now() / NS)

    def close(self):
        self.closed = True
