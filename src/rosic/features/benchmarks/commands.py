"""``/benchmark``: how a robot does against what is expected of it, and how it is set."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.core.i18n import joined
from rosic.core.language.command import Command
from rosic.features.benchmarks import messages as words
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from rosic.core.order_status import Face
    from rosic.core.robot.profile import RobotId
    from rosic.features.benchmarks.evaluation import BenchmarkEvaluation
    from rosic.gateway.commands import CommandContext
    from rosic.gateway.components import Components
    from rosic.gateway.robot_argument import RobotArgument

COMMANDS: Final = (
    Command(
        name="benchmark",
        summary="how a robot did against what is expected",
    ),
)


class BenchmarkCommands:
    """Answers for robots that the asker may see.

    Args:
        evaluation: Knows how each task was that came to its end, and how robots are set.
        rooms: Know the robots, and how people are called.
        naming: Finds the robot that is meant, among those that the asker may see.
        face: Writes when something was set.
    """

    def __init__(
        self, evaluation: BenchmarkEvaluation, rooms: Components, naming: RobotArgument, face: Face
    ) -> None:
        self._evaluation = evaluation
        self._rooms = rooms
        self._naming = naming
        self._face = face

    async def benchmark(self, asked: CommandContext) -> Reply:
        """Say how a robot does.

        Raises:
            Refusal: There is no such robot, as far as this person may know.
        """
        robot, _ = self._naming.robot(asked, "/benchmark", asked.rest)
        profile = self._rooms.profiles[robot]
        verdicts = self._evaluation.verdicts.get(robot, {})
        lines: list[str] = []
        for skill in profile.skills.values():
            if skill.benchmark is not None:
                done = verdicts.get(skill.id)
                title = skill.shown
                lines.append(words.not_yet(title) if done is None else words.verdict(done))
        text = joined("\n", [words.head(profile.shown), *lines]) if lines else ""
        parts = [text or words.none(profile.shown), self._settings(robot)]
        return Reply(joined("\n", [part for part in parts if part]))

    def _settings(self, robot: RobotId) -> str:
        organiser = self._rooms.organiser
        kept = self._evaluation.settings.of.get(robot, {})
        lines = [
            words.setting(name, one.value, organiser.name_of(one.by), self._face(one.at_ns))
            for name, one in kept.items()
        ]
        return words.settings(lines) if lines else ""
