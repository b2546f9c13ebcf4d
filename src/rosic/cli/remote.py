"""Commands against a gateway elsewhere: ``--url`` and ``--key-file``, or ROSIC_URL and ROSIC_KEY.

Nothing of a gateway has to be on this machine: no configuration, no data, no server.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

import msgspec

from rosic.core.i18n import joined, plain
from rosic.errors import ConfigurationError, OutOfBounds, how_to_install

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from rosic.api.resource_schemas import HistoryEntryOut
    from rosic.api.schemas import OrderOut, RobotOut
    from rosic.client import ClientError, RosicClient

URL, KEY, CA = "ROSIC_URL", "ROSIC_KEY", "ROSIC_CA"
GOOD_STATES: Final = frozenset({"done", "sent"})
PROGRESS_S: Final = 1.0
"""How far an order is, is shown at most so often."""
LISTED: Final = 50
AT_MOST: Final = 1_000
ALWAYS_S: Final = 3e8
NOT_YET: Final = frozenset({"asked", "not-done"})
"""States of an answer: nothing was done, or somebody has to agree first."""


def add_gateway(parser: argparse.ArgumentParser) -> None:
    """Let a command be told of a gateway elsewhere."""
    there = parser.add_argument_group("a gateway elsewhere")
    there.add_argument("--url", metavar="URL", help=f"https://robots.example.org (or {URL})")
    there.add_argument("--key-file", metavar="FILE", help=f"holds your key (or {KEY})")
    there.add_argument("--ca", metavar="FILE", help=f"who signed its certificate (or {CA})")
    there.add_argument(
        "--unencrypted", action="store_true", help="without TLS: others may read the key"
    )


def url_of(options: argparse.Namespace, *, here: bool = False) -> str:
    """Return where the gateway is that is meant; empty: on this machine.

    Args:
        options: As parsed.
        here: A configuration or a data folder is named, so this machine is meant, whatever stands
            in ROSIC_URL.

    Raises:
        OutOfBounds: Both are named.
    """
    if options.url and here:
        raise OutOfBounds("Name a gateway elsewhere (--url) or one of this machine, not both.")
    return options.url or ("" if here else os.environ.get(URL, ""))


def run_there(
    options: argparse.Namespace, url: str, what: Callable[[RosicClient], Awaitable[int]]
) -> int:
    """Do something with a gateway elsewhere. Return the exit status.

    Raises:
        RosicError: Why not.
    """
    return asyncio.run(_run_there(options, url, what))


async def _run_there(
    options: argparse.Namespace, url: str, what: Callable[[RosicClient], Awaitable[int]]
) -> int:
    try:
        from rosic.client import RosicClient  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise ConfigurationError(
            f"To ask a gateway elsewhere, a library is needed that is not here ({error.name}).",
            hint=f"Run: {how_to_install('client')}",
        ) from error
    ca = options.ca or os.environ.get(CA, "")
    key = _key(options)
    async with RosicClient(url, key, ca=ca, unencrypted=options.unencrypted) as client:
        return await what(client)


def _key(options: argparse.Namespace) -> str:
    if options.key_file is None:
        key = os.environ.get(KEY, "")
        if not key:
            raise ConfigurationError(
                "No key is named, and the gateway asks who you are.",
                hint=f"Name a file that holds it with --key-file, or set {KEY}.",
            )
        return key
    path = Path(options.key_file).expanduser()
    try:
        return path.read_text("utf-8").strip()
    except OSError as error:
        raise ConfigurationError(f"{path} cannot be read ({error.strerror}).") from error
    except UnicodeError as error:
        raise ConfigurationError(f"{path} cannot be read (it is no text).") from error


# ---- what is asked there ----


async def status(client: RosicClient, robots: Sequence[str], *, json: bool) -> int:
    """Print how robots are."""
    found = await client.robots()
    known = {robot.id: robot for robot in found}
    shown = found if not robots else [known[name] for name in robots if name in known]
    if json:
        print_json(shown)
    for robot in () if json else shown:
        print(_robot_line(robot))
    missing = [name for name in robots if name not in known]
    for name in missing:
        print(f"There is no robot {name!r} there that you may see.", file=sys.stderr)
    return 1 if missing else 0


def _robot_line(robot: RobotOut) -> str:
    presence = robot.presence
    if presence.online is False:
        state = "not there"
    elif presence.doing:
        state = f"does {presence.doing}"
    else:
        state = {True: "at rest", False: "moves", None: "rest not measured"}[presence.at_rest]
    parts = [robot.name, state]
    parts += ["stopped"] if robot.stopped else []
    parts += [f"held by {robot.holder}"] if robot.holder else []
    return plain("  ".join(parts))


async def stop(client: RosicClient, robots: Sequence[str]) -> int:
    """Stop, and go on asking until it is answered. Return 1 unless rest was measured."""
    told: set[str] = set()

    def trouble(why: ClientError) -> None:
        sentence = str(why)
        if sentence not in told:
            told.add(sentence)
            print(
                f"rosic: {sentence} The stop is not answered yet; I ask again until it is. Use the "
                "robot's own stop button.",
                file=sys.stderr,
                flush=True,
            )

    answer = await client.stop(*robots, on_trouble=trouble)
    print(answer.text, file=sys.stdout if answer.at_rest else sys.stderr)
    return 0 if answer.at_rest else 1


async def say(client: RosicClient, line: str) -> int:
    """Say a line as in a chat, and print the answer. Return 1 unless it is done by that."""
    answer = await client.chat(line)
    good = answer.state not in NOT_YET
    print(answer.text, file=sys.stdout if good else sys.stderr)
    return 0 if good else 1


def order_line(order: OrderOut) -> str:
    """Return an order in one line."""
    at = order.stages[0].at if order.stages else ""
    fraction = "" if order.over or order.fraction is None else f" {order.fraction:.0%}"
    parts = (at, order.who, order.robot, order.sent or order.skill, f"{order.state}{fraction}")
    why = order.note or (order.text if order.over else "")
    return plain(joined("  ", [part for part in (*parts, why) if part]))


def print_json(found: object) -> None:
    """Print one thing, for programs."""
    print(msgspec.json.encode(found).decode())


# ---- ``rosic order`` ----

ORDER_ABOUT = """Give an order to a robot of a gateway elsewhere: rosic order omni move distance=0.5
direction=left. Values are in the units that the skill declares. The exit status is 0 once it is
accepted; with --wait, once it is done."""


def order(arguments: Sequence[str]) -> int:
    """Give an order. Return 1 if it was not done.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic order", description=ORDER_ABOUT)
    parser.add_argument("robot", metavar="ROBOT")
    parser.add_argument("skill", metavar="SKILL")
    parser.add_argument("values", metavar="NAME=VALUE", nargs="*")
    parser.add_argument("--check", action="store_true", help="say what it would come to; no more")
    parser.add_argument("--wait", action="store_true", help="show how it goes, until it is over")
    parser.add_argument(
        "--key", metavar="TEXT", default="", help="the same again is the same order"
    )
    add_gateway(parser)
    options = parser.parse_args(arguments)
    values = _values(options.values)
    return run_there(options, there(options), lambda client: _order(client, options, values))


