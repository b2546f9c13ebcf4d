"""How long it takes to recognise somebody, and what becomes of attempts to get past that.

Attempts go to a whole gateway in a process of its own, through the doors that people and programs
use. An attempt that moves a robot, or that a door answers with a yes, was let through.
"""

from __future__ import annotations

import asyncio
import http.client
import json
import subprocess
import sys
import tempfile
import time
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from secrets import token_hex
from time import perf_counter_ns
from typing import TYPE_CHECKING, Final, NamedTuple

from rosic.app import runtime
from rosic.app.gateway import Gateway, GatewaySettings
from rosic.app.people import ConfiguredPerson
from rosic.authoriser.invitations import InvitationRequest, InvitedRights
from rosic.bench.bot_api_process import TOKEN, stand_in
from rosic.bench.gateway_process import LOCAL, free_port, gateway_process, key_headers
from rosic.bench.report import BenchReport, BenchTable, machine
from rosic.bench.resources import figures_of
from rosic.bench.scaling_process import inbound_of
from rosic.bench.senders import BenchMessenger
from rosic.bench.sites import parts_of
from rosic.bench.soak import await_answer
from rosic.core.identity import OPERATOR, Address
from rosic.core.robot.profile import Link, Profile
from rosic.core.robot.skill import Skill
from rosic.core.secret import Secret
from rosic.errors import Unrecognised
from rosic.stores.memory import MemoryStore

if TYPE_CHECKING:
    from collections.abc import AsyncIterator, Awaitable, Callable, Sequence

    from rosic.bench.recorder import BenchRecorder
    from rosic.core.message import Inbound
    from rosic.gateway.feature import Kernel
    from rosic.testing.telegram import Control

SAMPLES, QUICK_SAMPLES = 20_000, 500
ATTEMPTS, QUICK_ATTEMPTS = 50, 5
WITHIN_S: Final = 60.0
LOOK_S: Final = 0.1
ENDS_S: Final = 1
ORDER: Final = "cell sort"
PATH: Final = "/v1/robots/cell/orders"
YES: Final = 300
"""An answer of HTTP below is a yes."""
CONFIG: Final = """\
[gateway]
name = "bench"
data = "data"

[limits]
burst = 100000
per_s = 100000

[[messenger]]
kind = "telegram"
token = "{token}"
api_base = "{api_base}"

[api]
listen = "{listen}"

[metrics]
listen = "{metrics}"

[role.bench]
scopes = ["*:*"]

[[robot]]
profile = "cell.yaml"
"""
CELL: Final = """\
id: cell
link: { kind: memory }
skills:
  sort: { class: task }
"""
PERSON: Final = """
[[principal]]
name = "{name}"
address = "telegram:{account}"
role = "{role}"
"""
ROLES: Final = {"Ada": "admin", "Bo": "operator", "Vi": "viewer", "Ro": "operator"}
METHOD: Final = (
    "Times: {samples} of each, in one process with a record in memory, of what decides who "
    "somebody is; a join code is looked up, not used. Attempts: {attempts} of each kind at a "
    "whole gateway (rosic run) in a process of its own, over a stand-in for the Bot API in another "
    "process and over HTTP. Let through is what moved the robot and should not have, and every "
    "yes of HTTP. Listed is by how much the counts of rosic security report grew; told is how "
    "many messages the admin got meanwhile. Nobody guessed a passkey or a phone code."
)
THROUGH: Final = "{name}: {through} of {attempts} attempts were let through."
INVITED: Final = "You are invited"
NOTHING_TRIED: Final = "{name}: nothing was done the first time, so nothing was tried."
REFUSED: Final = "{attempts} attempts of {kinds} kinds: {through} let through."


# ---- how long it takes ----


@asynccontextmanager
async def _in_memory() -> AsyncIterator[Kernel]:
    """Open a gateway whose record is in memory; yield its kernel."""
    people = [
        ConfiguredPerson(f"Person {number}", (Address("bench", str(number)),), ("operator",))
        for number in range(100)
    ]
    profile = Profile(id="cell", link=Link(kind="memory"), skills={"sort": Skill(id="sort")})
    settings = GatewaySettings(profiles=(profile,), people=tuple(people))
    gateway = Gateway(settings, parts_of(MemoryStore(), BenchMessenger()))
    await gateway.open()
    try:
        yield gateway.kernel
    finally:
        await gateway.close()


