"""After a button that is no good any more: the questions that still wait for an answer."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.authoriser.enrolment_records import PENDING_S
from rosic.core.i18n import joined
from rosic.features.access import messages, request_messages
from rosic.features.access.approve import buttons_for

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Button
    from rosic.features.access.access_request import AccessRequestCommands
    from rosic.features.access.approve import ApprovalCommands
    from rosic.gateway.delivery.notifier import Notifier

MOST = 4


class ApprovalReminders:
    """Shows an admin again what they were asked, with new buttons and the words to write."""

    def __init__(
        self, reach: Notifier, admitting: ApprovalCommands, request_commands: AccessRequestCommands
    ) -> None:
        self._reach = reach
        self._admitting = admitting
        self._request_commands = request_commands

    def remind(self, principal: PrincipalId) -> None:
        """Tell somebody what still waits for them, if anything does."""
        lines: list[str] = []
        rows: list[tuple[Button, ...]] = []
        for name, line, row in self._open(principal)[:MOST]:
            lines += [line, request_messages.answer_so(name)]
            rows.append(row)
        if rows:
            text = joined("\n", (request_messages.still_open(), *lines))
            self._reach.tell((principal,), text, tuple(rows), lifetime_s=PENDING_S, still=True)

    def _open(self, principal: PrincipalId) -> list[tuple[str, str, tuple[Button, ...]]]:
        found = [
            (a.name, messages.waits(a.name, a.pending.given.words, a.words), buttons_for(a, a.name))
            for a in self._admitting.waiting(principal)
        ]
        return found + list(self._request_commands.questions(principal))
