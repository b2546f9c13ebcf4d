"""The security report: times, attempts by kind, locks, keys near their end, invitations."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import rosic.authoriser
from rosic.authoriser.counters import Counters
from rosic.authoriser.security_report import KINDS, percentile
from rosic.core.message import Chat, Inbound
from rosic.core.records import Fact
from rosic.errors import Unrecognised
from tests.authoriser.enrolment_rooms import ADA, CY, DI, EnrolmentRooms


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    return await EnrolmentRooms().with_admins()


def test_nearest_rank() -> None:
    hundred = [float(n) for n in range(1, 101)]
    assert percentile(hundred, 50) == 50.0
    assert percentile(hundred, 99) == 99.0
    assert percentile([3.0], 99) == 3.0
    assert percentile([1.0, 2.0], 50) == 1.0
    assert percentile([], 50) is None


async def test_a_quiet_place(enrolling: EnrolmentRooms) -> None:
    assert enrolling.security.text() == (
        "Authentication: nothing measured yet.\n"
        "Unauthorised attempts: none.\n"
        "Locked: nobody.\n"
        "Keys near their end: none.\n"
        "Open invitations: none."
    )


def inbound(sender: object = ADA) -> Inbound:
    return Inbound(
        sender=sender,  # type: ignore[arg-type]
        chat=Chat("telegram", "c"),
        message="1",
        text="hi",
        sent_ns=0,
        received_ns=0,
    )


async def test_a_busy_place(enrolling: EnrolmentRooms) -> None:
    for _ in range(3):
        enrolling.authoriser.identify(inbound())
    with pytest.raises(Unrecognised):
        enrolling.authoriser.identify(inbound(DI))
    await enrolling.redeem("0000-0000", DI)
    await enrolling.redeem("0000-0000", DI)
    await enrolling.knows("cy", "Cy", CY, roles=("operator",))
    key, records = enrolling.keys.issue("cy", "ada", lasts_s=7200.0)
    await enrolling.write(records)
    _, made = await enrolling.invite("operator", robots=("kuka1",), lasts_s=7200.0)
    code, _ = await enrolling.invite("senior")
    await enrolling.redeem(code, DI, name="Di")
    await enrolling.write(enrolling.locks.lock("cy", "ada"))
    enrolling.clock.jump_wall(-86_400.0)

    assert enrolling.security.text() == (
        "Authentication: p50 0.000 ms, p99 0.000 ms, over the last 3.\n"
        "Unauthorised attempts since the first start: 3\n"
        "  codes that never were: 2\n"
        "  messages from strangers: 1\n"
        "Locked:\n"
        "  Cy, by Ada, for 1 second now\n"
        "Keys near their end:\n"
        f"  Cy, key {key.id}, in 2 hours\n"
        "Open invitations:\n"
        f"  operator on kuka1 for 2 hours, by Ada, {made.id}, good for 10 minutes\n"
        "1 person waits for an admin to let them in.\n"
        "The clock of this machine was set back by 24 hours. Times go on from the highest one "
        "seen, until its owner accepts the new one."
    )
    report = enrolling.security.report()
    assert (report.measured, report.p50_s, report.waiting, report.behind_s) == (3, 0.0, 1, 86_400.0)


def test_every_kind_that_is_counted_has_words() -> None:
    """Whatever the modules count is in the table of the report, and nothing else."""
    folder = Path(rosic.authoriser.__file__).parent
    sources = "".join(path.read_text() for path in folder.glob("*.py") if "words" not in path.name)
    kinds = (
        r"\"((?:button|code|link|totp|confirm|key)-[a-z-]+|declined|stranger|no-right|too-many)\""
    )
    acts = {"code-key", "key-end"}  # kinds of facts
    elsewhere = {"locked"}  # counted by whoever is told of it
    assert set(re.findall(kinds, sources)) - acts | elsewhere == set(KINDS)


def test_counts_outlive_a_restart_and_damage() -> None:
    counters = Counters()
    assert counters.due() == ()
    counters.count("code-used")
    (fact,) = counters.due()
    counters.apply(fact)
    assert counters.due() == ()
    again = Counters()
    again.count("code-used")
    again.apply(fact)
    again.apply(Fact(kind="tally", key="attempts", body=b"\xc1"))
    assert again.by_kind() == {"code-used": 1}
