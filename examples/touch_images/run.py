"""Contact radius from images of a gel, as GelSight and DIGIT take them, into a recording and onto a socket.

The images are made here: an imprint of known radius under noise and uneven light. With a camera, put its
frames in place of ``gel_image``.
"""

import math
import sys

import numpy as np
from scipy import ndimage

from vegrip import FingertipState, Recording, open_endpoint, read_recording, write_recording

METRES_PER_PIXEL = 5e-5  # [m] of the surface of the gel, from a picture of a ruler
PIXELS = 240
NOISE = 2.0  # grey levels
LEVEL = 4.0  # standard deviations of a pixel's change from which it counts as pressed
SMALLEST = 60  # pixels; less is noise
RATE = 30.0  # [Hz]

rng = np.random.default_rng(1)
y, x = np.mgrid[:PIXELS, :PIXELS]
light = 120.0 + 0.2 * x - 0.1 * y


def gel_image(radius: float) -> np.ndarray:
    """Return a picture of a gel with a round imprint of ``radius`` [m]."""
    r = METRES_PER_PIXEL * np.hypot(x - 130, y - 110)
    imprint = (
        40.0 * np.sqrt(np.clip(1.0 - (r / radius) ** 2, 0.0, 1.0)) + 15.0 * (r < radius) if radius else 0.0
    )
    return light + imprint + NOISE * rng.standard_normal((PIXELS, PIXELS))


def contact_radius(image: np.ndarray, idle: np.ndarray, noise: float) -> float:
    """Return the radius [m] of the disc that has the area of the largest changed spot; 0 without one."""
    changed = ndimage.uniform_filter(np.abs(image - idle), 3) > LEVEL * noise
    spots, count = ndimage.label(changed)
    area = np.bincount(spots.ravel())[1:].max() if count else 0
    return METRES_PER_PIXEL * math.sqrt(area / math.pi) if area >= SMALLEST else 0.0


untouched = np.array([gel_image(0.0) for _ in range(20)])
idle, noise = untouched.mean(axis=0), float(untouched.std(axis=0).mean())

t = np.arange(90) / RATE
true = np.where(t < 0.3, 0.0, 3e-3 * np.clip((t - 0.3) / 1.5, 0.0, 1.0) ** (1.0 / 3.0))
seen = np.array([contact_radius(gel_image(radius), idle, noise) for radius in true])
worst = np.abs(seen - true)[true > 1e-3].max()
print(f"{len(t)} images: the contact radius is off by {1e6 * worst:.0f} um at most, a pixel is 50 um")

# force comes from elsewhere: a load cell behind the gel, or a network that reads the image
force = 2.0 * (true / 3e-3) ** 3
channels = {"normal_force": force, "contact_radius": seen}
write_recording(Recording("gel", t, np.zeros(len(t), dtype=np.int64), channels), "gel")
print(f"gel: {len(read_recording('gel'))} rows with {', '.join(channels)}")

with open_endpoint("zmq", publish="tcp://127.0.0.1:*") as out:  # live: what a node subscribes to
    for n, (a, f) in enumerate(zip(seen, force, strict=True)):
        out.send(FingertipState(round(1e9 * t[n]), "index", n, normal_force=f, contact_radius=a))
sys.exit(int(worst > 3 * METRES_PER_PIXEL))
