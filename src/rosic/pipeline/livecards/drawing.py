"""What a card looks like now."""

from __future__ import annotations

from collections.abc import Callable
from math import ceil
from typing import TYPE_CHECKING, Final, NamedTuple

import msgspec

from rosic.contracts.messenger import Messenger
from rosic.core.identity import PrincipalId
from rosic.core.life import Face
from rosic.core.message import Button, Chat, ChatKind, Outbound, Weight
from rosic.core.robot import RobotId
from rosic.core.saying import Catalogue, joined
from rosic.pipeline.languages import translated
from rosic.pipeline.livecards import words_livecards as words

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rosic.contracts.clock import Clock
    from rosic.pipeline.livecards.glimpses import Glimpses
    from rosic.pipeline.livecards.livecard import LiveCard

ROBOTS_AT_MOST: Final = 12
"""More do not fit into one message of every messenger."""
LATE_S: Final = 5.0
BUTTON_BYTES: Final = 64
"""What a button carries on every messenger; a longer list of robots stops everything."""


class Pace(NamedTuple):
    """How often a card may change, and how old it may become.

    Attributes:
        between_s: From one edit to the next, at the least.
        refresh_s: After so long it is said anew how it is, though nothing has changed.
        promise_s: What it says about that, with room for a slow network.
    """

    between_s: float
    refresh_s: float
    promise_s: float


PRIVATE: Final = Pace(3.0, 45.0, 60.0)
GROUP: Final = Pace(15.0, 90.0, 120.0)
"""Four of the twenty messages and edits that Telegram lets a group have in a minute."""


class Sides(msgspec.Struct, frozen=True, kw_only=True):
    """What the rooms know that cards depend on.

    Attributes:
        sees: Returns the robots that somebody may see now; none for who is locked or has no key.
        name_of: Returns how somebody is called.
        face: Returns what a clock on the wall shows.
        tell: Says something in a chat.
        catalogue: Returns the texts in which somebody reads; None for English.
    """

    sees: Callable[[PrincipalId], frozenset[RobotId]]
    name_of: Callable[[PrincipalId], str]
    face: Face
    tell: Callable[[Messenger, Chat, str], object]
    catalogue: Callable[[PrincipalId], Catalogue | None]


class Drawing:
    """Makes the newest look at robots into a message."""

    def __init__(self, glimpses: Glimpses, sides: Sides, clock: Clock) -> None:
        self._glimpses = glimpses
        self._sides = sides
        self._clock = clock

    def shows(self, robots: Iterable[RobotId]) -> dict[RobotId, int]:
        """Return which look at which robots a card would show now."""
        return {robot: self._glimpses.number(robot) for robot in robots}

    def text(self, chat: Chat, owner: PrincipalId, robots: tuple[RobotId, ...]) -> str:
        """Return how these robots are."""
        private = chat.kind is ChatKind.PRIVATE
        lines = [] if private else [words.as_they_see(self._sides.name_of(owner))]
        lines += [self._glimpses.text(robot) for robot in robots[:ROBOTS_AT_MOST]]
        if len(robots) > ROBOTS_AT_MOST:
            lines.append(words.and_more(len(robots) - ROBOTS_AT_MOST))
        return joined("\n", lines)

    def outbound(self, card: LiveCard, robots: tuple[RobotId, ...], weight: Weight) -> Outbound:
        """Return the message, stamped with the time at which it is so."""
        now_ns, pace = self._clock.wall_ns(), pace_of(card.chat)
        lag_s = ceil(card.lag_s) if card.lag_s >= LATE_S else 0
        next_ns = now_ns + int((pace.promise_s + lag_s) * 1e9)
        stamp = words.updated(self._sides.face(now_ns), self._sides.face(next_ns), lag_s)
        outbound = Outbound(
            chat=card.chat,
            text=joined("\n", (self.text(card.chat, card.owner, robots), stamp)),
            buttons=((_stop_button(robots if card.robots else ()),),),
            weight=weight,
        )
        return translated(outbound, self._sides.catalogue(card.owner))

    def last(self, card: LiveCard) -> Outbound:
        """Return the message of a card that is over."""
        outbound = Outbound(chat=card.chat, text=card.last)
        return translated(outbound, self._sides.catalogue(card.owner))


def pace_of(chat: Chat) -> Pace:
    """Return how often a card in this chat may change."""
    return PRIVATE if chat.kind is ChatKind.PRIVATE else GROUP


def _stop_button(named: tuple[RobotId, ...]) -> Button:
    """Return what stops all that is shown: it is never bound to anybody, nor used up."""
    command = " ".join(("stop", *named))
    if len(command.encode()) > BUTTON_BYTES:
        command = "stop"
    return Button("STOP", command, command)
