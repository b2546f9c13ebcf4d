"""What robots say to each other through ROSIC, as JSON: read strictly, bounded, never believed.

Who speaks is never read from the words: it is the robot on whose link they came.
``docs/schema/among.schema.json`` is made from the types here.
"""

from __future__ import annotations

import re
from typing import Annotated, Final, TypeAlias

import msgspec

from rosic.core.i18n import said
from rosic.core.robot.profile import RobotId
from rosic.core.time_units import DAY_S
from rosic.errors import NotUnderstood, OutOfBounds

DATA_BYTES: Final = 16_384
TOPICS_A_ROBOT: Final = 32
ROBOT_BYTES: Final = 131_072
KEPT_AT_MOST_S: Final = 7.0 * DAY_S
KEPT_S: Final = float(DAY_S)
HELP_FOR_S: Final = 600.0
HELP_AT_MOST_S: Final = float(DAY_S)

_NAME = r"^[a-z][a-z0-9_]{0,31}$"
Name: TypeAlias = Annotated[str, msgspec.Meta(pattern=_NAME)]
MaybeName: TypeAlias = Annotated[str, msgspec.Meta(pattern=r"^([a-z][a-z0-9_]{0,31})?$")]
Mark: TypeAlias = Annotated[str, msgspec.Meta(max_length=64)]
Text: TypeAlias = Annotated[str, msgspec.Meta(min_length=1, max_length=200)]
Value: TypeAlias = float | str


class _Said(
    msgspec.Struct, frozen=True, kw_only=True, tag_field="kind", forbid_unknown_fields=True
):
    """What all utterances have.

    Attributes:
        ref: The speaker's own mark; with one, it is answered also when all is well.
    """

    ref: Mark = ""


class Share(_Said, frozen=True, kw_only=True, tag="share"):
    """Share data with whoever may read the robot. It replaces what the topic held.

    Attributes:
        data: Any JSON value.
        keep_s: It is forgotten when it is older than this.
        re: Id of what was heard, if it is shared because of that.
    """

    topic: Name
    data: msgspec.Raw
    keep_s: Annotated[float, msgspec.Meta(gt=0, le=KEPT_AT_MOST_S)] = KEPT_S
    re: Mark = ""


class Get(_Said, frozen=True, kw_only=True, tag="get"):
    """Ask for what a robot shares: one topic, or the newest of all."""

    robot: Name
    topic: MaybeName = ""


class Follow(_Said, frozen=True, kw_only=True, tag="follow"):
    """Hear whatever a robot shares from now on: one topic, or all. Kept over a restart."""

    robot: Name
    topic: MaybeName = ""


class Unfollow(_Said, frozen=True, kw_only=True, tag="unfollow"):
    """Hear it no more."""

    robot: Name
    topic: MaybeName = ""


class AskForHelp(_Said, frozen=True, kw_only=True, tag="help"):
    """Ask for help: whoever may help hears of it, robots and people.

    Attributes:
        what: ``stuck at aisle 4``.
        for_s: Nobody can accept it later.
    """

    what: Text
    for_s: Annotated[float, msgspec.Meta(gt=0, le=HELP_AT_MOST_S)] = HELP_FOR_S


class Accept(_Said, frozen=True, kw_only=True, tag="accept"):
    """Accept a request for help; the first who does has it."""

    id: Mark


class Over(_Said, frozen=True, kw_only=True, tag="over"):
    """The help was given, or is not needed any more."""

    id: Mark


class TellRobot(_Said, frozen=True, kw_only=True, tag="tell"):
    """Say something to one robot.

    Attributes:
        re: Id of what was heard, if this answers it.
    """

    to: Name
    data: msgspec.Raw
    re: Mark = ""


class Adjust(_Said, frozen=True, kw_only=True, tag="adjust"):
    """Change another robot's strategy.

    Attributes:
        strategy: One that its profile declares; ``back`` for the one before.
        values: Of the strategy's parameters, in the units of the profile.
        when: ``now``, or ``idle``: when it carries out nothing.
    """

    robot: Name
    strategy: Name
    values: dict[str, Value] = {}
    when: Annotated[str, msgspec.Meta(pattern="^(now|idle)$")] = "idle"


class Acknowledge(_Said, frozen=True, kw_only=True, tag="ack"):
    """The robot has taken on a strategy, or has not."""

    id: Mark
    ok: bool
    why: Annotated[str, msgspec.Meta(max_length=200)] = ""


Utterance: TypeAlias = (
    Share | Get | Follow | Unfollow | AskForHelp | Accept | Over | TellRobot | Adjust | Acknowledge
)


class _Marked(msgspec.Struct, frozen=True):
    ref: Mark = ""


_decode = msgspec.json.Decoder(Utterance).decode
_decode_mark = msgspec.json.Decoder(_Marked).decode
# Of what is too long nothing but its beginning is looked at.
_BEGINS = re.compile(rb'\{\s?"kind"\s?:\s?"[a-z]{1,16}"\s?,\s?"ref"\s?:\s?"([ -!#-[\]-~]{1,64})"')
_value = msgspec.json.Decoder().decode


def read_utterance(words: bytes, at_most: int) -> Utterance:
    """Read what a robot says.

    Raises:
        OutOfBounds: Too long; it was not looked into.
        NotUnderstood: It is not of the published form.
    """
    if len(words) > at_most:
        raise OutOfBounds(too_long(at_most))
    try:
        found: Utterance = _decode(words)
        if isinstance(found, Share | TellRobot):
            _value(found.data)  # a value that is only skipped over is not checked
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError) as wrong:
        raise NotUnderstood(
            said("That is not of the published form: {what}.", what=str(wrong)[:200])
        ) from None
    if isinstance(found, Share | TellRobot) and len(bytes(found.data)) > DATA_BYTES:
        raise OutOfBounds(too_long(DATA_BYTES))
    return found


def mark_of(words: bytes) -> str:
    """Return the speaker's mark of what could not be read, so that the answer can be told.

    Of what is no JSON, or too long to be read, it is found if it stands at the beginning: ``kind``,
    then ``ref``. Empty: there is none.
    """
    if (begins := _BEGINS.match(words)) is not None:
        return begins[1].decode()
    try:
        return _decode_mark(words).ref if len(words) <= DATA_BYTES else ""
    except (msgspec.MsgspecError, RecursionError, UnicodeDecodeError):
        return ""


def too_long(at_most: int) -> str:
    """Return that something is too large."""
    return said(
        "That is too large: at most {kib} KiB are taken at once. Nothing of it was kept.",
        kib=at_most // 1024,
    )


class Shared(msgspec.Struct, frozen=True):
    """The newest that a robot has shared on a topic.

    Attributes:
        at_ns: When ROSIC heard it, wall clock.
        until_ns: When it is forgotten.
        data: JSON.
        id: Whoever shares or says something because of it names this.
        hops: How many others' words led to it.
    """

    robot: RobotId
    topic: str
    at_ns: int
    until_ns: int
    data: bytes
    id: str
    hops: int
