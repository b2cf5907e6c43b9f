"""The gripper in MuJoCo as a plant: what holds in it by mechanics, whatever the solver does."""

import json
from dataclasses import replace

import numpy as np
import pytest

from vegrip.bridges.mujoco_plant import MujocoHand, elliptic_least_force
from vegrip.cli import main
from vegrip.errors import UsageError, VegripError
from vegrip.trials.closed_loop import FORCE, FORCE_X, FORCE_Y, GRASPS, TORQUE
from vegrip.virtual.hand import TRUTHS

PINCH = GRASPS["pinch"]


def gripped(force: float, seconds: float, **plate: float) -> MujocoHand:
    hand = MujocoHand(replace(PINCH, plate=replace(PINCH.plate, **plate)), 3, ())
    hand.advance(seconds, np.full(2, force))
    return hand


def test_the_pads_carry_the_weight_and_press_alike() -> None:
    hand = gripped(6.0, 2.0)
    truth = hand.truths()
    weight = PINCH.plate.mass * PINCH.plate.gravity
    assert truth[:, FORCE] == pytest.approx([6.0, 6.0], rel=1e-3)
    assert truth[:, FORCE_Y].sum() == pytest.approx(-weight, rel=1e-3)  # it pulls the fingertips down
    assert truth[0, FORCE_X] - truth[1, FORCE_X] == pytest.approx(0.0, abs=1e-3)  # frames turned about y


def test_a_centre_of_mass_beside_the_grasp_twists_both_pads() -> None:
    hand = gripped(8.0, 2.0, offset_x=4e-3, offset_y=0.0)
    twist = hand.truths()[:, TORQUE]
    weight = PINCH.plate.mass * PINCH.plate.gravity
    assert twist[1] - twist[0] == pytest.approx(-4e-3 * weight, rel=0.05)  # each in its frame


@pytest.mark.parametrize(("share", "holds"), [(1.05, True), (0.95, False)])
def test_an_object_slides_below_its_least_force_and_not_above(share: float, *, holds: bool) -> None:
    plate = replace(PINCH.plate, offset_x=0.0, offset_y=0.0)
    hand = MujocoHand(replace(PINCH, plate=plate, spread=0.0), 3, ())
    hand.advance(2.0, np.full(2, 6.0))
    load = 0.5 * plate.mass * plate.gravity
    least = elliptic_least_force(6.0, load, 0.0, PINCH.tip.friction, 3e-3, 2.0)
    assert least == pytest.approx(load / PINCH.tip.friction)  # Coulomb's law
    hand.advance(1.5, np.full(2, share * least))
    assert (hand.slips == 0) is holds


def test_the_margin_is_the_distance_to_the_least_force() -> None:
    hand = gripped(5.0, 2.0)
    for number, row in enumerate(hand.truths()):
        force, mu, a, k = hand.contact(number)
        least = elliptic_least_force(force, np.hypot(row[FORCE_X], row[FORCE_Y]), abs(row[TORQUE]), mu, a, k)
        assert row[TRUTHS.index("utilisation")] == pytest.approx(least / force, rel=1e-3)


def test_the_same_seed_senses_the_same_to_the_bit() -> None:
    one, two = (MujocoHand(PINCH, 7).advance(0.2, np.full(2, 3.0)) for _ in range(2))
    assert all(np.array_equal(a.values, b.values, equal_nan=True) for a, b in zip(one, two, strict=True))


def test_a_hand_of_five_fingers_is_refused(capsys) -> None:
    with pytest.raises(UsageError, match="two fingers"):
        MujocoHand(GRASPS["hand"])
    assert main(["controllers", "--plant", "mujoco", "--grasp", "hand"]) == 2
    assert "leave --grasp hand out" in capsys.readouterr().err
    assert main(["controllers", "--plant", "mojuco"]) == 2
    assert "mujoco" in capsys.readouterr().err


@pytest.mark.long
def test_the_table_of_controllers_has_the_creep_of_the_simulator_beside(capsys) -> None:
    words = "controllers --plant mujoco --seeds 1 --duration 2.5 --only constant --world old --json"
    assert main(words.split()) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["controllers"]["constant"]["trials"] == 1
    assert said["grasp"] == "pinch"
    without, with_noslip = said["creep"][1], said["creep"][-1]
    assert without["noslip_iterations"] == 0 < with_noslip["noslip_iterations"]
    assert with_noslip["creep"] < 1e-5 < without["creep"]


def test_on_a_bus_the_plant_senses_and_obeys_as_the_virtual_hand_does() -> None:
    """Its frames go through the codec; held by 8 N, both pads say so, and without commands they keep it."""
    from vegrip.bridges.mujoco_node import build
    from vegrip.messages import FingertipState, ForceCommand, Reason
    from vegrip.runtime import NodeContext
    from vegrip.transport.codec import CanCodec

    fingers = ("thumb", "index")
    node = build({"disturbed": False}, NodeContext("/plant", fingers=fingers))
    node.configure()
    node.activate()
    hand, host = (CanCodec(fingers, fd=True, use_sender_time=True) for _ in range(2))
    felt: dict[str, list[float]] = {finger: [] for finger in fingers}
    for tick in range(1500):
        now = 10**9 + 2_000_000 * tick
        for finger in fingers if tick < 1250 else ():
            command = ForceCommand(now, finger, tick + 1, 8.0, 0.0, Reason.HOLD, expires=now + 20_000_000)
            for frame in host.encode(command):
                node.on_message(hand.decode(frame), now)
        for state in node.on_tick(now):
            for frame in hand.encode(state):
                heard = host.decode(frame)
                assert isinstance(heard, FingertipState)
                felt[heard.finger].append(heard.normal_force)
    for finger in fingers:
        assert len(felt[finger]) == pytest.approx(1500, abs=2)
        assert np.mean(felt[finger][1000:1250]) == pytest.approx(8.0, abs=0.2)  # bias and drift
        assert np.mean(felt[finger][1400:]) == pytest.approx(8.0, abs=0.2)
    assert node.hand.slips == 0
    assert not node.hand.dropped


def test_a_protocol_of_a_bench_is_refused(tmp_path) -> None:
    from vegrip.bridges.mujoco_node import build
    from vegrip.runtime import NodeContext

    with pytest.raises(VegripError):
        build({"protocol": str(tmp_path / "none.toml")}, NodeContext("/plant", fingers=("thumb", "index")))
