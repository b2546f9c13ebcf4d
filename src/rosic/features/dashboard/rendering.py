"""What a card looks like now."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from math import ceil
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias

import msgspec

from rosic.contracts.messenger import Messenger, pictures_of
from rosic.core.i18n import Catalogue, joined
from rosic.core.identity import PrincipalId
from rosic.core.message import Button, Chat, ChatKind, Outbound, SendPriority
from rosic.core.order_status import Face
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import SECOND_NS
from rosic.errors import NothingToSee, Refusal
from rosic.features.dashboard import messages as words
from rosic.features.dashboard.dashboard import PreviewedCamera, PreviewViewer, pace_of
from rosic.gateway.delivery.translation import translated

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.contracts.clock import Clock
    from rosic.features.dashboard.dashboard import Dashboard, RobotSnapshots
    from rosic.gateway.chat_dashboards import CameraPreview
    from rosic.gateway.commands import CommandContext


# ---- camera preview ----

# The last picture on a card: asked for by a tap, shown in place, as old as the card says.
#
# No platform says whether somebody looks, so for a while after a tap they are taken to: so long
# the picture is renewed by itself, with edits of the card that may be made anyway.

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

    def show_picture(self, dashboard: Dashboard, picture: PreviewedCamera) -> None:
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

    def row(self, dashboard: Dashboard, robots: tuple[RobotId, ...]) -> tuple[Button, ...]:
        """Return the buttons that ask for a picture, bound to whose card it is."""
        offered = self._offered(dashboard, robots)
        now_ns = self._now_ns()
        if dashboard.offered != offered or now_ns > dashboard.offered_ns + RENEWED_NS:
            buttons = tuple(
                self._issue(
                    Button(
                        words.picture_button(robot if len(offered) > 1 else ""),
                        f"/card picture {robot}",
                    ),
                    dashboard.owner,
                    dashboard.chat.id,
                )
                for robot in offered
            )
            dashboard.offer(offered, buttons, now_ns)
        return dashboard.buttons

    def _offered(self, dashboard: Dashboard, robots: tuple[RobotId, ...]) -> tuple[RobotId, ...]:
        camera, shows = self._camera, pictures_of(dashboard.messenger)
        if camera is None or shows is None or dashboard.chat.kind is ChatKind.CHANNEL:
            return ()
        return tuple(robot for robot in robots if camera.offers(robot))[:BUTTONS_AT_MOST]

    def ask(self, asked: CommandContext, live: PreviewedDashboards, robot: RobotId) -> None:
        """Look at a robot for the card of this chat, which then shows it.

        Raises:
            Refusal: There is no such card, or nothing to see.
        """
        dashboard = live.of(asked.messenger, asked.inbound.chat)
        if dashboard is None:
            raise NothingToSee(words.NO_SUCH_CARD)
        if self._camera is None or robot not in self._offered(dashboard, (robot,)):
            raise NothingToSee(words.NO_PICTURE)
        dashboard.use_up_buttons()

        async def deliver(at_ns: int, outbound: Outbound) -> None:
            live.show_picture(dashboard, PreviewedCamera(robot, at_ns, outbound.attachment))

        self._camera.look(asked, robot, deliver)
        dashboard.watch(PreviewViewer(asked, robot, self._now_ns()))

    def renew(self, dashboard: Dashboard) -> None:
        """Look once more for whoever looks at a card, if it is time. Returns at once."""
        watched, now_ns = dashboard.watched, self._now_ns()
        if watched is None or self._camera is None:
            return
        if now_ns >= watched.until_ns:
            dashboard.look_away()
        elif (
            now_ns >= watched.next_ns
            and dashboard.picture is not None
            and not dashboard.pictured_anew
        ):
            watched.wait(now_ns)
            self._look_again(dashboard, watched, self._camera)

    def _look_again(
        self, dashboard: Dashboard, watched: PreviewViewer, camera: CameraPreview
    ) -> None:
        async def deliver(at_ns: int, outbound: Outbound) -> None:
            dashboard.renew_picture(
                watched, PreviewedCamera(watched.robot, at_ns, outbound.attachment)
            )

        with suppress(Refusal):  # the next time, then
            camera.look(watched.asked, watched.robot, deliver, unasked=True)

    def renewed_for_ns(self, dashboard: Dashboard) -> int:
        """Return for how long a card's picture is renewed by itself."""
        return (
            0 if dashboard.watched is None else max(0, dashboard.watched.until_ns - self._now_ns())
        )


# ---- rendering ----

ROBOTS_AT_MOST: Final = 12
"""More do not fit into one message of every messenger."""
LATE_S: Final = 5.0
CAPTION_UNITS: Final = 1_000
"""UTF-16 units that every messenger takes beneath a picture."""
BUTTON_BYTES: Final = 64
"""What a button carries on every messenger; a longer list of robots stops everything."""


class DashboardQueries(msgspec.Struct, frozen=True, kw_only=True):
    """What the rooms know that cards depend on.

    Attributes:
        sees: Returns the robots that somebody may see now; none for who is locked or has no key.
        reads: Whether a chat is still somebody's, by an account that they have.
        name_of: Returns how somebody is called.
        shown: Returns how people read a robot.
        face: Returns what a clock on the wall shows.
        tell: Says something in a chat.
        catalogue: Returns the texts in which somebody reads; None for English.
        issue: Binds a button to a person and a chat.
    """

    sees: Callable[[PrincipalId], frozenset[RobotId]]
    reads: Callable[[PrincipalId, Chat], bool]
    name_of: Callable[[PrincipalId], str]
    shown: Callable[[RobotId], str]
    face: Face
    tell: Callable[[Messenger, Chat, str], object]
    catalogue: Callable[[PrincipalId], Catalogue | None]
    issue: Callable[[Button, PrincipalId, str], Button]


