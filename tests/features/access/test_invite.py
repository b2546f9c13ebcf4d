"""`/invite`: what is understood, who may give what, and what is answered."""

from __future__ import annotations

import pytest

from rosic.authoriser.invitations import InvitedRights
from rosic.authoriser.invite_codes import qr_png
from rosic.core.policy.roles import Grant
from rosic.errors import NotUnderstood
from rosic.features.access import messages
from rosic.features.access.invite import read_invitation
from rosic.gateway.commands import ONLY_IN_PRIVATE
from tests.features.access.access_handlers import ADA, BO, CY, DI, ED, BrokenStore, Hall, a_hall

FOR_ADMINS = "Inviting people and letting them in is for admins. Ada or Bo can. Nothing was done."
RIGHTS = Hall().rights


@pytest.mark.parametrize(
    ("line", "given", "code_s", "name"),
    [
        ("viewer", InvitedRights(roles=("viewer",)), 600, ""),
        (
            "operator kuka1 for 2h",
            InvitedRights(roles=("operator",), robots=("kuka1",), lasts_s=7200.0),
            600,
            "",
        ),
        (
            "an Operator on KUKA1, omni",
            InvitedRights(roles=("operator",), robots=("kuka1", "omni")),
            600,
            "",
        ),
        ("as operator everywhere", InvitedRights(roles=("operator",)), 600, ""),
        ("operator swarm", InvitedRights(roles=("operator",), robots=("swarm",)), 600, ""),
        ("operator cf*", InvitedRights(roles=("operator",), robots=("cf*",)), 600, ""),
        ("viewer and junior", InvitedRights(roles=("viewer", "junior")), 600, ""),
        ("operator kuka1 kuka1", InvitedRights(roles=("operator",), robots=("kuka1",)), 600, ""),
        (
            "for 1 h 30 min operator kuka1 code 5 min",
            InvitedRights(roles=("operator",), robots=("kuka1",), lasts_s=5400.0),
            300,
            "",
        ),
        (
            "operator for 3 days kuka1",
            InvitedRights(roles=("operator",), robots=("kuka1",), lasts_s=259_200.0),
            600,
            "",
        ),
        ("viewer as Cy  Young", InvitedRights(roles=("viewer",)), 600, "Cy Young"),
        (
            "viewer as Cy for 2h code 1h",
            InvitedRights(roles=("viewer",), lasts_s=7200.0),
            3600,
            "Cy",
        ),
        ("viewer as Code for Good", InvitedRights(roles=("viewer",)), 600, "Code for Good"),
        (
            "operator kuka1 with distance <= 1 m for 2h",
            InvitedRights(
                roles=("operator",), robots=("kuka1",), limits=("distance <= 1 m",), lasts_s=7200.0
            ),
            600,
            "",
        ),
        (
            "operator with distance<=50 cm and distance >= 10 cm on kuka1 code 1h as Cy",
            InvitedRights(
                roles=("operator",),
                robots=("kuka1",),
                limits=("distance<=50 cm", "distance >= 10 cm"),
            ),
            3600,
            "Cy",
        ),
        (
            "operator limit distance = 1 m, kuka1",
            InvitedRights(roles=("operator",), robots=("kuka1",), limits=("distance = 1 m",)),
            600,
            "",
        ),
        ("viewer for half an hour", InvitedRights(roles=("viewer",), lasts_s=1800.0), 600, ""),
    ],
)
def test_what_is_understood(line: str, given: InvitedRights, code_s: float, name: str) -> None:
    wanted = read_invitation(line, RIGHTS)
    assert (wanted.given, wanted.code_ttl_s, wanted.name) == (given, code_s, name)


@pytest.mark.parametrize(
    ("english", "german"),
    [
        (
            "operator omni with distance <= 0.2 m for 2h code 30 min as Cy Young",
            "Bediener omni mit Strecke <= 0,2 m für 2h code 30 min als Cy Young",
        ),
        ("viewer everywhere confirm", "Zuschauer überall bestätigen"),
        (
            "operator with omni:move distance <= 0.2 m and distance >= 0.1 m",
            "Bediener mit omni:move Entfernung <= 0,2 m und Strecke >= 0,1 m",
        ),
    ],
)
def test_it_may_be_said_in_german_as_the_german_help_says_it(english: str, german: str) -> None:
    assert read_invitation(german, RIGHTS) == read_invitation(english, RIGHTS)


def test_an_admin_may_be_asked_for_a_tap() -> None:
    assert read_invitation("viewer confirm for 2h", RIGHTS).needs_confirmation
    assert read_invitation("viewer for 2h", RIGHTS).needs_confirmation is None


