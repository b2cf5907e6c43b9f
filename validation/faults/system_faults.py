"""Faults of the bus, of the nodes and of the machines they run on."""

from dataclasses import dataclass

from validation.faults.cosimulation import Participant
from validation.faults.simulated_can import SimulatedEndpoint
from validation.faults.testbed import Scene
from vegrip.transport.canbus.bus_events import NO_FAULTS, NodeFaults


@dataclass
class BabblingIdiot:
    """A node that is not ours sends one identifier without pause."""

    identifier: int

    def begin(self, scene: Scene) -> None:
        """Join the bus."""
        self._idiot = scene.endpoint()
        self._idiot.endure(NodeFaults(babble=self.identifier))

    def end(self, scene: Scene) -> None:  # noqa: ARG002
        """Be pulled out."""
        self._idiot.close()


@dataclass
class BadTransceiver:
    """All frames of a node go wrong on the bus: it turns bus-off, comes back, turns off again."""

    who: str  # "hand" or "grip"

    def begin(self, scene: Scene) -> None:
        """Disturb each frame."""
        self._endpoint(scene).endure(NodeFaults(corruption=1.0))

    def end(self, scene: Scene) -> None:
        """Disturb no more."""
        self._endpoint(scene).endure(NO_FAULTS)

    def _endpoint(self, scene: Scene) -> SimulatedEndpoint:
        participant: Participant = scene.hand if self.who == "hand" else scene.grip
        return participant.endpoint


@dataclass
class NoisyWire:
    """A share of all frames is disturbed, of every sender."""

    share: float

    def begin(self, scene: Scene) -> None:
        """Disturb."""
        for seed, participant in enumerate(scene.simulation.participants):
            participant.endpoint.endure(NodeFaults(corruption=self.share, seed=seed))

    def end(self, scene: Scene) -> None:
        """Disturb no more."""
        for participant in scene.simulation.participants:
            participant.endpoint.endure(NO_FAULTS)


@dataclass
class Killed:
    """The node that grips is killed, and started again at the end."""

    def begin(self, scene: Scene) -> None:
        """Kill it."""
        scene.simulation.kill(scene.grip)

    def end(self, scene: Scene) -> None:
        """Start another."""
        scene.start_grip()


@dataclass
class Starved:
    """The computer of the node that grips does something else."""

    duration: float  # [s]

    def begin(self, scene: Scene) -> None:
        """Take its time."""
        scene.simulation.starve(scene.grip, self.duration)

    def end(self, scene: Scene) -> None:
        """Nothing to undo."""


@dataclass
class SubscriberGone:
    """A node that listened is killed."""

    def begin(self, scene: Scene) -> None:
        """Join, and leave at once."""
        scene.endpoint().close()

    def end(self, scene: Scene) -> None:
        """Nothing to undo."""


@dataclass
class DiskFull:
    """The disk takes nothing."""

    def begin(self, scene: Scene) -> None:
        """Refuse."""
        self._set(scene, full=True)

    def end(self, scene: Scene) -> None:
        """Take again."""
        self._set(scene, full=False)

    def _set(self, scene: Scene, *, full: bool) -> None:
        if scene.recorder is not None:
            scene.recorder.writer.full = full