async def _order(
    client: RosicClient, options: argparse.Namespace, values: dict[str, float | str]
) -> int:
    if options.check:
        found = await client.check(options.robot, options.skill, values)
        needs = f"; first: {', '.join(found.needs)}" if found.needs else ""
        print(plain(f"{options.robot}: {found.sent}{needs}. Nothing was done."))
        return 0 if found.allowed else 1
    placed = await client.order(options.robot, options.skill, values, key=options.key)
    if placed.text:
        print(plain(placed.text))
    if not options.wait:
        print(order_line(placed))
        return 0
    last, shown, shown_s = placed, None, 0.0
    async for last in client.follow(placed):
        now_s = time.monotonic()
        if is_news(last, shown, now_s - shown_s):
            shown, shown_s = last, now_s
            print(order_line(last), flush=True)
    return 0 if last.state in GOOD_STATES else 1


def is_news(order: OrderOut, shown: OrderOut | None, since_s: float) -> bool:
    """Whether an order is shown again: at another stage, or once a second as it goes on."""
    if shown is None or order.state != shown.state or order.over:
        return True
    return since_s >= PROGRESS_S and order_line(order) != order_line(shown)


def _values(texts: Sequence[str]) -> dict[str, float | str]:
    """Return values by their names.

    Raises:
        OutOfBounds: One is no value with a name.
    """
    found: dict[str, float | str] = {}
    for text in texts:
        name, sign, value = text.partition("=")
        if not (sign and name and value):
            raise OutOfBounds(f"{text!r} is no NAME=VALUE, as distance=0.5 is. Nothing was done.")
        if name in found:
            raise OutOfBounds(f"{name} is said twice. Nothing was done.")
        try:
            found[name] = float(value)
        except ValueError:
            found[name] = value
    return found


