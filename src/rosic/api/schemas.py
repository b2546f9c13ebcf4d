"""What is sent and received, as OpenAPI has it. Times are RFC 3339, UTC; units are in names."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any, Final

import msgspec

from rosic.core.time_units import SECOND_NS

NAME_MOST: Final = 64
ROBOTS_MOST: Final = 1_000
WAIT_MOST_S: Final = 60
Name = Annotated[str, msgspec.Meta(min_length=1, max_length=NAME_MOST)]
Line = Annotated[str, msgspec.Meta(min_length=1, max_length=4_096)]
Wait = Annotated[float, msgspec.Meta(ge=0, le=WAIT_MOST_S)]


class IdentityOut(msgspec.Struct, frozen=True):
    """Whoever asks.

    Attributes:
        kind: ``person`` or ``program``.
        language: Code of the language in which they are told things.
    """

    id: str
    name: str
    kind: str
    roles: tuple[str, ...]
    language: str


class PoseOut(msgspec.Struct, frozen=True):
    """Where something is: metres and radians, in a frame of the robot's."""

    x_m: float
    y_m: float
    z_m: float
    yaw_rad: float | None
    frame: str


class PresenceOut(msgspec.Struct, frozen=True):
    """What a robot's side last said of itself.

    Attributes:
        online: None: its link cannot tell.
        age_s: Since it was last heard; None: never.
        doing: Skill that it carries out; empty: none.
        at_rest: None: not measured.
        values: Newest telemetry, in the units of the profile.
        ages_s: Since each of them was heard; one that is not named is of now.
        late: It counts as there, and has been silent for longer than a link that stands is.
    """

    online: bool | None
    age_s: float | None
    doing: str
    at_rest: bool | None
    values: dict[str, float | str]
    ages_s: dict[str, float]
    pose: PoseOut | None
    late: bool = False


class RobotOut(msgspec.Struct, frozen=True):
    """A robot.

    Attributes:
        stopped: It is stopped, until somebody who may resumes it.
        holder: Name of whoever has it now; empty: nobody.
        views: What can be looked at: ``picture``, ``map``.
        units: Of its telemetry, by name.
        watchdog_s: After so long without a velocity it comes to rest by itself; None: it takes
            none.
        words: What its skills and what it measures are called in the language of whoever asks, by
            name. Events leave it out: it does not change.
    """

    id: str
    name: str
    groups: tuple[str, ...]
    skills: tuple[str, ...]
    stopped: bool
    holder: str
    presence: PresenceOut
    views: tuple[str, ...]
    units: dict[str, str]
    watchdog_s: float | None
    words: dict[str, str] = {}


class SkillOut(msgspec.Struct, frozen=True):
    """A skill that whoever asks may ask for.

    Attributes:
        class_: Decides lifetime, lease and limits: ``motion``, ``observe`` ...
        asks: Somebody is asked before it is done.
        streams: It is a velocity, which may be driven live.
        arguments: JSON Schema of the arguments, in their declared units.
        units: Of the arguments, by name.
        titles: Of the arguments, by name, in the language of whoever asks.
        words: The choices among them in that language, by choice.
    """

    id: str
    name: str
    icon: str
    class_: str = msgspec.field(name="class")
    asks: bool
    streams: bool
    arguments: dict[str, Any]
    units: dict[str, str]
    titles: dict[str, str] = {}
    words: dict[str, str] = {}


class OrderIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """An order to one robot.

    Attributes:
        arguments: By name, in the declared units of the skill.
        wait_s: Waits so long for its end before answering.
    """

    skill: Name
    arguments: dict[str, float | str] = {}
    wait_s: Wait = 0.0


class StageOut(msgspec.Struct, frozen=True):
    """When an order came to a stage."""

    stage: str
    at: str


class OrderOut(msgspec.Struct, frozen=True):
    """An order and what became of it.

    Attributes:
        id: The same for ever, whoever is asked first.
        state: ``asked`` while somebody is, then its newest stage, then how it ended: ``done``,
            ``failed``, ``cancelled``, ``sent``, ``unknown``, ``refused``.
        who: Name of whoever gave it.
        sent: What was sent to the robot, as people read it.
        arguments: In the declared units of the skill, as a request takes them, with what was left
            out there; of an order of an earlier run, of another's, or of a skill that there is not
            any more, none.
        stages: Each once. ``received`` and later are said by the robot's side only.
        fraction: How far its robot says it is, in [0, 1].
        text: What is asked, or why it was refused; empty otherwise, and for others.
    """

    id: str
    robot: str
    skill: str
    state: str
    over: bool
    who: str = ""
    n: int = 0
    sent: str = ""
    arguments: dict[str, float | int | str] = {}
    stages: tuple[StageOut, ...] = ()
    fraction: float | None = None
    note: str = ""
    code: str = ""
    ended: str | None = None
    text: str = ""


