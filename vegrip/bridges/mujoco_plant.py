"""A gripper of two soft pads in MuJoCo: a world that is not ours, under the controllers of ``vegrip.trials``.

The frame is that of :mod:`vegrip.virtual.hand`: z along the normals, gravity along -y. The first finger keeps
its place, the second is driven. Pads are spheres, pressed as :class:`FingertipSettings` say once they are
relaxed (:mod:`.mujoco_contact`); they forget nothing, do not relax, and slide at an ellipse.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import mujoco
import numpy as np

from vegrip.bridges.mujoco_contact import nearest_law
from vegrip.errors import UsageError
from vegrip.hand_sample import HandSample
from vegrip.types import Floats
from vegrip.virtual import Disturbance, FingertipSettings, HandSettings, kernels
from vegrip.virtual.disturbance import burden_rows
from vegrip.virtual.hand import CLEARANCE_M
from vegrip.virtual.sensor import Sensors

FINGER_MASS_KG: Final = 0.05  # of the driven finger
FINGER_DAMPING: Final = 5.0  # [N s/m] of its guide
HEAVIEST_PRESS_N: Final = 10.0  # up to which the springs of the pads are fitted
TORSION: Final = 3.0 * math.pi / 16.0  # limit torque over mu N a of a Hertz contact
ON_CONE: Final = 0.99  # utilisation from which a contact that moves counts as sliding: solver tolerance
STATED_AT_N: Final = 5.0  # normal force at which friction is the one that is stated
CREEP_FORCE_N: Final = 3.0  # of each finger, with which the creep of the simulator is shown
SETTINGS: Final = ((1.0, 0), (10.0, 0), (100.0, 0), (10.0, 10))
"""impratio and noslip_iterations whose creep is shown; the last ones are the plant's."""
XML: Final = """
<mujoco><option timestep="{step}" cone="elliptic" impratio="{impratio}" noslip_iterations="{noslip}"
  gravity="0 0 0"/><default><geom condim="4"/></default><worldbody>
<body name="first" pos="0 0 {first_z}"><geom name="first" type="sphere" size="{first_r}" priority="1"/></body>
<body name="second" pos="0 0 {second_z}"><joint name="drive" type="slide" axis="0 0 1" damping="{damping}"/>
  <geom name="second" type="sphere" size="{second_r}" mass="{finger}" priority="1"/></body>
<body name="object"><freejoint/><inertial pos="{x} {y} 0" mass="{mass}" diaginertia="{i} {i} {i}"/>
  <geom name="object" type="{shape}" size="{size}" euler="{euler}"/></body>
</worldbody><actuator><motor joint="drive"/></actuator></mujoco>"""


@dataclass(frozen=True)
class Shape:
    """A geom of MuJoCo; the pads press it at its middle."""

    kind: str = "box"  # also cylinder, whose axis stands along y, or ellipsoid
    size: tuple[float, ...] = (0.03, 0.05, 0.02)  # [m] half lengths; of a cylinder radius and half height

    @property
    def half(self) -> float:
        """Half its thickness between the pads [m]."""
        return self.size[0] if self.kind == "cylinder" else self.size[2]


def elliptic_least_force(
    force: float,
    tangential: float,
    torque: float,
    mu: float,
    radius: float,
    exponent: float,  # noqa: ARG001 (an ellipse has none)
    friction_exponent: float = 0.0,
) -> float:
    """Return the normal force [N] at which a load is on MuJoCo's cone; a ``known_contact.LeastForce``."""
    if not (force > 0.0 and radius > 0.0):
        return 0.0 if tangential + torque == 0.0 else math.inf
    plain = math.hypot(tangential, torque / (TORSION * radius)) / mu
    least: float = force * (plain / force) ** (1.0 / (1.0 - friction_exponent))
    return least


