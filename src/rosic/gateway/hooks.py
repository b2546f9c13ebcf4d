"""Who receives what is no order: commands, newcomers, questions before something dangerous.

What decides is there from the first moment; what only adds something is said later.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, TypeAlias

from rosic.core.identity import Caller, PrincipalId
from rosic.core.message import Button, Chat
from rosic.core.signal import Deferred, Signal
from rosic.errors import Refusal
from rosic.gateway.agreement import TaskSteps
from rosic.gateway.commands import CommandRegistry

if TYPE_CHECKING:
    from rosic.contracts.messenger import Messenger
    from rosic.core.language.command import CommandTable
    from rosic.core.message import Inbound
    from rosic.core.robot.profile import RobotId
    from rosic.gateway.commands import Reply
    from rosic.gateway.confirmation import Confirmation, Resolver
    from rosic.gateway.message_context import MessageContext, SteppedUp

ProofUsed: TypeAlias = Callable[[PrincipalId, Chat], None]
Refused: TypeAlias = Callable[[Caller, Refusal], None]


class PipelineHooks:
    """The doors beside the way of an order.

    Until `newcomer`, `enclosed` and `view_buttons` are bound nobody is let in, nothing is taken and
    nothing is shown; until `task_steps` is, no task lets a robot do anything.

    Attributes:
        commands: Who does which command.
        newcomer: Answers somebody unknown who may have brought a code; None: it was no code.
        enclosed: Takes in files that people send.
        outdated: Hears, in private, of a tap on a button that is no good any more.
        met: Hears who spoke, by which messenger, where: at least when one of the three is another
            than the last time.
        task_steps: What a task or a mission, as typed, lets robots do for somebody.
        not_understood: Hears of a line that was refused because it could not be read, once that is
            told.
        view_buttons: Buttons for what can be seen of a robot, for its menu.
        drafting: Where an order that somebody types is a step of a mission that they put together,
            and is not done: who, by which messenger, in which chat.

    Args:
        confirmation_of: Returns what asks for confirmations, made with what says what words come
            to.
        stepped_up: Whether somebody has shown a second factor lately, in a chat.
        proof_used: Has what this has let pass count for its idle time.
        refused: Follows the rules about misuse; told of every refusal.
        changes_late: Whether changes wait for a disk that hangs.
        commands: What can be asked of ROSIC, besides orders.
    """

    def __init__(
        self,
        *,
        confirmation_of: Callable[[Resolver], Confirmation],
        stepped_up: SteppedUp,
        proof_used: ProofUsed,
        refused: Refused,
        changes_late: Callable[[], bool],
        commands: CommandTable,
    ) -> None:
        self.commands = CommandRegistry(commands)
        self.confirmation_of = confirmation_of
        self.stepped_up = stepped_up
        self.proof_used = proof_used
        self.refused = refused
        self.changes_late = changes_late
        self.newcomer: Deferred[[Messenger, Inbound, str], Awaitable[Reply | None]]
        self.newcomer = Deferred(_no_code)
        self.enclosed: Deferred[[Messenger, Inbound, Caller], None] = Deferred(_left)
        self.task_steps: Deferred[[str, str, PrincipalId], TaskSteps] = Deferred(_no_steps)
        self.view_buttons: Deferred[[RobotId], list[Button]] = Deferred(_unseen)
        self.drafting: set[tuple[PrincipalId, str, str]] = set()
        self.met: Signal[[Messenger, Inbound, PrincipalId]] = Signal()
        self.outdated: Signal[[PrincipalId]] = Signal()
        self.not_understood: Signal[[MessageContext]] = Signal()


async def _no_code(_messenger: Messenger, _inbound: Inbound, _text: str) -> Reply | None:
    """Let nobody in: what codes are good is not known yet."""
    return None


def _left(_messenger: Messenger, _inbound: Inbound, _caller: Caller) -> None:
    """Take no file: there is nowhere to keep it."""


def _no_steps(_verb: str, _rest: str, _who: PrincipalId) -> TaskSteps:
    """Let no task do anything: nobody takes any."""
    return TaskSteps(())


def _unseen(_robot: RobotId) -> list[Button]:
    return []
