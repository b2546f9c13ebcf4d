"""Comparing emoji: who is shown them, where, and whose word counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from msgspec.structs import replace

from rosic.app.people import ConfiguredPerson
from rosic.contracts.verification import ShownCode, VerificationEnd, VerificationResult
from rosic.core.identity import Address
from rosic.core.message import Chat, MessageValidity
from rosic.core.policy.roles import Assurance
from rosic.core.records import Decided
from rosic.errors import MessengerFault
from rosic.features.verification import messages as words
from rosic.features.verification.service import LASTS_S, SHOWN_AT_MOST
from rosic.gateway.unverified_messages import MAY_LOOK
from rosic.messengers.memory import MemoryMessenger
from rosic.stores.memory import MemoryStore
from tests.gateway.place import BrokenStore, Place

if TYPE_CHECKING:
    from rosic.contracts.verification import VerificationPrompt
    from rosic.core.message import Inbound
    from rosic.core.records import Record
    from rosic.testing.clock import ManualClock

ADA, BO = "@ada:example.org", "@bo:example.org"
EMOJI = (("🐶", "Dog"), ("🐱", "Cat"), ("🦁", "Lion"))
CODE = ShownCode(verification="v1", user=BO, device="PHONE", emoji=EMOJI, decimals=())


class KeyedMessenger(MemoryMessenger):
    """People there have devices with keys; the test is whoever runs it."""

    platform = "keyed"
    assurance = "e2ee-verified"

    def __init__(self, clock: ManualClock) -> None:
        super().__init__("keyed", clock=clock)
        self.chats_are_worth = Assurance.E2EE_UNVERIFIED
        self.done: list[str] = []
        self.prompt: VerificationPrompt

    def verify_with(self, prompt: VerificationPrompt) -> None:
        self.prompt = prompt

    async def begin_verification(self, account: str) -> str:
        self.done.append(f"begin {account}")
        return "v1"

    async def confirm_verification(self, verification: str) -> None:
        if verification != "v1":
            raise MessengerFault("There is no such verification any more: begin once more.")
        self.done.append("confirm")

    async def reject_verification(self, verification: str) -> None:
        self.done.append(f"reject {verification}")

    def chat_assurance(self, chat: Chat) -> Assurance:
        return self.chats_are_worth if chat.id else Assurance.PROVIDER_READABLE


class Lab(Place):
    """Ada looks after it, on two messengers; Bo is on the one with keys alone."""

    people: tuple[ConfiguredPerson, ...] = (
        ConfiguredPerson("Ada", (Address("memory", "1"), Address("keyed", ADA)), ("admin",)),
        ConfiguredPerson("Bo", (Address("keyed", BO),), ("operator",)),
        ConfiguredPerson("Vi", (Address("memory", "3"),), ("viewer",)),
    )
    besides = (KeyedMessenger,)

    @property
    def keyed(self) -> KeyedMessenger:
        found = self.gateway.kernel.messengers[1]
        found = getattr(found, "_messenger", found)
        assert isinstance(found, KeyedMessenger)
        return found

    async def writes(self, account: str, text: str, **more: object) -> str:
        """Let somebody write on the messenger with keys; return what was told there."""
        before = len(self.keyed.told)
        await self.clock.advance(0.001)
        heard = {"text": text, "assurance": Assurance.E2EE_UNVERIFIED, **more}
        self.keyed.deliver(replace(self._blank(account), **heard))
        await self.quiet()
        return "\n".join(told.outbound.text for told in list(self.keyed.told)[before:])

    def _blank(self, account: str) -> Inbound:
        return self.keyed._inbound(account, Chat("keyed", account), None, None)

    async def show(self) -> None:
        """Have the emoji of Bo's device shown."""
        self.keyed.prompt.show(CODE)
        await self.quiet()

    async def end(self, end: VerificationEnd = VerificationEnd.COMPARED, code: str = "") -> None:
        """Have it end."""
        result = VerificationResult(verification="v1", user=BO, end=end, code=code)
        self.keyed.prompt.tell(result)
        await self.quiet()

    def texts(self, messenger: MemoryMessenger) -> str:
        return "\n".join(told.outbound.text for told in messenger.told)


UNSURE = {"standing": MessageValidity.UNVERIFIED}


async def test_somebody_asks_and_an_admin_compares_on_another_messenger() -> None:
    async with Lab().open() as lab:
        told = await lab.writes(BO, "/verify", **UNSURE)
        assert lab.keyed.done == [f"begin {BO}"]
        assert told.endswith("Shown the same: Ada.")

        await lab.show()
        assert "🐶 Dog  🐱 Cat  🦁 Lion" in lab.last()[1].text
        assert "Dog" not in lab.texts(lab.keyed), "the homeserver could put in others there"
        assert await lab.tap(*lab.button("They match")) == words.SAID_SAME
        assert lab.keyed.done[-1] == "confirm"

        await lab.end()
        assert words.YOU_ARE in lab.texts(lab.keyed)
        assert lab.texts(lab.chat).endswith(f"Bo is verified: {BO}.")


async def test_it_is_written_down_before_it_counts() -> None:
    noted: list[tuple[Decided, int]] = []

    class Watched(MemoryStore):
        async def write(self, *records: Record) -> None:
            found = [record for record in records if isinstance(record, Decided)]
            noted.extend((record, len(lab.keyed.done)) for record in found)
            await super().write(*records)

    lab = Lab(Watched())
    async with lab.open():
        await lab.show()
        await lab.say("they match")
        [(decided, done)] = [one for one in noted if one[0].act == "verify"]
        assert (done, lab.keyed.done) == (0, ["confirm"])
        assert decided.by != decided.about


