"""What one XMPP account needs."""

from __future__ import annotations

import re
import ssl
from typing import Annotated, Final, TypeAlias

import msgspec
from msgspec import Meta

from rosic.core.secret import Secret
from rosic.errors import ConfigurationError

ACCOUNT: Final = re.compile(r"^[^\s@/\"&'<>:A-Z]{1,200}@[a-z0-9]([a-z0-9.-]{0,200}[a-z0-9])?$")
"""A bare address as servers write it, in small letters."""
_LOOPBACK: Final = re.compile(r"localhost|127(?:\.\d{1,3}){3}|::1")
_Account: TypeAlias = Annotated[str, Meta(pattern=ACCOUNT.pattern)]


class XmppSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What one account needs.

    Attributes:
        user: ``robots@example.org``.
        host: Where its server is, if its domain does not say so by itself.
        ca: A file with the certificate of the server's authority, where the system has it not.
        rooms: Rooms to take part in. Who somebody is there is what the room's service says.
        nick: What it is called in rooms.
    """

    user: _Account
    password: Secret
    host: str = ""
    port: Annotated[int, Meta(gt=0, lt=2**16)] = 5222
    ca: str = ""
    rooms: tuple[_Account, ...] = ()
    nick: Annotated[str, Meta(pattern=r"^\w[\w .-]{0,60}$")] = "robots"

    @property
    def is_local(self) -> bool:
        """Whether the server is on this computer: it alone may be reached without encryption."""
        return _LOOPBACK.fullmatch(self.host) is not None

    def trust(self) -> ssl.SSLContext:
        """Return whose certificates are believed; reads ``ca``.

        Raises:
            ConfigurationError: There is no certificate in it.
        """
        try:
            return ssl.create_default_context(cafile=self.ca or None)
        except OSError as error:
            raise ConfigurationError(f"No certificate can be read in {self.ca}.") from error
