"""Every error ROSIC raises, sorted by who has to act.

RosicError
|-- Refusal                the person: may not, or not now. Expected; no traceback; never retried
|   |-- Unrecognised       authoriser: a stranger, or a key that is revoked or expired
|   |-- Unverified         pipeline: nobody can be sure who sent it, so it may look, and no more
|   |-- NotUnderstood      container: the words do not say what to do
|   |-- OutOfBounds        container: understood, but outside what the robot allows
|   |-- NotPermitted       organiser: no role gives this right
|   |-- FirstNeeded        organiser: may, once it was confirmed, proven or agreed to
|   |-- TakeOver           organiser: may, once whoever has the robot has given way
|   |-- TooManyRequests    organiser: wait, then ask again
|   |-- RobotTaken         organiser: somebody else has this robot now
|   |-- RobotBusy          linker: the robot is doing something else
|   |-- RobotStopped       linker: stopped, until somebody who may resumes it
|   |   `-- RobotMoving    linker: not resumed, as it moves though it was told to stop
|   |-- RobotOffline       linker: the robot is not there
|   |-- TimeInDoubt        organiser: the computer's clock was set back; its owner has to look
|   |-- NothingToSee       robot or painter: there is no picture of this, or not now
|   |-- NotFound           API: there is nothing of that name, as far as one may know
|   |-- Expired            anywhere: too old to act on
|   |-- Inert              pipeline: edited, forwarded or not from a person; nothing is said
|   |-- Repeated           store: this very message was settled before; nothing is said
|   |-- RecordUnavailable  store: what cannot be written down does not move a robot
|   `-- OrderVoid          robot: too late, out of order, or given under an old lease or stop
|-- Fault                  the operator: something broke. Logged with its cause
|   |-- RobotUnreachable   robot adapter: no answer in time; it may or may not have moved
|   |   `-- StillMoves     robot adapter: told to stop, and measured to move all the same
|   |-- MessengerFault     messenger adapter: the platform did not take the message
|   |   |-- MessageGone    messenger adapter: there is no such message to change any more
|   |   `-- ChatGone       messenger adapter: nobody can be spoken to there any more
|   |       `-- ChatNotBegun  messenger adapter: nor yet, as nobody there has written to us
|   `-- StoreFault         store: the record could not be written
`-- ConfigurationError     the operator, before anything starts

``str(error)`` is the sentence a person may read in a chat: no identifiers they did not type,
no host names, no traces. ``code`` never changes; tests, logs and docs use it.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, ClassVar, Final, Self

if TYPE_CHECKING:
    from collections.abc import Mapping


def how_to_install(extra: str) -> str:
    """Return the line that installs an optional part, for an installed ROSIC and for a checkout."""
    return f"pip install 'rosic[{extra}]' (in a checkout: .venv/bin/pip install -e '.[{extra}]')"


class RosicError(Exception):
    """The root. Never raised itself.

    Attributes:
        code: Stable, for logs and tests.
    """

    code: ClassVar[str] = "rosic"

    @property
    def sentence(self) -> str:
        """What a person may read. Unlike ``str(error)`` it can be said in another language."""
        return self.args[0] if self.args else ""


class Refusal(RosicError):
    """The person may not, or not now. No robot has moved because of this request.

    Attributes:
        offers: Commands, written as the person would type them, that would be accepted instead.
        access_request: The command that asks somebody else for the right that is missing; empty
            when nobody could give it.
        choices: What else can be tapped: a label, and what it says as if typed; or the sign with
            which the same command is done in another way.
        silent: True when the right answer is none.
        counted: True when it is in the security report already, as what it was.
        retry_after_s: Seconds until the same may be admitted; None: time alone changes nothing.
    """

    code: ClassVar[str] = "refused"
    silent: bool = False
    counted: bool = False
    retry_after_s: float | None = None

    def __init__(
        self,
        sentence: str,
        *,
        offers: tuple[str, ...] = (),
        access_request: str = "",
        choices: tuple[tuple[str, str], ...] = (),
    ) -> None:
        super().__init__(sentence)
        self.offers = offers
        self.choices = choices
        self.access_request = access_request

    def reworded(self, sentence: str) -> Self:
        """Say something else: what was done before it came to this stands in front of why not."""
        self.args = (sentence, *self.args[1:])
        return self

    def offering(self, offers: tuple[str, ...]) -> Self:
        """Offer other commands: whoever refused did not know all that would be accepted instead."""
        self.offers = offers
        return self

    def reported(self) -> Self:
        """Note that it is in the security report: nobody counts it again."""
        self.counted = True
        return self


class Unrecognised(Refusal):
    """A stranger, or a key that is revoked or has expired. Nothing about robots is disclosed."""

    code = "unrecognised"


class Unverified(Refusal):
    """Nobody can be sure who sent it: it may look and stop. Nothing else of it was done (I17)."""

    code = "unverified"


class NotUnderstood(Refusal):
    """The words do not say what to do. ``offers`` holds what may have been meant."""

    code = "not-understood"


class OutOfBounds(Refusal):
    """Understood, but outside the bounds of the skill. ``offers`` holds the bound."""

    code = "out-of-bounds"


class NotPermitted(Refusal):
    """No role of this person gives the right."""

    code = "not-permitted"


class FirstNeeded(Refusal):
    """They may, once something else has happened. Nothing was done.

    Attributes:
        need: ``confirmation``, ``step-up`` or ``second person``.
        robot: Of which robot.
        text: The command, to be given again then.
        arguments: What it means, SI.
        overheard: It may have been meant for somebody else in the chat.
    """

    code = "first-needed"

    def __init__(
        self,
        sentence: str,
        *,
        need: str,
        robot: str,
        text: str,
        arguments: Mapping[str, float | int | str] | None = None,
        overheard: bool = False,
    ) -> None:
        super().__init__(sentence)
        self.need = need
        self.robot = robot
        self.text = text
        self.arguments = arguments
        self.overheard = overheard


class TakeOver(Refusal):
    """They may, once whoever has the robot has given way. Nothing was done.

    Attributes:
        robot: Which.
        others: Ids of those who have it, or whose time it is.
    """

    code = "take-over"

    def __init__(
        self, sentence: str, *, offers: tuple[str, ...], robot: str, others: tuple[str, ...]
    ) -> None:
        super().__init__(sentence, offers=offers)
        self.robot = robot
        self.others = others


class TooManyRequests(Refusal):
    """The bucket is empty.

    Attributes:
        retry_after_s: Seconds until one request would be admitted; 0: no time is known.
        own: It is the person's own limit; others' are no misuse.
    """

    code = "too-many-requests"
    retry_after_s: float

    def __init__(self, sentence: str, *, retry_after_s: float, own: bool = True) -> None:
        super().__init__(sentence)
        self.retry_after_s = retry_after_s
        self.own = own


class RobotTaken(Refusal):
    """Somebody else holds the robot."""

    code = "robot-taken"


class RobotBusy(Refusal):
    """The robot is doing something else, and its profile does not queue."""

    code = "robot-busy"


class RobotStopped(Refusal):
    """The robot is stopped and stays so until an explicit, permitted resume."""

    code = "robot-stopped"


class RobotMoving(RobotStopped):
    """It is not resumed: it was told to stop, and moves all the same."""

    code = "still-moves"


class RobotOffline(Refusal):
    """The robot is not there, or does not answer; it was given no order."""

    code = "robot-offline"


class TimeInDoubt(Refusal):
    """The clock of the computer was set back: nothing new moves until its owner has looked."""

    code = "time-in-doubt"


class NothingToSee(Refusal):
    """There is no picture of this, none came in time, or it cannot be drawn."""

    code = "nothing-to-see"


class NotFound(Refusal):
    """There is nothing of that name, as far as whoever asks may know. Nothing was done."""

    code = "not-found"


class Expired(Refusal):
    """Too old to act on. Nothing was done."""

    code = "expired"


class Inert(Refusal):
    """Edited, forwarded, via a bot, from a channel or an anonymous admin: changes nothing (I17)."""

    code = "inert"
    silent = True


class Repeated(Refusal):
    """This very message was settled before (I1). Saying so again would be a second answer."""

    code = "repeated"
    silent = True


class RecordUnavailable(Refusal):
    """The decision could not be written down, so nothing moved (I9). A stop still works."""

    code = "record-unavailable"


class OrderVoid(Refusal):
    """The robot side declined: expired, stale, fenced or stopped. The robot has not moved."""

    code = "order-void"


class Fault(RosicError):
    """Something broke. The operator acts; the cause is chained and logged."""

    code: ClassVar[str] = "fault"


class RobotUnreachable(Fault):
    """No answer in time. The robot may or may not have moved."""

    code = "robot-unreachable"


class StillMoves(RobotUnreachable):
    """It was told to stop, and was measured to move all the same. It may come to rest yet."""

    code = "still-moves"


class MessengerFault(Fault):
    """The platform did not take the message. What was to be told is still in the record.

    Attributes:
        perhaps_sent: It may have arrived all the same: nobody can know.
    """

    code = "messenger-fault"
    perhaps_sent = False


class MessageGone(MessengerFault):
    """The message to change does not exist any more, or is too old to change. Nothing changed."""

    code = "message-gone"


class ChatGone(MessengerFault):
    """We were put out of the chat, or blocked. Nothing was said, and no second try would help.

    It ends when somebody there speaks to us, or lets us in again.
    """

    code = "chat-gone"


class ChatNotBegun(ChatGone):
    """Nobody there has written to us yet, and a bot may not be the first. Nothing was said."""

    code = "chat-not-begun"


class StoreFault(Fault):
    """The record could not be written. Nothing that depended on it has been done."""

    code = "store-fault"


_BOT_TOKEN: Final = re.compile(r"(?<!\d)\d{5,20}:[A-Za-z0-9_-]{16,}")


class ConfigurationError(RosicError):
    """A file or a setting is wrong. Nothing has been started.

    What looks like a bot's token is shown as ``***``, wherever it was written: people write it
    where the name of a variable or of a file belongs, and sentences repeat what was written.

    Attributes:
        where: File and line, when known: ``robots/omni.yaml:12``.
        hint: What to do about it.
    """

    code: ClassVar[str] = "configuration"

    def __init__(self, sentence: str, *, where: str = "", hint: str = "") -> None:
        parts = [f"{where}: {sentence}" if where else sentence]
        if hint:
            parts.append(hint)
        super().__init__(_BOT_TOKEN.sub("***", " ".join(parts)))
        self.where = _BOT_TOKEN.sub("***", where)
        self.hint = _BOT_TOKEN.sub("***", hint)