class DashboardRendering:
    """Makes the newest look at robots into a message."""

    def __init__(
        self,
        snapshots: RobotSnapshots,
        sides: DashboardQueries,
        clock: Clock,
        camera: CameraPreview | None,
    ) -> None:
        self._snapshots = snapshots
        self._sides = sides
        self._clock = clock
        self.picturing = CameraPreviews(sides.issue, clock.monotonic_ns, camera)

    def shows(self, robots: Sequence[RobotId]) -> dict[RobotId, int]:
        """Return which look at which robots a card would show now."""
        return {robot: self._snapshots.number(robot) for robot in robots[:ROBOTS_AT_MOST]}

    def text(
        self,
        chat: Chat,
        owner: PrincipalId,
        robots: tuple[RobotId, ...],
        most: int = ROBOTS_AT_MOST,
    ) -> str:
        """Return how these robots are, at most so many of them."""
        lines: list[str] = []
        if chat.kind is ChatKind.CHANNEL:
            lines.append(words.for_reading())
        elif chat.kind is ChatKind.GROUP:
            lines.append(words.as_they_see(self._sides.name_of(owner)))
        named = chat.kind is not ChatKind.CHANNEL
        lines += [self._snapshots.text(robot, named=named) for robot in robots[:most]]
        if len(robots) > most:
            lines.append(words.and_more(len(robots) - most))
        return joined("\n", lines)

    def now(self, chat: Chat, owner: PrincipalId, robots: tuple[RobotId, ...]) -> str:
        """Return how these robots are at this moment, for a message that stays as it is."""
        stamp = words.as_of(self._sides.face(self._clock.wall_ns()))
        return joined("\n", (self.text(chat, owner, robots), stamp))

    def outbound(
        self, dashboard: Dashboard, robots: tuple[RobotId, ...], weight: SendPriority
    ) -> Outbound:
        """Return the message, stamped with the time at which it is so.

        Beneath a picture there is less room: then it is of fewer robots.
        """
        for most in range(ROBOTS_AT_MOST, 1, -1):
            outbound = self._outbound(dashboard, robots, weight, most)
            if dashboard.picture is None or _units(outbound.text) <= CAPTION_UNITS:
                return outbound
        return self._outbound(dashboard, robots, weight, 1)

    def _outbound(
        self, dashboard: Dashboard, robots: tuple[RobotId, ...], weight: SendPriority, most: int
    ) -> Outbound:
        now_ns, pace = self._clock.wall_ns(), pace_of(dashboard.chat)
        lag_s = ceil(dashboard.lag_s) if dashboard.lag_s >= LATE_S else 0
        next_ns = now_ns + int((pace.promise_s + lag_s) * 1e9)
        stamp = words.updated(self._sides.face(now_ns), self._sides.face(next_ns), lag_s)
        lines = [self.text(dashboard.chat, dashboard.owner, robots, most)]
        if (picture := dashboard.picture) is not None:
            left_ns = self.picturing.renewed_for_ns(dashboard)
            until = self._sides.face(now_ns + left_ns) if left_ns else ""
            lines.append(
                words.pictured(
                    self._sides.shown(picture.robot), self._sides.face(picture.at_ns), until
                )
            )
        view_buttons = self.picturing.row(dashboard, robots)
        stop = (_stop_button(robots if dashboard.robots else ()),)
        outbound = Outbound(
            chat=dashboard.chat,
            text=joined("\n", (*lines, stamp)),
            buttons=_rows(dashboard.chat, view_buttons, stop),
            weight=weight,
            attachment=None if picture is None else picture.content,
        )
        return translated(outbound, self._sides.catalogue(dashboard.owner))

    def last(self, dashboard: Dashboard) -> Outbound:
        """Return the message of a card that is over."""
        outbound = Outbound(chat=dashboard.chat, text=dashboard.last)
        return translated(outbound, self._sides.catalogue(dashboard.owner))


@lru_cache(maxsize=32)
def in_order(robots: frozenset[RobotId]) -> tuple[RobotId, ...]:
    """Return robots sorted; those that somebody sees are the same set at each look."""
    return tuple(sorted(robots))


def _rows(
    chat: Chat, view_buttons: tuple[Button, ...], stop: tuple[Button, ...]
) -> tuple[tuple[Button, ...], ...]:
    """Return the rows under a card; what is for reading has none."""
    if chat.kind is ChatKind.CHANNEL:
        return ()
    return (view_buttons, stop) if view_buttons else (stop,)


def _units(text: str) -> int:
    return len(text.encode("utf-16-le", "replace")) // 2


def _stop_button(named: tuple[RobotId, ...]) -> Button:
    """Return what stops all that is shown: it is never bound to anybody, nor used up."""
    command = " ".join(("stop", *named))
    if len(command.encode()) > BUTTON_BYTES:
        command = "stop"
    return Button("STOP", command, command)