@pytest.mark.parametrize(
    ("line", "sentence", "offers"),
    [
        (
            "operater kuka1",
            (
                'I know no role and no robot called "operater". Did you mean operator? '
                "Nothing was done."
            ),
            ("/invite operator kuka1",),
        ),
        (
            "operator kuka2",
            'I know no role and no robot called "kuka2". Did you mean kuka1? Nothing was done.',
            ("/invite operator kuka1",),
        ),
        (
            "operator zzzzzzzzz",
            (
                'I know no role and no robot called "zzzzzzzzz". The roles here are viewer, '
                "operator, senior, admin, junior, tutor and guard. Nothing was done."
            ),
            (),
        ),
        (
            "operator fleet",
            (
                'I know no role and no robot called "fleet". The roles here are viewer, '
                "operator, senior, admin, junior, tutor and guard. Nothing was done."
            ),
            (),
        ),
        (
            "kuka1 for 2h",
            (
                "As what? The roles here are viewer, operator, senior, admin, junior, tutor and "
                "guard. Nothing was done."
            ),
            (),
        ),
        (
            "operator for ever",
            (
                'I cannot read "ever" as a length of time. Write for 2h, for 30 min or for 3 days. '
                "Nothing was done."
            ),
            (),
        ),
        (
            "operator for",
            "How long? Write for 2h, for 30 min or for 3 days. Nothing was done.",
            (),
        ),
        (
            "operator code kuka1",
            (
                'I cannot read "kuka1" as a length of time. Write code 2h, code 30 min or '
                "code 3 days. Nothing was done."
            ),
            (),
        ),
        (
            "operator kuka1 with force <= 20 N",
            (
                "No skill given here has a parameter 'force', so 'force <= 20 N' limits nothing. "
                "Known here: direction, distance. Nothing was done."
            ),
            (),
        ),
        (
            "operator kuka1 with distance <= 20 kg",
            (
                "On kuka1, 'distance <= 20 kg' does not fit distance of move: 'kg' does not fit, "
                "it is given in m. Nothing was done."
            ),
            (),
        ),
        (
            "operator kuka1 with distance <",
            ("'distance <' is not a limit: write for example speed <= 0.2 m/s. Nothing was done."),
            (),
        ),
        ("operator for 2h for 3h", 'That says "for" twice. Nothing was done.', ()),
    ],
)
def test_what_is_not_understood(line: str, sentence: str, offers: tuple[str, ...]) -> None:
    with pytest.raises(NotUnderstood) as refused:
        read_invitation(line, RIGHTS)
    assert (str(refused.value), refused.value.offers) == (sentence, offers)


async def test_alone_it_explains_itself_with_an_example_of_the_place() -> None:
    async with a_hall() as hall:
        said = await hall.say(ADA, "/invite")
        assert said.splitlines()[0] == (
            "Say as what, where, and for how long: /invite operator omni for 2h"
        )
        example = said.splitlines()[0].partition("/invite ")[2]
        assert read_invitation(example, hall.rights).given.robots == ("omni",)


async def test_the_answer_has_the_link_the_code_and_what_to_type() -> None:
    async with a_hall() as hall:
        said = await hall.say(ADA, "/invite operator kuka1 for 2h code 30 min")
        (made,) = hall.enrolment.invitations.open()
        code = said.partition("Code ")[2][:9]
        assert hall.enrolment.invitations.find(code) == made
        assert said == (
            f"Invitation as operator on kuka1 for 2 hours. Code {code}, good once, for "
            "30 minutes, in a private chat with me. Send it to one person, and to no group.\n"
            f"https://t.me/lab_bot?start={code}\n"
            f"Or let them send me, in a private chat: join {code}"
        )
        assert hall.labels(ADA) == ["Take it back"]
        assert await hall.tap(ADA, "Take it back") == messages.TAKEN_BACK
        assert not hall.enrolment.invitations.open()
        assert await hall.say(ADA, f"/invite back {made.id}") == (
            "There is no such invitation any more. Nothing was done."
        )


async def test_only_the_terminal_draws() -> None:
    async with a_hall(platform="terminal", assurance="local") as hall:
        assert "█" in await hall.say(ADA, "/invite viewer")
    async with a_hall() as hall:
        said = await hall.say(ADA, "/invite viewer")
        assert "█" not in said
        picture = hall.last(ADA).attachment
        assert picture is not None
        (link,) = [line for line in said.splitlines() if line.startswith("https://")]
        assert (picture.media_type, picture.content) == ("image/png", qr_png(link))
        hall.chat.file_bytes = 0
        await hall.say(ADA, "/invite viewer")
        assert hall.last(ADA).attachment is None


async def test_without_a_link_there_is_what_to_type() -> None:
    assert messages.how_to_join("", "join A") == "Let them send me, in a private chat: join A"