# ---- ``rosic orders`` ----

ORDERS_ABOUT = """The newest orders of a gateway elsewhere, the newest last; with --follow, and what
happens from then on."""


def orders(arguments: Sequence[str]) -> int:
    """Print orders.

    Raises:
        RosicError: Why not.
    """
    parser = argparse.ArgumentParser(prog="rosic orders", description=ORDERS_ABOUT)
    parser.add_argument("--robot", metavar="ROBOT", default="", help="of one robot")
    parser.add_argument("--follow", action="store_true", help="until Ctrl-C")
    parser.add_argument("--json", action="store_true", help="one list, for programs")
    add_gateway(parser)
    options = parser.parse_args(arguments)
    if options.follow and options.json:
        raise OutOfBounds("--follow and --json do not go together.")
    what = _follow if options.follow else _list
    return run_there(options, there(options), lambda client: what(client, options))


async def _list(client: RosicClient, options: argparse.Namespace) -> int:
    found = await client.orders(options.robot, limit=LISTED)
    if options.json:
        print_json(found)
    for order in () if options.json else reversed(found):
        print(order_line(order))
    return 0


async def _follow(client: RosicClient, options: argparse.Namespace) -> int:
    from rosic.api.event_schemas import OrderEvent  # noqa: PLC0415 - with the client
    from rosic.client.events import Connected, Disconnected  # noqa: PLC0415 - an extra

    shown: dict[str, str] = {}
    async for event in client.events("orders"):
        if isinstance(event, Disconnected):
            print(f"rosic: {event.why}", file=sys.stderr, flush=True)
        elif isinstance(event, Connected) and shown:
            print("rosic: The connection stands again.", file=sys.stderr, flush=True)
        elif isinstance(event, OrderEvent) and options.robot in {"", event.order.robot}:
            text = order_line(event.order)
            if shown.get(event.order.id) != text:
                shown[event.order.id] = text
                print(text, flush=True)
    return 0


def there(options: argparse.Namespace) -> str:
    """Return where the gateway is that a command needs.

    Raises:
        ConfigurationError: None is named.
    """
    url = url_of(options)
    if not url:
        raise ConfigurationError("No gateway is named.", hint=f"Name one with --url, or set {URL}.")
    return url


# ---- ``rosic history`` ----


async def history(client: RosicClient, robot: str, since_s: float | None, *, json: bool) -> int:
    """Print what was asked before, the newest last."""
    limit = LISTED if since_s is None else AT_MOST
    found = await client.history(
        robot, since_s=ALWAYS_S if since_s is None else since_s, limit=limit
    )
    if json:
        print_json(found[::-1])
    for one in () if json else reversed(found):
        print(_history_line(one))
    return 0


def _history_line(one: HistoryEntryOut) -> str:
    what = one.asked or joined(": ", [part for part in (one.robot, one.skill or one.kind) if part])
    parts = (one.at, one.who, what, one.outcome, one.came)
    return plain(joined("  ", [part for part in parts if part]))


async def history_table(client: RosicClient, robot: str, since_s: float | None) -> int:
    """Write what was asked before as comma-separated values."""
    found = await client.history_table(robot, since_s=ALWAYS_S if since_s is None else since_s)
    sys.stdout.flush()
    sys.stdout.buffer.write(found)
    sys.stdout.buffer.flush()
    return 0
