"""What a rule runs: an order like any other, as the rule's author and within their rights."""

from __future__ import annotations

from msgspec.structs import replace

from rosic.core.policy.roles import DEFAULT_ROLES, RoleRules, SkillPrecondition
from rosic.core.records import Claimed, Decided, Fact, Record
from rosic.core.robot.alert_config import AlertConfig, RecipientCircle
from rosic.core.robot.profile import Telemetry
from rosic.errors import StoreFault
from rosic.features.alerts.active_alerts import RUN
from rosic.stores.memory import MemoryStore
from tests.features.alerts.test_alerts import battery, heard
from tests.gateway.place import ADA, BO, FLEET, VI, BrokenStore, Place

DRIFT = AlertConfig(
    name="drift",
    when="battery outside 40 to 60 %",
    lasting="2 s",
    say="Off its benchmark",
    run="move back 0.5 m",
    author="Bo",
    run_every="10 min",
    tell=RecipientCircle.ADMINS,
)


class Kept(MemoryStore):
    """Remembers what was written, in order."""

    def __init__(self) -> None:
        super().__init__()
        self.written: list[object] = []

    async def write(self, *records: object) -> None:
        self.written += records
        await super().write(*records)  # type: ignore[arg-type]


class FailsToClaim(BrokenStore):
    """Writes everything but claims."""

    claims = False

    async def write(self, *records: Record) -> None:
        if not self.claims and any(isinstance(record, Claimed) for record in records):
            raise StoreFault("the disk is full")
        await super().write(*records)


class FailsToDecide(BrokenStore):
    """Writes everything but administrative acts."""

    async def write(self, *records: Record) -> None:
        if any(isinstance(record, Decided) for record in records):
            raise StoreFault("the disk is full")
        await super().write(*records)


class Careful(Place):
    """Asks before it moves."""

    rulebook = RoleRules(
        roles=DEFAULT_ROLES, care=(SkillPrecondition(scopes=("omni:move",), confirm=True),)
    )


class Yielding(Place):
    """Lets a higher role take the robot over."""

    rulebook = RoleRules(roles=DEFAULT_ROLES, preempt=("omni",))


def place(
    rule: AlertConfig = DRIFT, store: MemoryStore | None = None, kind: type[Place] = Place
) -> Place:
    omni = replace(FLEET[0], telemetry={"battery": Telemetry(unit="%")}, alerts=(rule,))
    return kind(store, fleet=(omni, *FLEET[1:]))


async def drift(here: Place) -> dict[str, list[str]]:
    """Leave the benchmark, for as long as it takes."""
    battery(here, 30)
    return await heard(here, 4)


async def test_a_deviation_from_a_benchmark_runs_a_skill_by_its_author_and_names_the_rule() -> None:
    store = Kept()
    async with place(store=store).open() as here:
        battery(here, 50)
        assert await heard(here, 10) == {}
        told = await drift(here)
        assert here.acted() == 1
        assert told[ADA] == [
            (
                "omni: Off its benchmark.\nNow: battery 30 %."
                "\nThe rule asks it now, for Bo: move back 0.5 m."
            )
        ]
        assert any("omni: move, 0.50 m back · rule drift" in text for text in told[BO])
        bo = here.gateway.rooms.authoriser.directory.named("Bo")[0].id
        [decided] = [r for r in store.written if isinstance(r, Decided) and r.act == "alarm-run"]
        [claimed] = [r for r in store.written if isinstance(r, Claimed)]
        assert (decided.by, decided.about) == (bo, "omni/drift")
        assert decided.digest == claimed.cid
        assert (claimed.principal, claimed.key) == (bo, _key(here, bo))
        before = store.written[: store.written.index(claimed)]
        assert decided in before, "the decision is on disk before the claim"
        assert [r.kind for r in before if isinstance(r, Fact) and r.kind == RUN] == [RUN]


def _key(here: Place, who: str) -> str:
    key = here.gateway.rooms.authoriser.directory.key_of(who)
    assert key is not None
    return key.id


async def test_it_runs_once_an_occurrence_and_not_more_often_than_it_says() -> None:
    async with place().open() as here:
        await drift(here)
        await heard(here, 3000)
        assert here.acted() == 1
        battery(here, 50)
        await heard(here, 2)
        await drift(here)
        assert here.acted() == 2, "more than ten minutes have passed"
        battery(here, 50)
        await heard(here, 2)
        told = await drift(here)
        assert here.acted() == 2
        assert "runs at most once in 10 min" in told[ADA][-1]