async def test_only_in_private_and_only_who_may() -> None:
    async with a_hall() as hall:
        assert await hall.in_group(ADA, "/invite viewer") == ONLY_IN_PRIVATE
        for line in ("/invite", "/invite viewer", "/invite back i1", "/invite reopen"):
            assert await hall.say(CY, line) == FOR_ADMINS, line
        await hall.say(ADA, "/lock Bo")
        assert await hall.say(BO, "/invite viewer") == "Your access is locked. Ask an admin."
        assert not hall.enrolment.invitations.open()
        # Whoever is locked is nobody to send people to.
        assert await hall.say(CY, "/invite") == FOR_ADMINS.replace("Ada or Bo", "Ada")


async def test_nobody_gives_more_than_they_may() -> None:
    async with a_hall() as hall:
        await hall.knows(ED, "Ed", "tutor")
        assert "Code " in await hall.say(ED, "/invite operator kuka1 for 2h")
        for line, what in (
            ("operator", "operator"),
            ("operator omni", "operator on omni"),
            ("operator kuka1 omni", "operator on kuka1 and omni"),
            ("operator *", "operator on *"),
            ("senior kuka1", "senior on kuka1"),
            ("admin kuka1", "admin on kuka1"),
        ):
            assert await hall.say(ED, f"/invite {line}") == (
                f"You cannot give {what}: it is more than you may give. Ada or Bo can. "
                "Nothing was done."
            )
        assert len(hall.enrolment.invitations.open()) == 1
        assert (await hall.say(ED, "/invite reopen")).startswith("Looking after people is for")


async def test_a_right_that_has_ended_invites_nobody() -> None:
    async with a_hall() as hall:
        until_ns = hall.clock.wall_ns() + 60_000_000_000
        await hall.knows(DI, "Di", grants=(Grant(id="g", role="admin", expires_ns=until_ns),))
        assert "Code " in await hall.say(DI, "/invite viewer for 20 s code 30 s")
        await hall.clock.advance(61.0)
        assert await hall.say(DI, "/invite viewer") == FOR_ADMINS


async def test_nobody_gives_by_invitation_what_outlives_their_own_right() -> None:
    async with a_hall() as hall:
        until_ns = hall.clock.wall_ns() + 3_600_000_000_000
        await hall.knows(DI, "Di", grants=(Grant(id="g", role="admin", expires_ns=until_ns),))
        for line, what in (
            ("admin", "admin"),
            ("operator for 61 min code 1 min", "operator for 61 minutes"),
            ("viewer for 55 min code 6 min", "viewer for 55 minutes"),
        ):
            assert await hall.say(DI, f"/invite {line}") == (
                f"You cannot give {what}: your own right to give it ends sooner. Say a shorter "
                "time. Ada or Bo can. Nothing was done."
            )
        assert hall.enrolment.invitations.open() == ()
        assert "Code " in await hall.say(DI, "/invite viewer for 50 min code 5 min")


async def test_the_code_of_whoever_may_not_invite_any_more_lets_nobody_in() -> None:
    async with a_hall() as hall:
        await hall.knows(DI, "Di", grants=(Grant(id="g", role="admin"),))
        code = await hall.invited("operator for 3 days", account=DI)
        async with hall.changes.turn() as turn:
            await turn.act(hall.registry.grants_book.take_one("p-4", "g", "p-1"))
        told = await hall.say(ED, f"join {code}")
        assert told.startswith("This code is not good here. Ask whoever invited you for a new one.")


async def test_times_that_are_none() -> None:
    async with a_hall() as hall:
        expected = (
            "A right and a code last at least some seconds, a code at most a week. "
            "Nothing was done."
        )
        for line in ("viewer for 0s", "viewer code 8 days", "viewer for 9999 days"):
            assert await hall.say(ADA, f"/invite {line}") == expected, line


async def test_what_cannot_be_written_invites_nobody() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        store.broken = True
        said = await hall.say(ADA, "/invite viewer")
        assert said.startswith("I cannot write this down now, so nothing was changed.")
        assert not hall.enrolment.invitations.open()


async def test_taking_back_acts_with_the_disk_full() -> None:
    store = BrokenStore()
    async with a_hall(store) as hall:
        code = await hall.invited("viewer")
        store.broken = True
        assert await hall.tap(ADA, "Take it back") == f"{messages.TAKEN_BACK} {messages.UNWRITTEN}"
        assert (await hall.say(DI, code)).startswith("This code is not good here.")


async def test_joining_is_opened_again_by_who_may() -> None:
    async with a_hall() as hall:
        assert await hall.say(ADA, "/invite reopen") == "Everybody has all their tries again."
