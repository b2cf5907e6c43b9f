"""A protocol file done by the virtual hand's fingertips, recorded from the bus, and diagnosed."""

import numpy as np
import pytest
from vegrip.nodes.record import build as build_recorder
from vegrip.nodes.virtual_bench import VirtualBenchNode
from vegrip.nodes.virtual_hand import build

from validation.faults.cosimulation import Cosimulation
from validation.faults.simulated_can import SimulatedCan
from vegrip.clock import SimulatedClock
from vegrip.errors import ConfigError
from vegrip.identification.experiment import Hypotheses, hypotheses_of
from vegrip.identification.experiment.design_space import MENU, Rig
from vegrip.identification.fit import fit
from vegrip.identification.recording import Recording, read_recording
from vegrip.identification.simulate import Protocol, Segment, write_protocol
from vegrip.runtime import NodeContext
from vegrip.runtime.runner import LoopSettings
from vegrip.transport.codec import CanCodec
from vegrip.virtual import FingertipSettings
from vegrip.virtual.bench.trial import run_trial
from vegrip.virtual.settings import SensorSettings

ONE = ("index",)
TIP = FingertipSettings(radius=8e-3, amplitudes=(0.3,), rates=(3.0,), bristle_stiffness=1e10)
HAND = {
    "tip": {"radius": 8e-3, "amplitudes": [0.3], "rates": [3.0]},
    "spread": 0.0,
    "sensor": {"rate": 100.0},
}
PRESS = (Segment(0.3, depth=-1e-4), Segment(0.2, depth=8e-4), Segment(0.5), Segment(0.2, depth=-1e-4))
TICK = 10_000_000  # [ns]


def made(tmp_path, protocol: Protocol, **settings) -> VirtualBenchNode:
    path = tmp_path / "p.toml"
    write_protocol(protocol, path)
    return build({"protocol": str(path), "hand": HAND, **settings}, NodeContext("hand", fingers=ONE))


def test_the_fingertip_feels_what_the_bench_does(tmp_path) -> None:
    node = made(tmp_path, Protocol("p", (PRESS, PRESS), 1.0))
    node.configure()
    node.activate()
    states, now = [], 10**12
    while not node.finished:
        states += node.on_tick(now)
        now += TICK
    assert now - 10**12 == pytest.approx((0.5 + 2 * 1.2 + 1.0) * 1e9, abs=3 * TICK)
    assert len(states) == pytest.approx(390, abs=2)
    force = np.array([s.normal_force for s in states])
    lead = Segment(0.5, depth=-1e-4)
    joined = (lead, *PRESS, Segment(1.0), *PRESS)
    truth = run_trial(TIP, (joined,), SensorSettings(rate=100.0, normal_force=0.0), 0).truth["normal_force"]
    assert force == pytest.approx(truth, abs=0.08)
    assert np.std(force - truth) < 0.012
    assert [s.seq for s in states] == list(range(1, len(states) + 1))
    assert np.all(np.diff([s.stamp for s in states]) > 0)


def test_what_cannot_be_is_refused_when_the_node_is_built(tmp_path) -> None:
    fine = Protocol("p", (PRESS,), 0.0)
    with pytest.raises(ConfigError, match="no effect 'magic'"):
        made(tmp_path, fine, hidden={"magic": {}})
    with pytest.raises(ConfigError, match="unknown key 'strength'"):
        made(tmp_path, fine, hidden={"adhesion": {"strength": 1.0}})
    with pytest.raises(ConfigError, match="no such file"):
        build({"protocol": str(tmp_path / "absent.toml")}, NodeContext("hand", fingers=ONE))
    with pytest.raises(ConfigError, match="give a 'protocol' too"):
        build({"hidden": {"adhesion": {}}}, NodeContext("hand"))


@pytest.mark.slow
def test_an_experiment_done_by_the_virtual_hand_names_the_truth(tmp_path) -> None:
    """From plan to verdict: the protocol file, the bus, the recorder, the refits."""
    rig = Rig(1.4e-3, 0.02, 100.0, 8.0)
    peaks = next(one for one in MENU if one.name.startswith("growing")).protocol(
        rig, {"depth": 1.0, "time": 0.8}
    )
    hidden = {"mullins_softening": {"loss": 0.1}}
    node = made(tmp_path, peaks, hidden=hidden)
    recording = recorded(node, tmp_path / "rec")
    contest = hypotheses_of(fit(recording), ["mullins_softening", "permanent_set"])
    assert isinstance(contest, Hypotheses)
    errors = {name: fit(recording, model).optimum.cost for name, model in contest.models.items()}
    assert errors["permanent_set"] - errors["mullins_softening"] > 5.0


def recorded(node: VirtualBenchNode, folder) -> Recording:
    """Run hand and recorder on one simulated bus; return what the recorder wrote."""
    clock = SimulatedClock()
    world = Cosimulation(SimulatedCan(clock), clock)
    noise = {"normal_force": 0.01, "displacement": 5e-6, "tangential_force": 0.01, "torque_z": 1e-4}
    recorder = build_recorder(
        {"folder": str(folder), "radius": 8e-3, "noise": noise}, NodeContext("record", fingers=ONE)
    )
    for one, period in ((recorder, 0.1), (node, 0.01)):
        world.add(one, world.bus.endpoint(CanCodec(ONE, fd=True)), LoopSettings(tick_period=period))
    while not node.finished:
        world.run_until(clock.now() * 1e-9 + 1.0)
    for participant in world.participants:
        participant.runner.change("shutdown")
    return read_recording(folder / "index")