async def _times(recorder: BenchRecorder, samples: int) -> None:
    """Time what decides who somebody is; the recorder keeps it."""
    async with _in_memory() as kernel:
        access, authoriser = kernel.access, kernel.rooms.authoriser
        program = access.programs.enrol("bench", InvitedRights(roles=("operator",)), OPERATOR)
        wanted = InvitationRequest(given=InvitedRights(roles=("viewer",)))
        invited = access.enrolment.invitations.invite(wanted, OPERATOR)
        async with access.changes.turn() as work:
            await work.write((*program.records, *invited.records))
        known, unknown = inbound_of("1", ORDER), inbound_of("stranger", ORDER)
        person = authoriser.identify(known).principal
        codes = iter(range(10 * samples))

        def identify(inbound: Inbound) -> Callable[[], object]:
            return lambda: authoriser.identify(inbound)

        def look(code: Callable[[], str]) -> Callable[[], object]:
            look = access.enrolment.look
            return lambda: look(code(), Address("bench", f"n{next(codes)}"), private=True)

        good, wrong = program.secret, Secret("rosic_k0_wrong")
        cases: dict[str, tuple[Callable[[], object], Callable[[], object] | None]] = {
            "a known person, in a conversation": (identify(known), None),
            "a known person, first message": (
                identify(known),
                lambda: authoriser.forget(person),
            ),
            "a stranger": (identify(unknown), None),
            "a key of the API": (lambda: access.programs.identify(good), None),
            "a key that never was": (lambda: access.programs.identify(wrong), None),
            "a join code": (look(invited.code.reveal), None),
            "a guessed join code": (look(lambda: token_hex(8)), None),
        }
        for name, (act, before) in cases.items():
            with recorder.turn(name) as turn:
                times = _timed(act, before, samples)
                turn.saw(1e9 * len(times) / sum(times), times)


def _timed(
    act: Callable[[], object], before: Callable[[], object] | None, samples: int
) -> list[int]:
    times: list[int] = []
    for _ in range(samples):
        if before is not None:
            before()
        began_ns = perf_counter_ns()
        with suppress(Unrecognised):
            act()
        times.append(perf_counter_ns() - began_ns)
    return times


# ---- what becomes of attempts ----


class SiteCounts(NamedTuple):
    """What is counted of attempts.

    Attributes:
        acts: How often the robot was told to act.
        listed: How many attempts the security report counts.
        told: How many messages the admin has.
    """

    acts: int
    listed: int
    told: int

    def since(self, before: SiteCounts) -> SiteCounts:
        """Return by how much they have grown."""
        return SiteCounts(*(now - then for now, then in zip(self, before, strict=True)))


class SecuritySite(NamedTuple):
    """A gateway under attack, and who is around it.

    Attributes:
        people: Accounts by name; Mallory is known to nobody.
        config: Of the gateway, for `rosic` on the same machine.
        port, metrics: On which it listens.
    """

    control: Control
    people: dict[str, int]
    config: Path
    port: int
    metrics: int

    async def settled(self) -> None:
        """Wait until the gateway has settled all that came.

        Raises:
            TimeoutError: It has not, in a minute.
        """
        async with asyncio.timeout(WITHIN_S):
            while await self.control.pending():  # noqa: ASYNC110 - another process
                await asyncio.sleep(LOOK_S)
        await await_answer(self.control, self.people["Ada"])

    async def rosic(self, *words: str) -> str:
        """Run a command beside the gateway; return what it printed."""
        command = (sys.executable, "-m", "rosic", *words, "-c", str(self.config))
        ended = await asyncio.to_thread(
            subprocess.run, command, capture_output=True, text=True, timeout=WITHIN_S, check=True
        )
        return ended.stdout

    async def counts(self) -> SiteCounts:
        """Count what is there by now."""
        figures = await asyncio.to_thread(figures_of, self.metrics)
        report = json.loads(await self.rosic("security", "report", "--json"))
        told = await self.control.messages(self.people["Ada"], by_bot=True)
        acts = int(figures["cell sent messages"])
        return SiteCounts(acts, sum(report["attempts"].values()), len(told))

    async def order(self, times: int, headers: dict[str, str]) -> int:
        """Give an order over HTTP so many times; return how often the answer was a yes."""
        return await asyncio.to_thread(self._order, times, headers)

    def _order(self, times: int, headers: dict[str, str]) -> int:
        yes = 0
        for _ in range(times):
            line = http.client.HTTPConnection(LOCAL, self.port, timeout=WITHIN_S)
            try:
                body = json.dumps({"skill": "sort"})
                line.request("POST", PATH, body, {"Content-Type": "application/json", **headers})
                yes += line.getresponse().status < YES
            finally:
                line.close()
        return yes

    async def key(self, name: str, *more: str) -> dict[str, str]:
        """Make a key for a program; return what shows it."""
        return await asyncio.to_thread(key_headers, self.config, name, *more)

    async def say(self, who: str, text: str, times: int) -> None:
        """Have somebody say something so many times, in their private chat."""
        await self.control.backlog(self.people[who], self.people[who], text, times)


