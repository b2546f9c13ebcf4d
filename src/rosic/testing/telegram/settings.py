"""What a test may choose about the server, with Telegram's values as the defaults."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from rosic.core.time_units import DAY_S, HOUR_S

if TYPE_CHECKING:
    from collections.abc import Callable


# ---- clock ----

# The server's own time: the machine's, moved forwards or backwards by a test.


class ServerClock:
    """Wall time of the pretended Telegram.

    Args:
        wall_s: Unix time in seconds, with a fraction.
        shift_s: How far this server is ahead of it.
    """

    def __init__(self, wall_s: Callable[[], float], shift_s: float = 0.0) -> None:
        self._wall_s = wall_s
        self.shift_s = shift_s
        self.date_shift_s = 0.0

    def now_s(self) -> float:
        """Return the server's time in seconds; retention and limits run on it."""
        return self._wall_s() + self.shift_s

    def date(self) -> int:
        """Return the date that Telegram puts on a message now, in whole seconds."""
        return int(self.now_s() + self.date_shift_s)

    def advance(self, seconds: float) -> None:
        """Move the server's time, backwards too. Waiting polls keep waiting."""
        self.shift_s += seconds

    def shift_dates(self, seconds: float) -> None:
        """Be off by this much in the dates alone."""
        self.date_shift_s = seconds


# ---- settings ----


class Limits(msgspec.Struct, frozen=True, kw_only=True):
    """Flood limits of https://core.telegram.org/bots/faq#my-bot-is-hitting-limits-how-do-i-avoid-this.

    That page says: about one message a second in one chat, short bursts allowed; not more than 20
    messages a minute in one group; about 30 messages a second overall. How large a burst may be is
    not published; edits counting like messages is common experience.

    Attributes:
        chat_per_s: Messages and edits a second to one chat, once the burst is spent.
        chat_burst: How many may come at once.
        group_per_min: In any 60 s to one group or supergroup or channel.
        overall_per_s: In any second, to all chats together.
        min_retry_after_s: The least wait that is asked for.
    """

    chat_per_s: float = 1.0
    chat_burst: int = 5
    group_per_min: int = 20
    overall_per_s: float = 30.0
    min_retry_after_s: int = 1


class Settings(msgspec.Struct, frozen=True, kw_only=True):
    """The bot, and the sizes and times that Telegram keeps.

    Attributes:
        bot_name: Its first name. Its id is the number before the colon of the token.
        bot_username: Without the @.
        privacy: Privacy mode, on by default
            (https://core.telegram.org/bots/features#privacy-mode).
        update_lifetime_s: "not kept longer than 24 hours"
            (https://core.telegram.org/bots/api#getting-updates).
        press_lifetime_s: How long a press waits for a poll; the published server keeps it 150 s.
        answer_window_s: How long a press can be answered. Telegram's docs are silent; about 15 s is
            common experience.
        conflict_pause_s: The published server answers the first 409 at once and, for this long
        after
            it, every further one with this delay.
        max_upload_bytes: "50 MB for other types" (https://core.telegram.org/bots/api#sending-files);
            a local server takes 2000 MB (https://core.telegram.org/bots/api#using-a-local-bot-api-server).
        max_download_bytes: "up to 20MB in size" (https://core.telegram.org/bots/api#getfile).
        link_lifetime_s: "guaranteed that the link will be valid for at least 1 hour"
            (https://core.telegram.org/bots/api#getfile); here not a moment longer.
        local_folder: Where a local server (``--local``) leaves files: getFile gives a path below
            it, and there are no downloads. Empty for Telegram's own servers.
        idle_poll_s: The published server stretches a short poll that repeats the same offset within
            3 s to this timeout. 0 switches it off, so that tests need not wait for it.
    """

    max_upload_bytes: int = 50 * 1024 * 1024
    max_download_bytes: int = 20 * 1024 * 1024
    bot_name: str = "Robot gateway"
    bot_username: str = "rosic_test_bot"
    privacy: bool = True
    update_lifetime_s: float = float(DAY_S)
    press_lifetime_s: float = 150.0
    answer_window_s: float = 15.0
    conflict_pause_s: float = 3.0
    link_lifetime_s: float = float(HOUR_S)
    local_folder: str = ""
    idle_poll_s: float = 0.0
