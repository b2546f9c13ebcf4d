"""Made-up records, each with one line: Ada and a robot named omni, unless said otherwise."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, Any

from rosic.core.identity import AuthorisationKey, CommandId, command_id
from rosic.core.order import Order, Permit
from rosic.core.records import (
    Claimed,
    Concluded,
    Decided,
    Enrolled,
    Fact,
    Letter,
    Placed,
    Refused,
    Resumed,
    Selected,
    Stopped,
    Told,
)
from rosic.core.time_units import SECOND_NS

if TYPE_CHECKING:
    from rosic.contracts.clock import Clock
    from rosic.core.robot.profile import Profile
    from rosic.core.robot.skill import Argument


# ---- records ----

ADA, OMNI, KUKA = "p-ada", "omni", "kuka1"
AWKWARD = b"  \x00\xff 50 cm links \xf0\x9f\xa4\x96 ' -- \n" + bytes(range(256)) * 16 + b" \n"


def an_id(name: object) -> CommandId:
    """Return the identity of a made-up message."""
    return command_id("test", str(name))


def a_claim(name: object, **changes: Any) -> Claimed:  # noqa: ANN401  fields of Claimed
    """Return a claim on omni by Ada; any field can be given another value."""
    fields: dict[str, Any] = {
        "cid": an_id(name),
        "principal": ADA,
        "key": "k-ada",
        "robot": OMNI,
        "skill": "move",
        "n": 1,
        "fence": 1,
        "new_fence": False,
        "stop_generation": 0,
        "epoch": 1,
        "digest": b"digest",
        "accepted_ns": 1_000,
        "expires_ns": 6_000,
        "letter": Letter(ADA, b"chat 7"),
    }
    return Claimed(**(fields | changes))


def a_refusal(name: object, letter: Letter | None = None) -> Refused:
    """Return a refusal to Ada."""
    return Refused(cid=an_id(name), principal=ADA, code="robot-taken", at_ns=1_000, letter=letter)


def a_conclusion(name: object, ending: str = "done", words: bytes | None = b"moved") -> Concluded:
    """Return the end of Ada's command."""
    letter = None if words is None else Letter(ADA, words)
    return Concluded(cid=an_id(name), ending=ending, at_ns=2_000, letter=letter)


def a_place(name: object, message: bytes) -> Placed:
    """Return where the life of Ada's command is shown."""
    return Placed(cid=an_id(name), letter=Letter(ADA, message))


def told(name: object) -> Told:
    """Return that Ada knows."""
    return Told(cid=an_id(name), at_ns=3_000)


def a_stop(generation: int) -> Stopped:
    """Return a stop of omni."""
    return Stopped(robot=OMNI, generation=generation, principal=ADA, at_ns=1_000)


def a_resumption(name: object, generation: int = 1) -> Resumed:
    """Return that omni may move again."""
    return Resumed(cid=an_id(name), robot=OMNI, generation=generation, principal=ADA, at_ns=1_000)


def a_choice(robot: str, chat: bytes = b"chat") -> Selected:
    """Return that Ada chose a robot."""
    return Selected(principal=ADA, chat=chat, robot=robot)


def a_key(name: str = "k-ada") -> AuthorisationKey:
    """Return a key of Ada's."""
    return AuthorisationKey(
        id=name, principal=ADA, issuer="owner", issued_ns=5, scopes=("omni:*",), expires_ns=9_000
    )


def an_enrolment(roles: tuple[str, ...] = ("operator",), at_ns: int = 10) -> Enrolled:
    """Return that Ada became known."""
    return Enrolled(principal=ADA, roles=roles, at_ns=at_ns, letter=Letter(ADA, AWKWARD))


def a_fact(
    key: str, body: bytes = b"so", *, kind: str = "slot", letter: Letter | None = None
) -> Fact:
    """Return that something is so; with an empty body, that it is not so any more."""
    return Fact(kind=kind, key=key, body=body, letter=letter)


def a_decision(about: str, at_ns: int = 1_000) -> Decided:
    """Return that the owner let somebody in."""
    return Decided(act="enrol", by="owner", about=about, at_ns=at_ns, digest=b"digest")


# ---- orders ----

LIFETIME_NS = 5 * SECOND_NS


class OrderBook:
    """Numbers the orders of one robot."""

    def __init__(self, profile: Profile, clock: Clock) -> None:
        self._profile = profile
        self._clock = clock
        self._n = count(1)

    def order(
        self,
        skill: str,
        arguments: dict[str, Argument] | None = None,
        *,
        n: int | None = None,
        fence: int = 1,
        stop_generation: int = 0,
        late_s: float = 0.0,
    ) -> Order:
        """Return an order that is good unless an argument makes it bad.

        Args:
            skill: A skill of the profile.
            arguments: SI.
            n: Instead of the next number.
            fence: The lease it is given under.
            stop_generation: The robot's when it was admitted.
            late_s: How long ago it expired; 0 for one that is fresh.
        """
        number = next(self._n) if n is None else n
        left_ns = -int(late_s * 1e9) if late_s else LIFETIME_NS
        permit = Permit("p1", "k1", self._profile.id, skill, fence, False, stop_generation, 1)
        return Order(
            command_id("test", self._profile.id, str(number), str(fence)),
            self._profile.id,
            self._profile.skills[skill],
            dict(arguments or {}),
            number,
            self._clock.monotonic_ns() + left_ns,
            self._clock.wall_ns() + left_ns,
            permit,
        )
