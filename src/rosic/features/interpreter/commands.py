"""``/interpreter``: whether what is not understood may be shown to an interpreter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.container.preferences import OFF, ON
from rosic.core.i18n import said
from rosic.core.language.command import Command
from rosic.core.message import Button
from rosic.errors import NotUnderstood
from rosic.features.interpreter import messages as words
from rosic.features.interpreter.client import OFF_COMMAND, ON_COMMAND
from rosic.gateway.commands import Reply

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.container.preferences import PreferenceBook
    from rosic.features.interpreter.client import InterpreterClient
    from rosic.gateway.commands import CommandContext, CommandRegistry
    from rosic.gateway.transactions import Transactions

INTERPRETER: Final = "interpreter"
STATES: Final[Mapping[str, str]] = {
    "on": ON,
    "yes": ON,
    "an": ON,
    "ein": ON,
    "ja": ON,
    "off": OFF,
    "no": OFF,
    "never": OFF,
    "aus": OFF,
    "nein": OFF,
    "nie": OFF,
}
COMMANDS: Final = (
    Command(
        name=INTERPRETER,
        aliases=("dolmetscher",),
        verbs={"an": "on", "ein": "on", "ja": "on", "aus": "off", "nein": "off"},
        typed=said("/interpreter"),
        summary="whether what is not understood may be shown to an interpreter",
        explained=True,
    ),
)


class InterpreterCommands:
    """The handler of a person's yes and no.

    Args:
        client: Asks; None: nobody is asked here.
        preferences: Who has said what.
        changes: Writes it.
    """

    def __init__(
        self,
        client: InterpreterClient | None,
        preferences: PreferenceBook,
        changes: Transactions,
    ) -> None:
        self._client, self._preferences, self._changes = client, preferences, changes

    def register(self, commands: CommandRegistry) -> None:
        """Take the command."""
        commands.register(INTERPRETER, self.interpreter)

    async def interpreter(self, asked: CommandContext) -> Reply:
        """Say how it is, or change it.

        Raises:
            Refusal: Why not; nothing was changed.
        """
        client, who = self._client, asked.caller.principal
        if client is None:
            return Reply(words.NONE_HERE)
        typed = asked.rest.strip().casefold()
        if not typed:
            return self._state(client, self._preferences.of(who).interpreter)
        state = STATES.get(typed)
        if state is None:
            raise NotUnderstood(words.HOW, offers=(ON_COMMAND, OFF_COMMAND))
        if state == OFF:
            client.forget(who)
        async with self._changes.turn() as turn:
            await turn.write(self._preferences.set_interpreter(who, state))
        if state == ON:
            client.allowed(who)
        return self._state(client, state)

    def _state(self, client: InterpreterClient, state: str) -> Reply:
        if state == OFF:
            return Reply(words.OFF, ((Button(words.TURN_ON, ON_COMMAND),),))
        return Reply(words.on(client.where), ((Button(words.TURN_OFF, OFF_COMMAND),),))