async def _stranger(site: SecuritySite, times: int) -> int:
    await site.say("Mallory", ORDER, times)
    return 0


async def _wrong_scope(site: SecuritySite, times: int) -> int:
    await site.say("Vi", ORDER, times)
    return 0


async def _revoked_person(site: SecuritySite, times: int) -> int:
    await site.rosic("revoke", "Ro")
    await site.say("Ro", ORDER, times)
    return 0


async def _guessed(site: SecuritySite, times: int) -> int:
    guests = [await site.control.create_user(f"Guest {number}") for number in range(times)]
    for guest in guests:
        await site.control.say(guest, guest, f"/start {token_hex(5)}")
    await site.settled()
    said = [await site.control.messages(guest, by_bot=True) for guest in guests]
    return sum(any(INVITED in (each["text"] or "") for each in told) for told in said)


async def _edited(site: SecuritySite, times: int) -> int:
    bo = site.people["Bo"]
    message = await site.control.say(bo, bo, "status cell")
    for _ in range(times):
        await site.control.edit(bo, message, ORDER)
    return 0


async def _forged_tap(site: SecuritySite, times: int) -> int:
    bo = site.people["Bo"]
    await await_answer(site.control, bo)
    message = (await site.control.messages(bo, by_bot=True))[-1]["message_id"]
    for _ in range(times):
        await site.control.tap(bo, bo, message, token_hex(11), forged=True)
    return 0


async def _replayed(site: SecuritySite, times: int) -> int:
    bo = site.people["Bo"]
    for _ in range(times):
        await site.control.call("duplicate", new_id=True)
        await site.control.say(bo, bo, ORDER)
    await site.settled()
    return -times  # each is an order once, and an attempt the second time


async def _unknown_key(site: SecuritySite, times: int) -> int:
    return await site.order(times, {"Authorization": f"Bearer rosic_k0_{token_hex(16)}"})


async def _revoked_key(site: SecuritySite, times: int) -> int:
    headers = await site.key("revoked")
    await site.rosic("key", "revoke", headers["Authorization"].split("_")[1])
    return await site.order(times, headers)


async def _expired_key(site: SecuritySite, times: int) -> int:
    headers = await site.key("expired", "--for", f"{ENDS_S}s")
    ends_s = time.monotonic() + ENDS_S
    while time.monotonic() <= ends_s:  # noqa: ASYNC110 - the clock is what is waited for
        await asyncio.sleep(LOOK_S)
    return await site.order(times, headers)


async def _foreign_origin(site: SecuritySite, times: int) -> int:
    headers = await site.key("page")
    return await site.order(times, {**headers, "Origin": "https://elsewhere.example"})


KINDS: Final[tuple[tuple[str, Callable[[SecuritySite, int], Awaitable[int]]], ...]] = (
    ("a stranger's order", _stranger),
    ("an order without the right", _wrong_scope),
    ("an order after access was taken back", _revoked_person),
    ("a guessed join code", _guessed),
    ("a message that is edited into an order", _edited),
    ("a tap on a button that never was", _forged_tap),
    ("an order that the platform brings twice", _replayed),
    ("a key of the API that never was", _unknown_key),
    ("a key of the API that was taken back", _revoked_key),
    ("a key of the API that has ended", _expired_key),
    ("a page of another site, with a good key", _foreign_origin),
)
"""Each tries so many times, and returns the yeses that it got; less what was no attempt."""


