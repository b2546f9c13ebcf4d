from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.errors import StoreFault
from rosic.testing.clock import ManualClock
from tests.features.personal_data.data_gateway import Ward, a_ward

if TYPE_CHECKING:
    from pathlib import Path


OPERATOR = "operator"


async def test_what_was_kept_of_somebody_not_let_in_is_shredded(tmp_path: Path) -> None:
    clock = ManualClock()
    async with a_ward(tmp_path, clock=clock) as ward:
        before = set(await ward.kept.containers())
        newcomer = await applies(ward, "77", "Zoltan")
        assert await new_containers(ward, before) == {newcomer}
        await ward.said("decline", "Zoltan")
        assert not await new_containers(ward, before)
        again = await applies(ward, "78", "Zora")

        async def broken(container: str) -> None:
            raise StoreFault(container)

        shred, ward.kept.shred = ward.kept.shred, broken  # type: ignore[method-assign]
        await ward.said("decline", "Zora")
        ward.kept.shred = shred  # type: ignore[method-assign]
        waits = await applies(ward, "79", "Zoe")
        assert await new_containers(ward, before) == {again, waits}
        await ward.gateway.features.each_day()
        assert await new_containers(ward, before) == {waits}


async def new_containers(ward: Ward, before: set[str]) -> set[str]:
    return set(await ward.kept.containers()) - before - {OPERATOR}


async def applies(ward: Ward, account: str, name: str) -> str:
    """Let a stranger bring a good code; return the id under which they would come in."""
    code = next(
        line.rpartition("join ")[2]
        for line in (await ward.said("invite", f"senior as {name}")).splitlines()
        if "join " in line
    )
    ward.chat.say(f"join {code}", account=account, chat=account)
    await ward.quiet()
    applicants = ward.gateway.access.enrolment.applicants.all()
    if not applicants:
        told = ward.chat.told[-1]
        ward.chat.tap(told.outbound.buttons[0][0], under=told.message, account=account)
        await ward.quiet()
        applicants = ward.gateway.access.enrolment.applicants.all()
    (found,) = [a for a in applicants if a.address.account == account]
    return found.pending.principal