class CheckOut(msgspec.Struct, frozen=True):
    """What an order would come to; nothing was done.

    Attributes:
        allowed: It would be done now.
        needs: What would have to come first: ``confirmation``, ``second person``, ``step-up``.
        arguments: In the declared units of the skill, as a request takes them, with what was left
            out.
    """

    allowed: bool
    sent: str
    arguments: dict[str, float | int | str]
    needs: tuple[str, ...] = ()


class StopIn(msgspec.Struct, frozen=True):
    """Which robots to stop; left out, or not to be read: all that one may see."""

    robots: Annotated[tuple[Name, ...], msgspec.Meta(max_length=ROBOTS_MOST)] = ()
    wait_s: Wait = 15.0


class StopOut(msgspec.Struct, frozen=True):
    """What became of a stop.

    Attributes:
        at_rest: All of them were measured at rest. None: it is not known yet.
        text: What the chat says.
    """

    at_rest: bool | None
    text: str


class ChatIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What would be typed in a chat, or tapped.

    Attributes:
        text: Lines; or empty for a tap.
        message: Id of the message whose button is tapped.
        button: What the button carries.
        wait_s: Waits so long for the first answer.
    """

    text: Annotated[str, msgspec.Meta(max_length=4_096)] = ""
    message: Annotated[str, msgspec.Meta(max_length=64)] = ""
    button: Annotated[str, msgspec.Meta(max_length=128)] = ""
    wait_s: Wait = 10.0


class AnswerOut(msgspec.Struct, frozen=True):
    """What was answered.

    Attributes:
        state: ``final``, ``goes-on``, ``asked``, ``agreed``, ``done``, ``not-done``.
        retry_after_s: Seconds until saying it again may succeed, where a limit was met.
    """

    text: str
    state: str
    code: str = ""
    besides: tuple[str, ...] = ()
    retry_after_s: float | None = None


class PageButton(msgspec.Struct, frozen=True):
    """A button under a message: what is read on it, and what tapping it sends back."""

    label: str
    nonce: str


class PageFile(msgspec.Struct, frozen=True):
    """A file that came with a message."""

    id: str
    name: str
    media_type: str
    size: int


class PageMessage(msgspec.Struct, frozen=True):
    """One message of a conversation on the page.

    Attributes:
        sent_ns: Wall clock.
        own: The person wrote it.
        state: What an answer comes to; see `core.message.AnswerState`.
        changed: How often it was edited.
    """

    id: str
    sent_ns: int
    text: str
    own: bool = False
    buttons: tuple[tuple[PageButton, ...], ...] = ()
    state: str = "final"
    code: str = ""
    reply_to: str = ""
    file: PageFile | None = None
    changed: int = 0
    pinned: bool = False


class SignIn(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A code from one's own chat."""

    code: Annotated[str, msgspec.Meta(min_length=1, max_length=64)]


class Problem(msgspec.Struct, frozen=True, omit_defaults=True):
    """Why something was not done.

    Attributes:
        type: A reference to what this kind of problem is: ``/problems/robot-busy``.
        title: The same for all problems of a kind.
        status: Of HTTP.
        detail: The sentence that the chat would say, in the language of whoever asks.
        code: Stable name of the kind: ``robot-busy``.
        offers: Lines that would be accepted instead.
        retry_after_s: Seconds until trying again may succeed.
    """

    type: str
    title: str
    status: int
    detail: str
    code: str
    offers: tuple[str, ...] = ()
    retry_after_s: float | None = None


def moment(at_ns: int) -> str:
    """Return a wall clock time as RFC 3339 in UTC, to the millisecond."""
    whole = datetime.fromtimestamp(at_ns // SECOND_NS, UTC)
    millis = at_ns % SECOND_NS // 1_000_000
    return f"{whole:%Y-%m-%dT%H:%M:%S}.{millis:03d}Z"
