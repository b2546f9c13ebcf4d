"""The last picture on a card: asked for by a tap, shown in place, as old as the card says.

No platform says whether somebody looks, so for a while after a tap they are taken to: so long the
picture is renewed by itself, with edits of the card that may be made anyway.
"""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias

from rosic.contracts.messenger import pictures_of
from rosic.core.message import Button, ChatKind, Outbound
from rosic.core.time_units import SECOND_NS
from rosic.errors import NothingToSee, Refusal
from rosic.features.dashboard import messages as words
from rosic.features.dashboard.dashboard import PreviewedCamera, PreviewViewer

if TYPE_CHECKING:
    from collections.abc import Callable

    from rosic.contracts.messenger import Messenger
    from rosic.core.identity import PrincipalId
    from rosic.core.message import Chat
    from rosic.core.robot.profile import RobotId
    from rosic.features.dashboard.dashboard import Dashboard
    from rosic.gateway.chat_dashboards import CameraPreview
    from rosic.gateway.commands import CommandContext

Issue: TypeAlias = "Callable[[Button, PrincipalId, str], Button]"

BUTTONS_AT_MOST: Final = 3
"""So many robots of a card can be looked at by a tap; more buttons than robots help nobody."""
RENEWED_NS: Final = 20 * SECOND_NS
"""A button lives for a minute; a card that is edited after so long shows new ones."""


class PreviewedDashboards(Protocol):
    """The cards that chats have, as far as a picture needs them."""

    def of(self, messenger: Messenger, chat: Chat) -> Dashboard | None:
        """Return a chat's card."""
        ...

    def show_picture(self, card: Dashboard, picture: PreviewedCamera) -> None:
        """Show a picture with the next edit of a card."""
        ...


class CameraPreviews:
    """Puts the buttons under cards, and pictures on them.

    Args:
        camera: Looks; None: no card offers a picture.
    """

    def __init__(
        self, issue: Issue, now_ns: Callable[[], int], camera: CameraPreview | None
    ) -> None:
        self._camera = camera
        self._issue = issue
        self._now_ns = now_ns

    def row(self, card: Dashboard, robots: tuple[RobotId, ...]) -> tuple[Button, ...]:
        """Return the buttons that ask for a picture, bound to whose card it is."""
        offered = self._offered(card, robots)
        now_ns = self._now_ns()
        if card.offered != offered or now_ns > card.offered_ns + RENEWED_NS:
            card.offered, card.offered_ns = offered, now_ns
            card.buttons = tuple(
                self._issue(
                    Button(
                        words.picture_button(robot if len(offered) > 1 else ""),
                        f"/card picture {robot}",
                    ),
                    card.owner,
                    card.chat.id,
                )
                for robot in offered
            )
        return card.buttons

    def _offered(self, card: Dashboard, robots: tuple[RobotId, ...]) -> tuple[RobotId, ...]:
        camera, shows = self._camera, pictures_of(card.messenger)
        if camera is None or shows is None or card.chat.kind is ChatKind.CHANNEL:
            return ()
        return tuple(robot for robot in robots if camera.offers(robot))[:BUTTONS_AT_MOST]

    def ask(self, asked: CommandContext, live: PreviewedDashboards, robot: RobotId) -> None:
        """Look at a robot for the card of this chat, which then shows it.

        Raises:
            Refusal: There is no such card, or nothing to see.
        """
        card = live.of(asked.messenger, asked.inbound.chat)
        if card is None:
            raise NothingToSee(words.NO_SUCH_CARD)
        if self._camera is None or robot not in self._offered(card, (robot,)):
            raise NothingToSee(words.NO_PICTURE)
        card.offered = ()  # the one that was tapped is used up

        async def deliver(at_ns: int, outbound: Outbound) -> None:
            live.show_picture(card, PreviewedCamera(robot, at_ns, outbound.attachment))

        self._camera.look(asked, robot, deliver)
        card.watched = PreviewViewer(asked, robot, self._now_ns())

    def renew(self, card: Dashboard) -> None:
        """Look once more for whoever looks at a card, if it is time. Returns at once."""
        watched, now_ns = card.watched, self._now_ns()
        if watched is None or self._camera is None:
            return
        if now_ns >= watched.until_ns:
            card.watched = None
        elif now_ns >= watched.next_ns and card.picture is not None and not card.pictured_anew:
            watched.wait(now_ns)
            self._look_again(card, watched, self._camera)

    def _look_again(self, card: Dashboard, watched: PreviewViewer, camera: CameraPreview) -> None:
        async def deliver(at_ns: int, outbound: Outbound) -> None:
            if card.watched is watched and not card.last:
                card.picture = PreviewedCamera(watched.robot, at_ns, outbound.attachment)

        with suppress(Refusal):  # the next time, then
            camera.look(watched.asked, watched.robot, deliver, unasked=True)

    def renewed_for_ns(self, card: Dashboard) -> int:
        """Return for how long a card's picture is renewed by itself."""
        return 0 if card.watched is None else max(0, card.watched.until_ns - self._now_ns())
