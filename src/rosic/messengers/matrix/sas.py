"""Two devices and two people make sure that nobody is between them: seven emoji, compared by eye.

Matrix specification v1.11, client-server API, "Short Authentication String (SAS) verification",
from ``m.key.verification.start`` to ``m.key.verification.mac``. Nothing here sends or waits. The
machine of matrix-nio is not used: it knows no verification in rooms and no master keys, and its
commitment and its emoji are not those of the specification.
"""

from __future__ import annotations

import enum
import hashlib
from typing import TYPE_CHECKING, Any, Final

import msgspec
import vodozemac

from rosic.contracts.verification import ShownCode
from rosic.messengers.matrix.emoji import EMOJI
from rosic.messengers.matrix.signed_json import (
    ED25519,
    KEY_BYTES,
    NotCanonical,
    canonical_json,
    from_base64,
    to_base64,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

METHOD: Final = "m.sas.v1"
AGREEMENT: Final = "curve25519-hkdf-sha256"
HASH: Final = "sha256"
MAC: Final = "hkdf-hmac-sha256.v2"
SHOWN_AS: Final = ("emoji", "decimal")
KEY_LIST: Final = "KEY_IDS"
KEYS_AT_MOST: Final = 16

START: Final = "m.key.verification.start"
ACCEPT: Final = "m.key.verification.accept"
KEY: Final = "m.key.verification.key"
MACS: Final = "m.key.verification.mac"

Content = dict[str, Any]
Message = tuple[str, Content]


class SasPhase(enum.Enum):
    """How far it has come."""

    BEGUN = "begun"
    AGREED = "agreed"
    SHOWN = "shown"
    DONE = "done"


class SasCancel(Exception):
    """It must end here, and the other is told why.

    Attributes:
        code: Of the specification: ``m.key_mismatch``.
    """

    def __init__(self, code: str, reason: str) -> None:
        super().__init__(reason)
        self.code = code


class SasEnd(msgspec.Struct, frozen=True, kw_only=True):
    """One of the two ends.

    Attributes:
        user: The account.
        device: Its device.
        keys: By key id (``ed25519:`` and a name): of our own end, what the other is to vouch for;
            of the other, what the homeserver shows, and whether it is theirs is found out here.
    """

    user: str
    device: str
    keys: dict[str, str]

    @property
    def device_key_id(self) -> str:
        """Id of the device's fingerprint."""
        return f"{ED25519}:{self.device}"


class SasExchange:
    """One exchange, as one of the two ends.

    Args:
        verification: Its id, the same at both ends.
        ours: Our end.
        theirs: The other.
        frame: Adds to a content what ties it to this verification.

    Attributes:
        phase: How far it has come.
        has_started: We have sent a start.
        compared: Ids of those of their keys that are theirs, once it is done.
    """

    def __init__(
        self, verification: str, ours: SasEnd, theirs: SasEnd, frame: Callable[[Content], Content]
    ) -> None:
        self.phase = SasPhase.BEGUN
        self.has_started = False
        self.compared: frozenset[str] = frozenset()
        self._verification = verification
        self._ours = ours
        self._theirs = theirs
        self._frame = frame
        self._sas = vodozemac.Sas()
        self._own_public = self._sas.public_key.to_base64()
        self._established: vodozemac.EstablishedSas | None = None
        self._start: Content = {}
        self._commitment = ""
        self._shown_as: tuple[str, ...] = SHOWN_AS
        self._their_public = ""
        self._confirmed = False
        self._yielded = False

    # ---- the one that starts ----

    def start(self) -> list[Message]:
        """Return what starts it."""
        self.has_started = True
        self._start = self._frame(
            {
                "from_device": self._ours.device,
                "method": METHOD,
                "key_agreement_protocols": [AGREEMENT],
                "hashes": [HASH],
                "message_authentication_codes": [MAC],
                "short_authentication_string": list(SHOWN_AS),
            }
        )
        return [(START, self._start)]

    def yield_start(self) -> None:
        """Both have started, and it is theirs that counts."""
        self.has_started, self._yielded, self._start = False, True, {}

    def accepted(self, content: Content) -> list[Message]:
        """They accept our start, and are bound to a key that we have not seen.

        Raises:
            SasCancel: It is not time for that, or they chose what was not offered.
        """
        if self._yielded:
            return []  # they accepted ours before they heard that it does not count
        if not self.has_started or self.phase is not SasPhase.BEGUN:
            raise SasCancel("m.unexpected_message", "That was not expected now.")
        chosen = (
            content.get("key_agreement_protocol"),
            content.get("hash"),
            content.get("message_authentication_code"),
        )
        if chosen != (AGREEMENT, HASH, MAC):
            raise SasCancel("m.unknown_method", "Something was chosen that was not offered.")
        self._shown_as = _shown_as(content)
        commitment = content.get("commitment")
        if not isinstance(commitment, str):
            raise SasCancel("m.invalid_message", "There is no commitment.")
        self._commitment = commitment
        self.phase = SasPhase.AGREED
        return [(KEY, self._frame({"key": self._own_public}))]

    # ---- the one that accepts ----

    def started(self, content: Content) -> list[Message]:
        """They start it. We are bound to our key before we see theirs.

        Raises:
            SasCancel: It is not time for that, or there is nothing that both of us know.
        """
        if self.has_started or self.phase is not SasPhase.BEGUN:
            raise SasCancel("m.unexpected_message", "That was not expected now.")
        if content.get("from_device") != self._theirs.device:
            raise SasCancel("m.invalid_message", "Another device than the one that was ready.")
        offered = (
            ("key_agreement_protocols", AGREEMENT),
            ("hashes", HASH),
            ("message_authentication_codes", MAC),
        )
        if content.get("method") != METHOD or not all(
            choice in _texts(content.get(name)) for name, choice in offered
        ):
            raise SasCancel("m.unknown_method", "There is no way that both of us know.")
        self._shown_as = _shown_as(content)
        self._start = content
        self.phase = SasPhase.AGREED
        return [
            (
                ACCEPT,
                self._frame(
                    {
                        "method": METHOD,
                        "key_agreement_protocol": AGREEMENT,
                        "hash": HASH,
                        "message_authentication_code": MAC,
                        "short_authentication_string": list(self._shown_as),
                        "commitment": _commitment(self._own_public, content),
                    }
                ),
            )
        ]

    # ---- both ----

    def key(self, content: Content) -> list[Message]:
        """Their key is there, so the code can be shown.

        Raises:
            SasCancel: It is not time for that, it is no key, or not the one they were bound to.
        """
        if self.phase is not SasPhase.AGREED or self._their_public:
            raise SasCancel("m.unexpected_message", "That was not expected now.")
        public = content.get("key")
        if not isinstance(public, str):
            raise SasCancel("m.invalid_message", "There is no key.")
        if self.has_started and _commitment(public, self._start) != self._commitment:
            raise SasCancel("m.mismatched_commitment", "The key is not the one that was promised.")
        try:
            theirs = vodozemac.Curve25519PublicKey.from_base64(public)
            self._established = self._sas.diffie_hellman(theirs)
        except ValueError:
            raise SasCancel("m.invalid_message", "That is no key.") from None
        self._their_public = public
        self.phase = SasPhase.SHOWN
        return [] if self.has_started else [(KEY, self._frame({"key": self._own_public}))]

    def shown(self) -> ShownCode:
        """Return what the two people compare.

        Raises:
            SasCancel: It is not time for that.
        """
        code = self._shared().bytes(self._code_info())
        as_emoji = "emoji" in self._shown_as
        return ShownCode(
            verification=self._verification,
            user=self._theirs.user,
            device=self._theirs.device,
            emoji=tuple(EMOJI[index] for index in code.emoji_indices) if as_emoji else (),
            decimals=() if as_emoji else tuple(code.decimals),
        )

    def confirm(self) -> list[Message]:
        """Our person says that the code is the same: vouch for our keys with it.

        Raises:
            SasCancel: It is not time for that.
        """
        if self.phase is not SasPhase.SHOWN or self._confirmed:
            raise SasCancel("m.unexpected_message", "There is nothing to confirm now.")
        self._confirmed = True
        macs = {key_id: self._mac(key, key_id) for key_id, key in self._ours.keys.items()}
        keys = self._mac(_list_of(macs), KEY_LIST)
        self._finish()
        return [(MACS, self._frame({"mac": macs, "keys": keys}))]

    def macs(self, content: Content) -> None:
        """Their person says so too; their keys must be those that the homeserver shows.

        The device's own must be among them. A cross-signing key that the homeserver does not show
        is one that it hides; what is no such key is passed over.

        Raises:
            SasCancel: It is not time for that, or a key is not theirs.
        """
        if self.phase is not SasPhase.SHOWN or self.compared:
            raise SasCancel("m.unexpected_message", "That was not expected now.")
        macs = content.get("mac")
        if not isinstance(macs, dict) or len(macs) > KEYS_AT_MOST:
            raise SasCancel("m.invalid_message", "There are no keys.")
        self._check(_list_of(macs), KEY_LIST, content.get("keys"))
        known = {key_id: key for key_id, key in self._theirs.keys.items() if key_id in macs}
        if self._theirs.device_key_id not in known:
            raise SasCancel("m.key_mismatch", "The key of the device is missing.")
        if any(map(_is_cross_signing, macs.keys() - known.keys())):
            raise SasCancel("m.key_mismatch", "Another key is shown than the one vouched for.")
        for key_id, key in known.items():
            self._check(key, key_id, macs[key_id])
        self.compared = frozenset(known)
        self._finish()

    def _shared(self) -> vodozemac.EstablishedSas:
        if self._established is None:
            raise SasCancel("m.unexpected_message", "There is nothing to compare yet.")
        return self._established

    def _finish(self) -> None:
        if self._confirmed and self.compared:
            self.phase = SasPhase.DONE

    def _code_info(self) -> str:
        ours = (self._ours.user, self._ours.device, self._own_public)
        theirs = (self._theirs.user, self._theirs.device, self._their_public)
        ends = (*ours, *theirs) if self.has_started else (*theirs, *ours)
        return "|".join(("MATRIX_KEY_VERIFICATION_SAS", *ends, self._verification))

    def _mac(self, said: str, key_id: str) -> str:
        info = self._mac_info(self._ours, self._theirs, key_id)
        return self._shared().calculate_mac(said, info)

    def _check(self, said: str, key_id: str, mac: object) -> None:
        if not isinstance(mac, str):
            raise SasCancel("m.invalid_message", "A key is not vouched for.")
        info = self._mac_info(self._theirs, self._ours, key_id)
        try:
            self._shared().verify_mac(said, info, mac)
        except ValueError:
            raise SasCancel("m.key_mismatch", "A key is not the one that was shown.") from None

    def _mac_info(self, sender: SasEnd, receiver: SasEnd, key_id: str) -> str:
        """Return what ties a key to its place ("MAC calculation")."""
        ends = (sender.user, sender.device, receiver.user, receiver.device)
        return "".join(("MATRIX_KEY_VERIFICATION_MAC", *ends, self._verification, key_id))


def _is_cross_signing(key_id: str) -> bool:
    """Whether an id is that of a key that is named by itself, as no device is."""
    algorithm, _, name = key_id.partition(":")
    return algorithm == ED25519 and from_base64(name, KEY_BYTES) is not None


def _list_of(macs: Mapping[str, object]) -> str:
    return ",".join(sorted(macs))


def _commitment(public: str, start: Content) -> str:
    try:
        said = canonical_json(start)
    except NotCanonical:
        raise SasCancel("m.invalid_message", "The start has no canonical form.") from None
    return to_base64(hashlib.sha256(public.encode() + said).digest())


def _shown_as(content: Content) -> tuple[str, ...]:
    found = tuple(
        way for way in SHOWN_AS if way in _texts(content.get("short_authentication_string"))
    )
    if not found:
        raise SasCancel("m.unknown_method", "There is no way to show it that both of us know.")
    return found


def _texts(value: object) -> list[str]:
    return [one for one in value if isinstance(one, str)] if isinstance(value, list) else []
