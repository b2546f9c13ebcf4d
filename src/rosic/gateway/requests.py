"""What is too old to act on, in the words of the person who sent it (I2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from rosic.authoriser.button_tokens import OPEN
from rosic.core.i18n import said
from rosic.core.identity import command_id, robot_command_id
from rosic.core.language import places as places_of
from rosic.core.message import ChatKind
from rosic.core.order import Request
from rosic.core.time_units import HOUR_S, MINUTE_S, SECOND_NS
from rosic.errors import Expired

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.identity import CommandId
    from rosic.core.language import Do
    from rosic.core.message import Inbound
    from rosic.gateway.components import Components
    from rosic.gateway.message_context import MessageContext


# ---- what is too old to act on (I2) ----

FILE: Final = -1
"""In place of the number of a line: the file that came with the message."""
COMMAND_LIFETIME_NS: Final = 30 * SECOND_NS
MISSED: Final = said("You sent this while I could not listen. Nothing was done.")
NETWORK_AWAY: Final = said("You sent this while the network was away. Nothing was done.")


def check_fresh(inbound: Inbound, request: Request, now_ns: int) -> None:
    """Let a request pass that is young enough, and was sent while somebody listened.

    Args:
        inbound: The message it came in.
        request: Knows its deadline.
        now_ns: Monotonic clock.

    Raises:
        Expired: With the same command on offer.
    """
    lifetime_ns = request.skill.order_lifetime_ns
    if now_ns > request.deadline_ns:
        total_ns = now_ns - (request.deadline_ns - lifetime_ns)
        raise Expired(too_old(inbound, total_ns, lifetime_ns), offers=(request.text,))
    if request.skill.actuates and inbound.sent_ns < inbound.listening_since_ns:
        raise Expired(_missed(inbound), offers=(request.text,))


def check_command_fresh(inbound: Inbound, again: str) -> None:
    """Let a command pass that robots move because of, if it was sent just now (I2).

    It also keeps a message that is brought once more after a crash from counting twice (I1): it was
    sent before anybody listened.

    Args:
        inbound: The message it came in.
        again: The same command, as it would be typed.

    Raises:
        Expired: With the same command on offer.
    """
    check_heard_in_time(inbound, COMMAND_LIFETIME_NS, again)


def check_heard_in_time(inbound: Inbound, lifetime_ns: int, again: str) -> None:
    """Let a message pass that took no longer to get here, and was sent while somebody listened.

    Raises:
        Expired: With the same on offer.
    """
    age_ns = inbound.received_ns - inbound.sent_ns
    if age_ns > lifetime_ns:
        raise Expired(too_old(inbound, age_ns, lifetime_ns), offers=(again,))
    if is_missed(inbound):
        raise Expired(_missed(inbound), offers=(again,))


def is_missed(inbound: Inbound) -> bool:
    """Whether it was sent while nobody listened."""
    return inbound.sent_ns < inbound.listening_since_ns


def _missed(inbound: Inbound) -> str:
    return NETWORK_AWAY if inbound.network_away else MISSED


def too_old(inbound: Inbound, age_ns: int, lifetime_ns: int) -> str:
    """Return how old a command is, and where it was meanwhile, as far as is known here.

    Args:
        inbound: The message it came in.
        age_ns: Now, since it was sent.
        lifetime_ns: For how long it would have been good.
    """
    if is_missed(inbound) and inbound.network_away:
        return said(
            "Your command is {age} old (the network was away). Nothing was done.", age=age(age_ns)
        )
    if is_missed(inbound):
        return said(
            "Your command is {age} old: you sent it while I could not listen. Nothing was done.",
            age=age(age_ns),
        )
    if inbound.received_ns - inbound.sent_ns > lifetime_ns:
        return said(
            "Your command is {age} old: it reached me late. Nothing was done.", age=age(age_ns)
        )
    return said(
        "Your command is {age} old: it waited here behind others. Nothing was done.",
        age=age(age_ns),
    )


def age(age_ns: int) -> str:
    """Return an age as people say it."""
    seconds = age_ns / 1e9
    if seconds < 2 * MINUTE_S:
        return said("{seconds:.0f} seconds", seconds=seconds)
    if seconds < 2 * HOUR_S:
        return said("{seconds:.0f} minutes", seconds=seconds / MINUTE_S)
    return said("{seconds:.0f} hours", seconds=seconds / HOUR_S)


class RequestFactory:
    """Makes requests of lines."""

    def __init__(self, rooms: Components, clock: Clock) -> None:
        self._stops = rooms.stops
        self._profiles = rooms.profiles
        self._clock = clock

    def requests(
        self, message: MessageContext, line: Do, cid: CommandId, now_ns: int
    ) -> list[Request]:
        """Return what the line asks of each robot, as long as it is fresh."""
        inbound = message.inbound
        received_ns = inbound.received_ns
        sent_ns, arrived_ns = inbound.sent_ns, message.arrived_ns
        age_ns = received_ns - sent_ns
        if age_ns < 0:
            sent_ns, age_ns = received_ns, 0
        wall_ns = self._clock.wall_ns()
        waited_ns = wall_ns - received_ns
        # Whichever clock says that it is older: the wall clock may have been set back meanwhile.
        asked_ns = (now_ns - waited_ns if waited_ns > now_ns - arrived_ns else arrived_ns) - age_ns
        requests: list[Request] = []
        for robot, skill in zip(line.robots, line.skills, strict=True):
            request = Request(
                # The first carries the line's own id: understood anew, it is found all the same.
                robot_command_id(cid, robot) if requests else cid,
                robot,
                skill,
                line.spoken,
                line.text,
                sent_ns,
                age_ns,
                asked_ns + skill.order_lifetime_ns,
                wall_ns + (asked_ns - now_ns) + skill.order_lifetime_ns,
                line.group,
                robot in message.asked,
                inbound.live,
            )
            if now_ns > request.deadline_ns or sent_ns < inbound.listening_since_ns:
                check_fresh(inbound, request, now_ns)
            if received_ns <= self._stops[robot].at_ns:
                self._check_later_than_stop(inbound, request)
            requests.append(request)
        return requests

    def _check_later_than_stop(self, inbound: Inbound, request: Request) -> None:
        """Refuse motion received before its robot's last stop, wherever it waited since (I5).

        What one answer of a platform brings has one time of receiving, and stops go first: it may
        have been sent after that stop, which is not said to be later.
        """
        stopped = self._stops[request.robot]
        if inbound.received_ns <= stopped.at_ns and not stopped.latched and request.skill.actuates:
            shown = self._profiles[request.robot].shown
            sentence = said(
                "{shown} was stopped and resumed before I came to this. Nothing was done.",
                shown=shown,
            )
            raise Expired(sentence, offers=(request.text,))


def line_id(inbound: Inbound, number: int) -> CommandId:
    """Return the identity of one line of a message, or of what a tap says, for ever.

    A button that is nobody's may be tapped again, so what counts is the tap. Two bots of one
    gateway count the messages of the same person alike, so the number of one of these says nothing
    without the bot. Where all who are in a chat share its numbers, or something else of the
    message, a message that both bots hear is one.

    Args:
        inbound: The message.
        number: Of the line, from 0; or `FILE`, for the file that came with it.
    """
    nonce = inbound.nonce
    if nonce is not None and not nonce.startswith(OPEN):  # in a group, several may tap the same one
        sender = inbound.sender
        return command_id("tap", nonce, sender.platform, sender.account, str(number))
    if inbound.written and number != FILE:
        # A line has the same place to a bot that another line is addressed to.
        places = places_of(inbound.text, inbound.written)
        number = places[number] if number < len(places) else number
    sender, chat, part = inbound.sender, inbound.chat, "file" if number == FILE else str(number)
    if inbound.shared:
        return command_id(sender.platform, "in", chat.id, sender.account, inbound.shared, part)
    if inbound.account:
        return command_id(sender.platform, "to", inbound.account, chat.id, inbound.message, part)
    return command_id(sender.platform, sender.account, chat.id, inbound.message, part)


def is_said_to_us(inbound: Inbound) -> bool:
    """Whether something was said to us, and not perhaps to others in a group."""
    return (
        inbound.chat.kind is ChatKind.PRIVATE
        or inbound.nonce is not None
        or inbound.addressed
        or inbound.text.startswith("/")
    )