async def test_a_restart_does_not_run_it_again() -> None:
    store = MemoryStore()
    first = place(store=store)
    async with first.open() as here:
        await drift(here)
        assert here.acted() == 1
    second = place(store=store)
    second.clock.jump_wall(3600)
    async with second.open() as here:
        told = await drift(here)
        assert told[ADA] == ["omni: Off its benchmark.\nIt is still so.\nNow: battery 30 %."]
        assert here.acted() == 0


async def test_who_may_not_cannot_let_a_rule_do_it() -> None:
    async with place(replace(DRIFT, author="Vi")).open() as here:
        told = await drift(here)
        assert here.acted() == 0
        assert told[ADA][-1].startswith("omni was not asked to move back 0.5 m by the rule drift:")


async def test_the_rights_of_that_moment_count() -> None:
    async with place().open() as here:
        await here.revoke("Bo")
        told = await drift(here)
        assert here.acted() == 0
        assert "Bo, in whose name it runs, has no access" in told[ADA][-1]


async def test_a_name_means_the_person_of_the_configuration_alone() -> None:
    for name, acted in (("Zed", 0), ("Bo", 1)):
        async with place(replace(DRIFT, author=name)).open() as here:
            directory = here.gateway.rooms.authoriser.directory
            directory.enrol(replace(directory.named("Bo")[0], name="Zed"))
            told = await drift(here)
            assert here.acted() == acted
            assert acted or "Zed, in whose name it runs" in told[ADA][-1]


async def test_nothing_moves_before_the_decision_is_on_disk() -> None:
    async with place(store=FailsToDecide()).open() as here:
        told = await drift(here)
        assert here.acted() == 0
        assert "cannot write" in told[ADA][-1]


async def test_a_run_that_was_decided_and_not_claimed_is_not_made_up_for() -> None:
    store = FailsToClaim()
    first = place(store=store)
    async with first.open() as here:
        told = await drift(here)
        assert here.acted() == 0
        assert "cannot write" in told[ADA][-1]
        store.claims = True
        await heard(here, 1200)
        assert here.acted() == 0
    async with place(store=store).open() as here:
        await drift(here)
        assert here.acted() == 0


async def test_never_while_somebody_else_has_the_robot() -> None:
    async with place().open() as here:
        await here.say("omni wave", account=ADA)
        told = await drift(here)
        assert here.acted() == 1, "the wave"
        assert any("was not asked to" in text for text in told[ADA])


async def test_unless_its_author_may_take_over_and_then_whoever_has_it_is_told() -> None:
    async with place(replace(DRIFT, author="Ada"), kind=Yielding).open() as here:
        await here.say("omni wave", account=BO, chat=BO)
        told = await drift(here)
        assert here.acted() == 2
        assert "omni is taken over now, by Ada's rule drift." in told[BO]


async def test_a_stopped_robot_stays_stopped_and_what_wants_a_tap_is_not_done() -> None:
    async with place().open() as here:
        await here.say("stop omni")
        told = await drift(here)
        assert here.acted() == 0
        assert "was not asked to" in told[ADA][-1]
    async with place(kind=Careful).open() as here:
        told = await drift(here)
        assert here.acted() == 0
        assert "only if you confirm it" in told[ADA][-1]


async def test_a_muted_rule_runs_nothing() -> None:
    async with place().open() as here:
        await here.say("/mute omni drift 1h")
        assert await drift(here) == {}
        assert here.acted() == 0


async def test_without_a_disk_nothing_moves_and_it_is_said() -> None:
    store = BrokenStore()
    async with place(store=store).open() as here:
        store.broken = True
        told = await drift(here)
        assert here.acted() == 0
        assert "cannot write" in told[ADA][-1]
        store.broken = False


async def test_a_rule_may_stop_its_robot() -> None:
    async with place(replace(DRIFT, run="stop", author="Vi")).open() as here:
        told = await drift(here)
        assert here.gateway.rooms.stops["omni"].latched
        assert told[ADA][-1] == "omni was stopped by the rule drift."
        assert VI not in told
