"""From a configuration to a gateway: which adapters, which record, whose."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING
from zoneinfo import ZoneInfo

from rosic.app.features import command_table
from rosic.app.runtime import face_of
from rosic.app.settings import GatewayParts, GatewaySettings
from rosic.config.plugins import demand_good, messenger_factory, robot_factory, shared_spaces
from rosic.config.profiles import known_units
from rosic.contracts.console import SupportsCompletion
from rosic.contracts.messenger import is_account
from rosic.core.secret import Secret
from rosic.errors import ConfigurationError
from rosic.foxglove.recorder import recorder
from rosic.interpreters.chat_completions import ChatCompletions
from rosic.rendering.renderer import renderer
from rosic.stores.database import DatabaseStore
from rosic.stores.record_mark import STOPS
from rosic.stores.stop_latch import FileLatch

if TYPE_CHECKING:
    from rosic.app.api import GatewayApi
    from rosic.app.config import Config, MessengerSettings
    from rosic.contracts.clock import Clock, Entropy
    from rosic.contracts.messenger import Messenger

log = logging.getLogger("rosic.gateway")


def parts_of(
    config: Config,
    latch: FileLatch,
    clock: Clock,
    entropy: Entropy,
    api: GatewayApi | None = None,
) -> GatewayParts:
    """Make the adapters of a configuration. Nothing is opened, nothing is written.

    Args:
        config: What it is seeded with.
        latch: Of its data folder; whoever made it closes it, after the gateway.
        clock: The gateway's.
        entropy: The gateway's.
        api: What programs and the page speak by; None: nothing listens.

    Raises:
        ConfigurationError: An adapter is not there, or does not take its settings; or an address
            can be nobody's there.
    """
    messengers = messengers_of(config.messengers, clock)
    if api is not None:
        messengers = (*messengers, *api.messengers)
    for messenger in messengers:
        for wrong in nobodies(config, messenger):
            raise wrong
        if isinstance(messenger, SupportsCompletion):
            messenger.know(config.robots, command_table())
    for profile in config.robots:
        demand_good(profile, robot_factory(profile.link.kind), clock, str(config.path))
    for text in shared_spaces(config.robots):
        log.warning("%s", text)
    return GatewayParts(
        messengers=messengers,
        robot_factory=robot_factory,
        store=DatabaseStore(
            config.data, clock=clock, kept=latch.kept, begin_anew=config.begin_anew
        ),
        latch=latch,
        clock=clock,
        entropy=entropy,
        units=known_units(),
        face=face_of(ZoneInfo(config.zone)),
        renderer=renderer(),
        recorder=recorder(),
        interpreter=None if config.interpreter is None else ChatCompletions(config.interpreter),
    )


def latch_of(config: Config) -> FileLatch:
    """Return where the stops of a gateway are kept, besides its record."""
    # Robots that are gone keep their places: there is room for as many again.
    return FileLatch(config.data / STOPS, robots_min=2 * len(config.robots))


def settings_of(config: Config) -> GatewaySettings:
    """Return what a gateway is made with, besides its adapters."""
    return GatewaySettings(
        profiles=config.robots,
        people=config.people,
        rulebook=config.rulebook,
        place=config.name,
        zone=config.zone,
        limit=config.limits,
        robot_limits=config.robot_limits,
        robot_limit=config.robot_limit,
        keep=config.keep,
        room=config.room,
        lease_idle_s=config.lease_idle_s,
        missions=config.missions,
    )


def nobodies(config: Config, messenger: Messenger) -> Iterator[ConfigurationError]:
    """Say which addresses no account of a messenger can have: nobody could write as them."""
    for person in config.people:
        for address in person.addresses:
            if address.platform == messenger.platform and not is_account(
                messenger, address.account
            ):
                yield ConfigurationError(
                    f"{address.platform}:{address.account} of {person.name} is no account's id.",
                    where=str(config.path),
                    hint="Give the account's number or id, not a name, which can pass to others.",
                )


def messengers_of(tables: Iterable[MessengerSettings], clock: Clock) -> tuple[Messenger, ...]:
    """Make the messengers. Nothing is opened.

    Raises:
        ConfigurationError: The first that is wrong, with its file and line.
    """
    return tuple(messenger_of(table, clock) for table in tables)


def messenger_of(table: MessengerSettings, clock: Clock) -> Messenger:
    """Make one messenger.

    Raises:
        ConfigurationError: It is not there, or does not take its settings; with file and line.
    """
    try:
        return messenger_factory(table.kind)(table.name, table.settings, clock)
    except ConfigurationError as wrong:
        if wrong.where:
            raise
        raise ConfigurationError(str(wrong), where=table.where) from wrong


def secrets_of(config: Config) -> list[Secret]:
    """Return every secret of the configuration, for masking them."""
    found = [secret for table in config.messengers for secret in _secrets(table.settings)]
    found += [webhook.secret for webhook in config.webhooks]
    asked = config.interpreter
    return found if asked is None or asked.key is None else [*found, asked.key]


def _secrets(value: object) -> list[Secret]:
    if isinstance(value, Secret):
        return [value]
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, list | tuple):
        return [secret for item in value for secret in _secrets(item)]
    return []
