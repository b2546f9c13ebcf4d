"""Programs' keys: shown once, kept as a digest, replaced and taken back like anybody's."""

from __future__ import annotations

import pytest

from rosic.authoriser.invitations import InvitedRights
from rosic.authoriser.program_keys import ProgramKeys
from rosic.core.identity import OPERATOR, PROGRAM
from rosic.core.records import Enrolled, Fact, KeyIssued, Record
from rosic.core.secret import Secret
from rosic.errors import NotUnderstood, Unrecognised
from rosic.gateway.access_registry import person_of
from rosic.testing.clock import SeededEntropy
from tests.authoriser.enrolment_rooms import CY, EnrolmentRooms

OPERATES = InvitedRights(roles=("operator",))


@pytest.fixture
async def enrolling() -> EnrolmentRooms:
    enrolling = await EnrolmentRooms().with_admins()
    await enrolling.knows("cy", "Cy", CY, roles=("operator",))
    return enrolling


class Programs:
    """A place's programs; what is written becomes so."""

    def __init__(self, enrolling: EnrolmentRooms) -> None:
        self.enrolling = enrolling
        self.keys = ProgramKeys(enrolling.keys, enrolling.directory, SeededEntropy())
        self.written: list[Record] = []

    def let_in(self, name: str = "Hal", given: InvitedRights = OPERATES) -> Secret:
        made = self.keys.enrol(name, given, OPERATOR)
        self.apply(*made.records)
        return made.secret

    def apply(self, *records: Record) -> None:
        for record in records:
            self.written.append(record)
            if isinstance(record, Enrolled):
                self.enrolling.directory.enrol(person_of(record))
            elif isinstance(record, KeyIssued):
                self.enrolling.directory.add_key(record.key)
            self.enrolling.keys.apply(record)
            if isinstance(record, Fact):
                self.keys.apply(record)


@pytest.fixture
def programs(enrolling: EnrolmentRooms) -> Programs:
    return Programs(enrolling)


def test_a_program_is_known_by_its_secret_and_has_the_roles_that_were_given(
    programs: Programs,
) -> None:
    address = programs.keys.identify(programs.let_in())
    found = programs.enrolling.directory.at(address)
    assert found is not None
    person, key = found
    assert (person.name, person.roles, person.is_program) == ("Hal", ("operator",), True)
    assert address.platform == PROGRAM
    assert address.account == person.id == key.principal


def test_only_the_secret_that_was_shown_is_good(programs: Programs) -> None:
    secret, other = programs.let_in(), programs.let_in("Sal")
    text = secret.reveal()
    key = text.split("_")[1]
    mixed = f"rosic_{key}_{other.reveal().split('_', 2)[2]}"
    for wrong in (
        text[:-1],
        f"{text}x",
        f"rosic_{key}_",
        mixed,
        "rosic_k0_x",
        "x",
        "___",
        "\ud800",
    ):
        with pytest.raises(Unrecognised, match="no key of a program"):
            programs.keys.identify(Secret(wrong))
    assert programs.enrolling.counters["key-unknown"] == 8
    assert programs.keys.identify(secret) != programs.keys.identify(other)


def test_the_record_holds_no_secret(programs: Programs) -> None:
    random = programs.let_in().reveal().split("_", 2)[2]
    assert random not in repr(programs.written)
    assert len([one for one in programs.written if isinstance(one, Fact)]) == 1


def test_a_later_start_knows_it(programs: Programs, enrolling: EnrolmentRooms) -> None:
    secret = programs.let_in()
    later = ProgramKeys(enrolling.keys, enrolling.directory, SeededEntropy())
    with pytest.raises(Unrecognised):
        later.identify(secret)
    later.restore(one for one in programs.written if isinstance(one, Fact))
    assert later.identify(secret) == programs.keys.identify(secret)


async def test_a_key_that_was_taken_back_or_has_ended_lets_nobody_in(
    programs: Programs, enrolling: EnrolmentRooms
) -> None:
    secret = programs.let_in()
    key = secret.reveal().split("_")[1]
    programs.apply(*enrolling.keys.revoke(key, OPERATOR).records)
    with pytest.raises(Unrecognised, match="has ended"):
        programs.keys.identify(secret)


def test_a_name_is_its_own(programs: Programs) -> None:
    programs.let_in()
    for taken in ("Cy", "cy", "hal", "HAL"):
        with pytest.raises(NotUnderstood, match="Choose another name"):
            programs.keys.enrol(taken, OPERATES, OPERATOR)
    with pytest.raises(NotUnderstood, match="needs a name"):
        programs.keys.enrol("\u202e ", OPERATES, OPERATOR)


def test_what_ends_or_is_bounded_is_a_grant_and_no_role_of_its_own(programs: Programs) -> None:
    given = InvitedRights(roles=("operator",), robots=("omni",), lasts_s=3600)
    made = programs.keys.enrol("Guest", given, OPERATOR)
    assert made.program.roles == ()
    assert [(one.role, one.robots) for one in made.grants] == [("operator", ("omni",))]