class MujocoHand:
    """A plant as :class:`vegrip.trials.known_contact.Plant` has it.

    Args:
        settings: tips, object, drives and sensors, as for the virtual hand; two fingers.
        seed: of the scatter between fingertips, of bias and noise.
        events: disturbances.
        shape: of the object.
        impratio: of the solver.
        noslip: iterations of it; 0 lets every held object creep.

    Raises:
        UsageError: there are not two fingers.

    """

    def __init__(
        self,
        settings: HandSettings,
        seed: int = 0,
        events: Sequence[Disturbance] = (),
        shape: Shape = Shape(),
        *,
        impratio: float = SETTINGS[-1][0],
        noslip: int = SETTINGS[-1][1],
    ) -> None:
        if len(settings.fingers) != 2:
            raise UsageError("the gripper of MuJoCo has two fingers; give --grasp pinch")
        self.settings, self.fingers, self._events = settings, settings.fingers, events
        make, noise = (np.random.default_rng([seed, stream]) for stream in (0, 1))
        self._tips = settings.tips(make)
        self._sensors = Sensors(settings.sensor, settings.fingers, noise)
        self._records, self._body = np.zeros(2, kernels.TIP), np.zeros(1, kernels.BODY)
        self._body["step"], self._records["side"] = settings.step, (1.0, -1.0)
        self._radii = [math.sqrt(tip.radius * tip.reference_indentation) for tip in self._tips]
        self._records["a"], self._records["k"] = self._radii, 2.0
        self.model = mujoco.MjModel.from_xml_string(_mjcf(settings, self._tips, shape, impratio, noslip))
        self.data = mujoco.MjData(self.model)
        self._pads = [self.model.geom(name).id for name in ("first", "second")]
        self._object = self.model.body("object").id
        for pad, tip in zip(self._pads, self._tips, strict=True):
            self._soften(pad, tip)
        self.model.actuator_gainprm[0, 0] = 1.0
        self._ticks = self._samples = self.epoch = 0  # [ns] stamp of time zero
        self.asked = self._target = self._pressed = 0.0
        self._used, self._jacobians = np.zeros(2), np.zeros((2, 3, self.model.nv))
        self.dropped = False

    @property
    def time(self) -> float:
        return self._ticks * self.settings.step

    @property
    def slips(self) -> int:
        return int(self._body["slips"][0])

    @property
    def largest_micro_slip(self) -> float:
        ended = self._body.copy()
        kernels.end_event(ended[0], self._records)
        return float(ended["largest_micro_slip"][0])

    @property
    def friction_exponent(self) -> float:
        return self.settings.tip.friction_exponent

    @property
    def shift(self) -> float:
        """How far the object has moved along the faces since the start [m]."""
        return float(np.hypot(*self.data.xpos[self._object, :2]))

    def contact(self, number: int) -> tuple[float, float, float, float]:
        tip = self._records[number]
        return float(tip["force"]), float(tip["mu"]), float(tip["a"]), float(tip["k"])

    def advance(self, dt: float, commands: Floats) -> list[HandSample]:
        samples, warmth = list[HandSample](), self.settings.thermal.start
        self.asked += dt
        while (self._ticks + 0.5) * self.settings.step < self.asked:
            self._step(float(np.nanmax(commands)) if np.isfinite(commands).any() else math.nan)
            if self.time * self.settings.sensor.rate >= self._samples + 1.0 - 1e-9:
                self._samples += 1
                samples.append(self._sensors.sample(self._records, warmth, self.time, self.epoch))
        return samples

    def truths(self) -> Floats:
        rows = []
        for tip, used in zip(self._records, self._used.tolist(), strict=True):
            s, load = tip["side"], math.hypot(tip["pull_x"], tip["pull_y"])
            at = (tip["force"], tip["depth"], tip["a"], tip["k"], tip["mu"])
            pulls = (-s * tip["pull_x"], tip["pull_y"], -s * tip["torque"])
            radius = math.hypot(load, tip["torque"] / tip["a"]) / used if used > 0.0 else math.inf
            slides = (tip["slides"], tip["sliding_share"], tip["slip_speed"], tip["slip_distance"])
            rows.append([*map(float, (*at, *pulls, used, radius, *slides))])
        return np.array(rows)

    def _soften(self, pad: int, tip: FingertipSettings) -> None:
        """Give a pad the spring that its relaxed material is nearest to."""
        inverse = self.model.body_invweight0[[self.model.geom_bodyid[pad], self._object], 0].sum()
        relaxed = (1.0 - sum(tip.amplitudes)) * tip.reference_force
        deepest = tip.reference_indentation * (HEAVIEST_PRESS_N / relaxed) ** (1.0 / tip.exponent)
        depths = deepest * np.geomspace(0.1, 1.0, 16)
        forces = relaxed * (depths / tip.reference_indentation) ** tip.exponent
        law = nearest_law(depths, forces, 1.0 / float(inverse), (tip.friction, 0.0, 0.0))
        self.model.geom_solref[pad], self.model.geom_solimp[pad] = law.solref, law.solimp

    def _step(self, command: float) -> None:
        s, now = self.settings, (self._ticks + 1) * self.settings.step
        wanted = s.actuator.initial_force if now <= s.actuator.close_time else command
        self._drive(wanted)
        burden = burden_rows(self._events, np.array([now]))[0]
        self._load(burden, now)
        for tip, made, pad in zip(self._records, self._tips, self._pads, strict=True):
            softened = (max(tip["force"], 0.1) / STATED_AT_N) ** -made.friction_exponent
            tip["mu"] = made.friction * softened * burden[5]
            self.model.geom_friction[pad] = tip["mu"], tip["mu"] * TORSION * tip["a"], 1e-4
        mujoco.mj_step(self.model, self.data)
        self._ticks += 1
        self._feel()

    def _drive(self, wanted: float) -> None:
        """Follow the commanded force, limited in rate, with one pole; NaN holds what is pressed."""
        drive, step = self.settings.actuator, self.settings.step
        if math.isfinite(wanted):
            change, most = min(max(wanted, 0.0), drive.force_limit) - self._target, drive.force_rate * step
            self._target += min(max(change, -most), most)
        self._pressed += (1.0 - math.exp(-2.0 * math.pi * drive.bandwidth * step)) * (
            self._target - self._pressed
        )
        self.data.ctrl[0] = self._pressed

    def _load(self, burden: Floats, now: float) -> None:
        plate, drive = self.settings.plate, self.settings.actuator
        lifted = (now - drive.close_time) / drive.lift_time if drive.lift_time > 0.0 else math.inf
        weight = min(max(lifted, 0.0), 1.0) * (plate.mass + burden[3]) * plate.gravity
        force = burden[0] + weight * math.sin(burden[4]), burden[1] - weight * math.cos(burden[4])
        self.data.xfrc_applied[self._object] = *force, 0.0, 0.0, 0.0, burden[2]

    def _feel(self) -> None:
        """Note force, torque and slide of both contacts, as the object does them to the pads."""
        felt, tips = np.zeros(6), self._records
        for name in ("force", "pull_x", "pull_y", "torque", "depth", "slip_speed", "sliding_share"):
            tips[name] = 0.0
        self._used[:] = 0.0
        for number in range(self.data.ncon):
            contact = self.data.contact[number]
            i = self._pads.index(next(g for g in contact.geom.tolist() if g in self._pads))
            sign = -1.0 if contact.geom[0] == self._pads[i] else 1.0  # the force is that on the second geom
            mujoco.mj_contactForce(self.model, self.data, number, felt)
            frame, tip = contact.frame.reshape(3, 3), tips[i]
            pull = sign * (frame.T @ felt[:3])
            tip["force"], tip["depth"] = felt[0], -contact.dist
            tip["pull_x"], tip["pull_y"], tip["torque"] = pull[0], pull[1], sign * felt[3] * frame[0, 2]
            v, spin = self._moves(contact, self._pads[i])
            tip["slip_speed"] = math.hypot(v, 2.0 / 3.0 * spin * tip["a"])
            load = math.hypot(math.hypot(felt[1], felt[2]), felt[3] / (TORSION * tip["a"]))
            self._used[i] = load / (tip["mu"] * felt[0]) if felt[0] > 0.0 else 0.0
            tip["sliding_share"] = 1.0 if self._used[i] > ON_CONE else 0.0
        tips["slip_distance"] += tips["slip_speed"] * tips["sliding_share"] * self.settings.step
        kernels.watch_slips(self._body[0], tips)
        plate, turned = self.settings.plate, self.data.xmat[self._object].reshape(3, 3)
        angle = math.acos(min(max((np.trace(turned) - 1.0) / 2.0, -1.0), 1.0))
        self.dropped = self.shift > plate.drop_distance or angle > plate.drop_angle

    def _moves(self, contact: Any, pad: int) -> tuple[float, float]:
        """Return the speed [m/s] of the object along a pad, and its spin about the normal [rad/s]."""
        v, spin, normal = np.zeros(3), np.zeros(3), contact.frame[:3]
        for body, sign in ((self._object, 1.0), (self.model.geom_bodyid[pad], -1.0)):
            mujoco.mj_jac(self.model, self.data, *self._jacobians, contact.pos, body)
            v += sign * (self._jacobians[0] @ self.data.qvel)
            spin += sign * (self._jacobians[1] @ self.data.qvel)
        return float(np.linalg.norm(v - (v @ normal) * normal)), float(normal @ spin)