async def test_what_cannot_be_written_down_is_not_verified() -> None:
    store = BrokenStore()
    lab = Lab(store)
    async with lab.open():
        await lab.show()
        store.broken = True
        await lab.say("they match")
        assert lab.keyed.done == []
        store.broken = False
        assert await lab.say("they match") == words.SAID_SAME


async def test_an_admin_says_that_they_differ() -> None:
    async with Lab().open() as lab:
        await lab.show()
        assert await lab.say("they differ") == words.SAID_DIFFERENT
        assert lab.keyed.done == ["reject v1"]
        await lab.end(VerificationEnd.CANCELLED, "m.mismatched_sas")
        assert "the emoji were not the same" in lab.texts(lab.chat)
        assert words.YOU_ARE_NOT in lab.texts(lab.keyed)
        assert await lab.say("/match 1") == words.ENDED


async def test_nobody_else_compares() -> None:
    async with Lab().open() as lab:
        await lab.show()
        assert await lab.say("/match 1", account="3", chat="3") == words.ONLY_ADMINS
        said = await lab.writes(BO, "/match 1", assurance=Assurance.E2EE_VERIFIED)
        assert said == words.ONLY_ADMINS
        assert await lab.say("/verify Bo", account="3", chat="3") == words.ONLY_ADMINS
        assert lab.keyed.done == []


async def test_a_chat_whose_keys_were_compared_is_as_good_as_another_messenger() -> None:
    async with Lab().open() as lab:
        lab.keyed.chats_are_worth = Assurance.E2EE_VERIFIED
        await lab.show()
        assert "Dog" in lab.texts(lab.keyed)
        for worth in (Assurance.PROVIDER_READABLE, Assurance.E2EE_UNVERIFIED):
            assert await lab.writes(ADA, "they match", assurance=worth) == words.NOT_SURE
        assert MAY_LOOK in await lab.writes(ADA, "they match", **UNSURE)
        assert lab.keyed.done == []
        verified = {"assurance": Assurance.E2EE_VERIFIED}
        assert await lab.writes(ADA, "they match", **verified) == words.SAID_SAME
        assert lab.keyed.done == ["confirm"]


async def test_only_where_they_were_shown() -> None:
    async with Lab().open() as lab:
        await lab.show()
        verified = {"assurance": Assurance.E2EE_VERIFIED}
        assert await lab.writes(ADA, "/match 1", **verified) == words.NOT_SHOWN_HERE
        assert await lab.writes(ADA, "they match", **verified) == words.NONE_SHOWN
        assert lab.keyed.done == []


async def test_whom_nobody_can_verify_reads_what_helps() -> None:
    class Alone(Lab):
        people = (
            ConfiguredPerson("Ada", (Address("keyed", ADA),), ("admin",)),
            ConfiguredPerson("Bo", (Address("keyed", BO),), ("operator",)),
        )

    async with Alone().open() as lab:
        assert words.NOBODY_COMPARES in await lab.writes(BO, "/verify", **UNSURE)
        await lab.show()
        assert lab.texts(lab.keyed).endswith(words.NOBODY_COMPARES)


async def test_whose_client_begins_is_shown_as_well_and_strangers_are_not() -> None:
    async with Lab().open() as lab:
        assert lab.keyed.prompt.accepts(BO)
        assert not lab.keyed.prompt.accepts("@eve:example.org")


async def test_an_admin_begins_with_somebody() -> None:
    async with Lab().open() as lab:
        assert "The client of Bo asks" in await lab.say("/verify Bo")
        assert lab.keyed.done == [f"begin {BO}"]
        assert "has no account" in await lab.say("/verify Vi")
        assert "nobody called" in await lab.say("/verify Zoe")


@pytest.mark.parametrize("worth", [Assurance.E2EE_VERIFIED, Assurance.LOCAL])
async def test_whoever_is_verified_need_not_be(worth: Assurance) -> None:
    async with Lab().open() as lab:
        assert await lab.writes(BO, "/verify", assurance=worth) == words.VERIFIED_ALREADY
        assert await lab.say("/verify") == words.NOT_HERE


async def test_what_was_compared_counts_for_no_other_that_took_its_place() -> None:
    async with Lab().open() as lab:
        lab.keyed.prompt.show(CODE)
        await lab.quiet()
        ended = VerificationResult(
            verification=CODE.verification, user=BO, end=VerificationEnd.CANCELLED, code="m.user"
        )
        lab.keyed.prompt.tell(ended)
        lab.keyed.prompt.show(replace(CODE, verification="other", device="OTHER"))
        await lab.quiet()

        told = await lab.say("they match")

        assert "More than one verification was shown here" in told
        assert lab.keyed.done == []


async def test_no_alarm_drowns_in_verifications_of_one_account() -> None:
    async with Lab().open() as lab:
        ada = lab.gateway.rooms.authoriser.directory.at(Address("memory", "1"))
        assert ada is not None
        before = len(lab.chat.told)
        for number in range(50):
            lab.keyed.prompt.show(replace(CODE, verification=f"v{number}"))
            ended = VerificationResult(
                verification=f"v{number}", user=BO, end=VerificationEnd.CANCELLED, code="m.user"
            )
            lab.keyed.prompt.tell(ended)
        lab.gateway.kernel.reach.tell((ada[0].id,), "keys replaced", urgent=True)
        await lab.quiet()

        told = [one.outbound.text for one in list(lab.chat.told)[before:]]
        assert sum("to be verified" in text for text in told) == SHOWN_AT_MOST
        assert len(told) == 2 * SHOWN_AT_MOST + 1
        await lab.clock.advance(LASTS_S + 1)
        await lab.show()
        assert "to be verified" in lab.chat.told[-1].outbound.text
