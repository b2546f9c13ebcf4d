"""The last picture on a card: asked for by a tap, shown in place, as old as the card says."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias

import msgspec

from rosic.contracts.messenger import pictures_of
from rosic.core.message import Attachment, Button, ChatKind, Outbound
from rosic.core.robot import RobotId
from rosic.errors import NothingToSee
from rosic.pipeline.livecards import words_livecards as words

if TYPE_CHECKING:
    from rosic.core.identity import PrincipalId
    from rosic.pipeline.livecards.livecard import LiveCard
    from rosic.pipeline.livecards.livecards import LiveCards
    from rosic.pipeline.office import Asked

Deliver: TypeAlias = Callable[[int, Outbound], Awaitable[None]]
Issue: TypeAlias = "Callable[[Button, PrincipalId, str], Button]"

BUTTONS_AT_MOST: Final = 3
"""So many robots of a card can be looked at by a tap; more buttons than robots help nobody."""
RENEWED_NS: Final = 20_000_000_000
"""A button lives for a minute; a card that is edited after so long shows new ones."""


class Pictured(msgspec.Struct, frozen=True):
    """A picture for a card.

    Attributes:
        robot: Whose it is.
        at_ns: When it was taken, wall clock.
        content: None once it was shown: what is shown is not kept.
    """

    robot: RobotId
    at_ns: int
    content: Attachment | None = None


class Camera(Protocol):
    """Looks at robots that may be looked at."""

    def offers(self, robot: RobotId) -> bool:
        """Whether its profile opens its camera to people, and pictures can be drawn here."""
        ...

    def look(self, asked: Asked, robot: RobotId, deliver: Deliver) -> None:
        """Begin to make a picture, and hand over when it was taken (wall clock), and how it looks.

        Only if whoever asked may still look then.

        Raises:
            Refusal: Not now; nothing was begun.
        """
        ...


class Picturing:
    """Puts the buttons under cards, and pictures on them.

    Attributes:
        camera: Looks; None until there is one: then no card offers a picture.
    """

    def __init__(self, issue: Issue, now_ns: Callable[[], int]) -> None:
        self.camera: Camera | None = None
        self._issue = issue
        self._now_ns = now_ns

    def row(self, card: LiveCard, robots: tuple[RobotId, ...]) -> tuple[Button, ...]:
        """Return the buttons that ask for a picture, bound to whose card it is."""
        offered = self._offered(card, robots)
        now_ns = self._now_ns()
        if card.offered != offered or now_ns > card.offered_ns + RENEWED_NS:
            card.offered, card.offered_ns = offered, now_ns
            card.buttons = tuple(
                self._issue(
                    Button(words.picture_button(robot if len(offered) > 1 else ""),
                           f"/card picture {robot}"),
                    card.owner, card.chat.id,
                )
                for robot in offered
            )  # fmt: skip
        return card.buttons

    def _offered(self, card: LiveCard, robots: tuple[RobotId, ...]) -> tuple[RobotId, ...]:
        camera, shows = self.camera, pictures_of(card.messenger)
        if camera is None or shows is None or card.chat.kind is ChatKind.CHANNEL:
            return ()
        return tuple(robot for robot in robots if camera.offers(robot))[:BUTTONS_AT_MOST]

    def ask(self, asked: Asked, live: LiveCards, robot: RobotId) -> None:
        """Look at a robot for the card of this chat, which then shows it.

        Raises:
            Refusal: There is no such card, or nothing to see.
        """
        card = live.of(asked.messenger, asked.inbound.chat)
        if card is None:
            raise NothingToSee(words.NO_SUCH_CARD)
        if self.camera is None or robot not in self._offered(card, (robot,)):
            raise NothingToSee(words.NO_PICTURE)
        card.offered = ()  # the one that was tapped is used up

        async def deliver(at_ns: int, outbound: Outbound) -> None:
            live.show_picture(card, Pictured(robot, at_ns, outbound.attachment))

        self.camera.look(asked, robot, deliver)