def simulator_creep(seconds: float = 1.0) -> list[dict[str, float]]:
    """Return how fast a box held by a constant force creeps [m/s], for each of :data:`SETTINGS`.

    Its load is below its friction: what it moves is the solver's.
    """
    settings = HandSettings(fingers=("thumb", "index"), x=(0.0, 0.0), y=(0.0, 0.0))
    found = []
    for impratio, noslip in SETTINGS:
        hand = MujocoHand(settings, 0, (), impratio=impratio, noslip=noslip)
        commands = np.full(2, CREEP_FORCE_N)
        hand.advance(2.0, commands)
        before = hand.shift
        hand.advance(seconds, commands)
        creep = abs(hand.shift - before) / seconds
        found.append({"impratio": impratio, "noslip_iterations": noslip, "creep": creep})
    return found


def _mjcf(
    settings: HandSettings, tips: Sequence[FingertipSettings], shape: Shape, impratio: float, noslip: int
) -> str:
    first, second = (shape.half + tip.radius for tip in tips)
    return XML.format(
        step=settings.step, impratio=impratio, noslip=noslip, first_z=first, second_z=-second - CLEARANCE_M,
        first_r=tips[0].radius, second_r=tips[1].radius, damping=FINGER_DAMPING, finger=FINGER_MASS_KG,
        x=settings.plate.offset_x, y=settings.plate.offset_y, mass=settings.plate.mass,
        i=settings.plate.inertia, shape=shape.kind, size=" ".join(map(str, shape.size)),
        euler="90 0 0" if shape.kind == "cylinder" else "0 0 0",
    )  # fmt: skip
