"""What encrypts and decrypts for one device: matrix-nio's, as nothing that is sent can end it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any

import nio
from nio.crypto import Olm

if TYPE_CHECKING:
    from rosic.messengers.matrix.replay_guard import ReplayGuard

log = logging.getLogger("rosic.messengers.matrix")


class OlmMachine(Olm):  # type: ignore[misc] # matrix-nio has no types
    """Passes over what cannot be decrypted, whatever it makes the libraries raise.

    Otherwise a sync with one such event of a stranger would fail, and be asked for again for ever,
    with a stop behind it.
    """

    def refuse_replays(self, guard: ReplayGuard) -> None:
        """Have what was decrypted in earlier runs known, too."""
        self.message_index_store = guard

    def handle_to_device_event(self, event: Any) -> Any:  # noqa: ANN401
        """Return what came to this device as it was written; None where it is passed over."""
        try:
            return super().handle_to_device_event(event)
        except Exception:
            log.exception("a message to this device was passed over")
            return None

    def decrypt_megolm_event(self, event: Any, room_id: str | None = None) -> Any:  # noqa: ANN401
        """Return an event of a room as it was written.

        Raises:
            nio.EncryptionError: It cannot be decrypted, or is no event.
        """
        try:
            return super().decrypt_megolm_event(event, room_id)
        except nio.EncryptionError:
            raise
        except Exception as error:
            name = type(error).__name__
            raise nio.EncryptionError(f"what was decrypted is no event: {name}") from error

    def handle_key_verification(self, event: object) -> None:
        """Leave verifications to us, for rooms as well: matrix-nio would answer by itself."""


class AccountClient(nio.AsyncClient):  # type: ignore[misc] # matrix-nio has no types
    """The client of matrix-nio, with our machine."""

    def load_store(self) -> None:
        """Open what is kept of the device's sessions."""
        kept = self.config
        self.store = kept.store(
            self.user_id, self.device_id, self.store_path, kept.pickle_key, kept.store_name
        )
        self.olm = OlmMachine(self.user_id, self.device_id, self.store)
        self.encrypted_rooms = self.store.load_encrypted_rooms()
