"""Many people, one robot: a class of twenty, their teacher and one arm (Algorithm 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.policy.roles import DEFAULT_ROLES, Role, RoleRules
from rosic.core.policy.scope import RESUME
from rosic_sim.scenarios.robots import shipped
from rosic_sim.scenarios.scenario import Person, Scenario

if TYPE_CHECKING:
    from rosic_sim.scenarios.scenario import ScenarioRunner

ARM: Final = "kuka1"
TEACHER: Final = "Teacher"
STUDENTS: Final = tuple(f"Student {number}" for number in range(1, 21))
FIRST, SECOND, THIRD, *REST = STUDENTS
# Any of them may stop the arm, and whoever plays one of them may be alone with it: nobody else in a
# play resumes it.
STUDENT: Final = Role(
    scopes=tuple(f"{ARM}:{skill}" for skill in ("home", "grasp", "release", "move_joint", RESUME)),
    limits=("force <= 20 N",),
    priority=10,
)


async def _script(stage: ScenarioRunner) -> None:
    stage.aside("Twenty students share one arm. The first books it; nineteen others try as well.")
    await stage.says(FIRST, "/book kuka1 now 10 min", hears="is yours")
    stage.muted.update(REST)
    for student in STUDENTS[1:]:
        await stage.says(student, "kuka1 home")
    for student in STUDENTS[1:]:
        await stage.hears(student, f"{FIRST}")
    stage.aside(f"{len(REST)} more have read the same. Nothing has moved.")
    await stage.says(FIRST, "kuka1 grasp force=30", hears="20 N")
    await stage.says(FIRST, "kuka1 grasp force=20", hears="object held")
    await stage.says(SECOND, "/wait kuka1", hears="number 1 in the queue")
    await stage.says(THIRD, "/wait kuka1", hears="number 2 in the queue")
    stage.aside(f"{FIRST} is done early and gives the rest of the time back: the queue moves up.")
    await stage.taps(FIRST, "Cancel it", hears="is given back")
    await stage.hears(SECOND, "is free")
    await _takes_it(stage, SECOND)
    await stage.says(SECOND, "kuka1 move joint 1 to 120 deg", hears="accepted")
    stage.aside("The teacher sees where this is going, and may take the arm over.")
    await stage.says(TEACHER, "kuka1 home", hears="take it over")
    await stage.says(TEACHER, "/take over kuka1", hears="is yours now")
    await stage.hears(SECOND, "took it over")
    await stage.says(TEACHER, "kuka1 home", hears="done ")
    await stage.says(TEACHER, "/end kuka1", hears="Session ended")


async def _takes_it(stage: ScenarioRunner, student: str) -> None:
    await stage.taps(student, "Take it")


LESSON: Final = Scenario(
    name="class",
    about="twenty students, their teacher and one arm",
    people=(*(Person(name, "student") for name in STUDENTS), Person(TEACHER, "senior")),
    profiles=lambda: shipped(ARM),
    machines=tuple,
    script=_script,
    hints=("/book kuka1 now 10 min", "kuka1 grasp force=20", "kuka1 home", "/slots kuka1", "stop"),
    rules=RoleRules(roles={**DEFAULT_ROLES, "student": STUDENT}, preempt=(ARM,)),
    lease_idle_s=5.0,
)
