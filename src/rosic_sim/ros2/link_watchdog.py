"""Whether anybody is still there who could stop the robot."""

from __future__ import annotations

LINK_LOST_S = 1.0


class LinkWatchdog:
    """Hears the heartbeats of gateways, and says once when they cease.

    A motion that began while no gateway was heard, because somebody sends goals by hand, is not
    watched until one is.

    Args:
        lost_s: The link is lost after so long without one.
    """

    def __init__(self, lost_s: float = LINK_LOST_S) -> None:
        self._lost_s = lost_s
        self._heard_s: float | None = None
        self._watching = False

    def heard(self, sent_s: float) -> None:
        """Take in a heartbeat.

        Args:
            sent_s: When it was sent, on the machine's clock: one that was on its way for too long
                proves nothing.
        """
        self._heard_s = max(sent_s, self._heard_s or sent_s)
        self._watching = True

    def begin(self, now_s: float) -> None:
        """A motion begins from rest."""
        self._watching = self._heard_s is not None and now_s - self._heard_s <= self._lost_s

    def lost(self, now_s: float) -> bool:
        """Tell, once, that nothing was heard for too long."""
        if not self._watching or self._heard_s is None or now_s - self._heard_s <= self._lost_s:
            return False
        self._watching = False
        return True
