"""The six robots of the paper's Figure 5, the things around them, and the faults to try."""

from __future__ import annotations

from dataclasses import dataclass

from rosic_sim.robots.machines.crazyflie import Crazyflie
from rosic_sim.robots.machines.kuka import STATION_M, Kuka
from rosic_sim.robots.machines.objects import SimulatedObject, SimulatedObjects
from rosic_sim.robots.machines.omni import Omni
from rosic_sim.robots.machines.stepped_machine import SUBSTEP_S, SteppedMachine
from rosic_sim.robots.machines.swarm import Place, Swarm
from rosic_sim.robots.machines.yumi import FORCE_N, Side, Yumi

CUBE, PART = "cube", "part"
SWARM_PLACES: dict[str, Place] = {"cf1": (0.0, 1.0), "cf2": (0.0, 0.0), "cf3": (0.0, -1.0)}


@dataclass(slots=True)
class SimulatedWorld:
    """Everything that is simulated in one process.

    Each robot counts in a frame of its own: odometry from where it started, an arm's base, the
    room of the drones. Nothing but the drones shares space.

    Attributes:
        machines: By robot id.
    """

    omni: Omni
    kuka: Kuka
    yumi: Yumi
    drones: tuple[Crazyflie, ...]
    swarm: Swarm
    things: SimulatedObjects
    machines: dict[str, SteppedMachine]
    now_s: float | None = None

    @property
    def moving(self) -> bool:
        """True while any machine has something to do."""
        return any(machine.moving for machine in self.machines.values())

    def step(self, now_s: float) -> None:
        """Step every machine; the drones side by side, so that none seems unheard to another.

        Call it at least every few seconds while a drone flies; a longer gap is caught up with,
        at about 100 us of computing for each 10 ms.
        """
        for machine in self.machines.values():
            if not isinstance(machine, Crazyflie):
                machine.step(now_s)
        at_s = self.now_s if self.now_s is not None else now_s
        while any(drone.moving for drone in self.drones) and at_s + SUBSTEP_S < now_s:
            at_s += SUBSTEP_S
            for drone in self.drones:
                drone.step(at_s)
        for drone in self.drones:
            drone.step(now_s)
        self.now_s = now_s

    def add(self, machine: SteppedMachine) -> None:
        """Take in one more machine; it moves and is looked at like the others.

        Raises:
            ValueError: There is one of that name.
        """
        if self.machines.setdefault(machine.id, machine) is not machine:
            raise ValueError(f"there is a machine called {machine.id!r}")

    # --------------------------------------------------------------------------------------- faults

    def remove_thing(self, name: str) -> None:
        """Take a thing away, also out of a gripper."""
        self.things.remove(name)

    def put_back(self) -> None:
        """Put the cube at its station, if it is nowhere."""
        if self.things.get(CUBE) is None:
            self.things.add(_cube())

    def set_battery(self, robot: str, fraction: float) -> None:
        """Set a battery.

        Raises:
            ValueError: Not in [0, 1], or the robot is on mains.
            KeyError: No such robot.
        """
        battery = self.machines[robot].battery
        if battery is None or not 0.0 <= fraction <= 1.0:
            raise ValueError(f"{robot} has no battery, or {fraction} is not in [0, 1]")
        battery.charge_to(fraction)

    def lose(self, robot: str, now_s: float) -> None:
        """Cut a robot's link: it holds or lands by itself, and its peers hear it no more."""
        self.machines[robot].cut_link(now_s)

    def find(self, robot: str, now_s: float) -> None:
        """Mend the link of a lost robot; a drone is heard again at once."""
        self.machines[robot].mend_link(now_s)

    def fail_arm(self, side: Side, now_s: float) -> None:
        """Let an arm of the YuMi fail."""
        self.yumi.fail_arm(side, now_s)

    def repair_arm(self, side: Side) -> None:
        """Repair an arm of the YuMi."""
        self.yumi.repair_arm(side)


def _cube() -> SimulatedObject:
    # 9 N are needed to lift it: the least force, 5 N, lets it slip, the ordinary 15 N holds it.
    return SimulatedObject(CUBE, "kuka1", STATION_M, mass_kg=0.5, width_m=0.05)


def build_world(*, one_swarm: bool = True) -> SimulatedWorld:
    """Build the world, always the same.

    The omni stands at its origin with the arm folded; kuka1 is at home with a cube at its
    station; yumi is at home with a part in its left gripper; cf1, cf2, cf3 stand on the ground
    in a line along y, 1 m apart, cf2 in the middle; batteries are full.

    Args:
        one_swarm: Every drone knows of all; otherwise only what it hears of the others.
    """
    things = SimulatedObjects(
        (_cube(), SimulatedObject(PART, "yumi", (0.0, 0.0, 0.0), mass_kg=0.1, width_m=0.02))
    )
    part = things.get(PART)
    omni, kuka, yumi = Omni("omni"), Kuka("kuka1", things), Yumi("yumi", things)
    if part is not None:
        yumi.grippers["left"].take(part, FORCE_N)
    swarm = Swarm(tuple(SWARM_PLACES))
    drones = tuple(
        Crazyflie(name, swarm if one_swarm else Swarm(tuple(SWARM_PLACES)), place)
        for name, place in SWARM_PLACES.items()
    )
    machines: dict[str, SteppedMachine] = {m.id: m for m in (omni, kuka, yumi, *drones)}
    return SimulatedWorld(omni, kuka, yumi, drones, swarm, things, machines)
