"""The API of a gateway: the messengers by which programs and people on the page speak to it."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Final

from rosic.config.plugins import LANGUAGES, catalogue
from rosic.console.pages import ConsolePages
from rosic.errors import ConfigurationError, how_to_install
from rosic.gateway.programs import ProgramService

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rosic.api.server import ApiServer
    from rosic.api.settings import ApiSettings
    from rosic.api.webhooks.settings import WebhookSettings
    from rosic.api.webhooks.watcher import WebhookWatcher
    from rosic.app.gateway import Gateway
    from rosic.contracts.clock import Clock
    from rosic.contracts.messenger import Messenger

NAMES: Final = ("api", "page")


def webhooks_of(gateway: Gateway, hooks: Sequence[WebhookSettings]) -> WebhookWatcher:
    """Return what tells others elsewhere what happens in a gateway that is open.

    Raises:
        ConfigurationError: What it needs is not installed.
    """
    try:
        from rosic.api.webhooks.watcher import WebhookWatcher  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise ConfigurationError(
            f"Webhooks need a library that is not installed ({error.name}).",
            hint=f"Run: {how_to_install('client')}",
        ) from error
    return WebhookWatcher(gateway.kernel, hooks)


class GatewayApi:
    """What the API adds to a gateway: two messengers before it opens, a server after.

    Args:
        settings: How it is served.
        clock: The gateway's.

    Raises:
        ConfigurationError: What it needs is not installed.
    """

    def __init__(self, settings: ApiSettings, clock: Clock) -> None:
        try:
            from rosic.api.page_messenger import PageMessenger  # noqa: PLC0415 - an extra
            from rosic.api.server import ApiServer  # noqa: PLC0415 - an extra
            from rosic.messengers.program.messenger import ProgramMessenger  # noqa: PLC0415
            from rosic.messengers.program.standstill import (  # noqa: PLC0415
                StandstillWatch,
                running_ns,
            )
        except ImportError as error:
            raise ConfigurationError(
                f"The API needs a library that is not installed ({error.name}).",
                hint=f"Run: {how_to_install('api')}",
            ) from error
        self._settings, self._server = settings, ApiServer
        standstill = StandstillWatch(running_ns)
        self._program = ProgramMessenger(NAMES[0], clock, standstill)
        self._page = PageMessenger(NAMES[1], clock, standstill)

    @property
    def messengers(self) -> tuple[Messenger, ...]:
        """By which it speaks; the gateway listens to them."""
        return (self._program, self._page)

    def server_of(self, gateway: Gateway) -> ApiServer:
        """Return what serves the API of a gateway that is open."""
        gateway.kernel.shared.page_url.provide(self._settings.reached_at)
        programs = ProgramService(gateway.rooms, gateway.access.programs)
        messengers = (self._program, self._page)
        languages = {code: found for code in LANGUAGES if (found := catalogue(code)) is not None}
        pages = partial(ConsolePages, catalogues=languages)
        return self._server(
            gateway.kernel, self._settings, messengers, programs, gateway.languages, pages
        )
