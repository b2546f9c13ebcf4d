"""A simulated robot takes on a strategy, keeps to it while it drives, and gives it up again."""

from __future__ import annotations

from rosic.config.profiles import load_profile, shipped_profiles
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.robot import SimulatedRobot, answer
from rosic_sim.robots.simulation_loop import simulation_of
from tests.gateway.place import BO, Place


class Simulated(Place):
    """Its robots move."""

    kind = SimulatedRobot


async def moved_in_s(here: Place) -> float:
    """Let omni move half a metre, and return how long it took."""
    machine = simulation_of(here.clock).world.machines["omni"]
    assert isinstance(machine, Omni)
    begun_s = simulation_of(here.clock).now_s()
    await here.say("omni move 0.5 m speed 0.5", account=BO, chat=BO)
    fastest = 0.0
    for _ in range(200):
        await here.clock.advance(0.1)
        fastest = max(fastest, abs(machine.base.velocity.x_m_s))
        if machine.at_rest() and not here.gateway.robots["omni"].presence().doing:
            break
    assert fastest <= machine.speed_cap_m_s + 0.01
    return simulation_of(here.clock).now_s() - begun_s


async def test_it_drives_no_faster_until_it_goes_back() -> None:
    omni = load_profile(shipped_profiles()["omni"], link="simulated")
    async with Simulated(fleet=(omni,)).open() as here:
        usual_s = await moved_in_s(here)
        await here.say("/strategy omni careful speed=10cm/s now", account=BO, chat=BO)
        await here.clock.advance(1)
        told = [t.outbound.text for t in here.chat.told]
        assert any("omni has taken on: Careful (speed 0.1 m/s)." in text for text in told)
        careful_s = await moved_in_s(here)
        assert careful_s > 5.0 > usual_s
        await here.say("/strategy omni back now", account=BO, chat=BO)
        await here.clock.advance(1)
        assert await moved_in_s(here) < 5.0


def test_velocities_keep_to_it_and_what_it_does_not_know_is_declined() -> None:
    machine = Omni()
    said = answer(machine, b'{"kind":"strategy","id":"1","name":"careful","values":{"speed":0.1}}')
    assert said == b'{"kind":"ack","id":"1","ok":true,"why":""}'
    machine.set_velocity(0.4, 0.3, 0.2, 0.0)
    for step in range(1, 100):
        machine.set_velocity(0.4, 0.3, 0.2, step * 0.02)
        machine.step(step * 0.02)
    velocity = machine.base.velocity
    assert abs(velocity.x_m_s - 0.08) < 0.005
    assert abs(velocity.y_m_s - 0.06) < 0.005
    for declined in (
        b'"name":"wild"',
        b'"name":"careful","values":{"speed":-1.0}',
        b'"name":"careful","values":{"speed":"fast"}',
    ):
        words = b'{"kind":"strategy","id":"2",' + declined + b"}"
        assert b'"ok":false' in (answer(machine, words) or b"")
    assert machine.speed_cap_m_s == 0.1
    assert answer(machine, b'{"kind":"told","from":"cf1","data":1}') is None
    assert answer(machine, b"{") is None
    answer(machine, b'{"kind":"strategy","id":"3","name":"","values":{}}')
    assert machine.speed_cap_m_s == 0.8
