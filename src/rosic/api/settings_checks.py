"""What only the files and the robots that a configuration names can show to be wrong."""

from __future__ import annotations

import ssl
from typing import TYPE_CHECKING

from rosic.api.rosbridge.topics import check_topics
from rosic.errors import ConfigurationError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rosic.api.settings import ApiSettings
    from rosic.core.robot.profile import Profile, RobotId


def check_served(settings: ApiSettings, profiles: Mapping[RobotId, Profile]) -> None:
    """See that the API can be served so.

    Raises:
        ConfigurationError: The certificate or its key cannot be read or do not belong together, or
            a topic cannot be opened.
    """
    if settings.certificate:
        _check_certificate(settings.certificate, settings.private_key)
    check_topics(settings.topics, profiles)


def _check_certificate(certificate: str, private_key: str) -> None:
    for key, path in (("certificate", certificate), ("private_key", private_key)):
        try:
            with open(path, "rb"):  # noqa: PTH123 - it says which of the two, and why
                pass
        except OSError as error:
            raise ConfigurationError(
                f"{path} cannot be read ({error.strerror}).",
                where=f"api.{key}",
                hint="Name a file in PEM that the gateway may read.",
            ) from error
    try:
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, private_key, _no_word)
    except (ssl.SSLError, ValueError) as error:
        raise ConfigurationError(
            f"{certificate} and {private_key} are no certificate and its private key.",
            where="api.certificate",
            hint="Both are in PEM, belong together, and the key has no password.",
        ) from error


def _no_word() -> str:
    """Return no password: nobody is asked for one at a start."""
    return ""