class AttemptFigures(NamedTuple):
    """What became of attempts of one kind.

    Attributes:
        through: How many were let through.
        listed, told: By how much the security report, and the admin's chat, grew.
        tried: Whether what is tried could have been let through.
    """

    name: str
    attempts: int
    through: int
    listed: int
    told: int
    tried: bool = True


async def attempted(
    attempts: int, roles: dict[str, str] | None = None
) -> AsyncIterator[AttemptFigures]:
    """Try everything at a gateway of its own.

    Args:
        attempts: Of each kind.
        roles: Of people by name, where they are not as usual.
    """
    with tempfile.TemporaryDirectory(prefix="rosic-bench-") as name:
        folder = Path(name)
        async with stand_in() as control:
            await control.call("set_limits", limits=None)
            known = ROLES | (roles or {})
            people = {who: await control.create_user(who) for who in (*known, "Mallory")}
            port, metrics = free_port(), free_port()
            config = CONFIG.format(
                token=TOKEN,
                api_base=control.api_base,
                listen=f"{LOCAL}:{port}",
                metrics=f"{LOCAL}:{metrics}",
            )
            for who, role in known.items():
                config += PERSON.format(name=who, account=people[who], role=role)
            (folder / "cell.yaml").write_text(CELL, encoding="utf-8")
            with gateway_process(folder, config, port):
                site = SecuritySite(control, people, folder / "rosic.toml", port, metrics)
                await await_answer(control, people["Ada"])
                before = await site.counts()
                for kind, attempt in KINDS:
                    yes = await attempt(site, attempts)
                    await site.settled()
                    after = await site.counts()
                    yield _tried(kind, attempts, yes, after.since(before))
                    before = after


def _tried(kind: str, attempts: int, yes: int, grown: SiteCounts) -> AttemptFigures:
    own = 1  # the answer that `settled` asks the gateway for
    return AttemptFigures(
        kind,
        attempts,
        max(grown.acts + min(yes, 0), yes, 0),
        grown.listed,
        max(0, grown.told - own),
        tried=yes >= 0 or grown.acts > 0,  # what is repeated has to be done the first time
    )


# ---- the bench ----


def measure(recorder: BenchRecorder) -> BenchReport:
    """Time authentication, then try everything.

    Args:
        recorder: Is told how far it is; keeps what was seen if it is interrupted.

    Raises:
        ConfigurationError: The gateway does not start.
    """
    samples = QUICK_SAMPLES if recorder.quick else SAMPLES
    attempts = QUICK_ATTEMPTS if recorder.quick else ATTEMPTS
    seen: list[AttemptFigures] = []

    def so_far() -> BenchReport:
        return report_of(recorder, seen, samples, attempts)

    async def all_of_it() -> None:
        await _times(recorder, samples)
        async for figures in attempted(attempts):
            seen.append(figures)  # noqa: PERF401 - what was seen before an interrupt counts

    recorder.report_by(so_far)
    runtime.run(all_of_it())
    return so_far()


def report_of(
    recorder: BenchRecorder, seen: Sequence[AttemptFigures], samples: int, attempts: int
) -> BenchReport:
    """Return what follows from what was seen."""
    through = sum(one.through for one in seen)
    tried = sum(one.attempts for one in seen)
    columns = ("attempt", "attempts", "refused", "let through", "listed", "told the admin")
    rows = tuple(
        (one.name, one.attempts, one.attempts - one.through, one.through, one.listed, one.told)
        for one in seen
    )
    return BenchReport(
        machine=machine(),
        method=METHOD.format(samples=samples, attempts=attempts),
        cases=recorder.cases(tails=True),
        findings=(REFUSED.format(attempts=tried, kinds=len(seen), through=through),),
        failures=tuple(
            THROUGH.format(name=one.name, through=one.through, attempts=one.attempts)
            if one.through
            else NOTHING_TRIED.format(name=one.name)
            for one in seen
            if one.through or not one.tried
        ),
        tables=(BenchTable(title="Attempts", columns=columns, rows=rows),),
    )
