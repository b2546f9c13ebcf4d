"""Signing in on the page: /signin in one's own chat gives a code that is good once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.sign_in.commands import SignInCommands
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.gateway.feature import Kernel

__all__ = ["SignInFeature", "setup"]


class SignInFeature(Feature):
    """Gives codes; whoever serves the page takes them."""


def setup(kernel: Kernel) -> SignInFeature:
    """Let people sign in on the page."""
    SignInCommands(kernel.access, kernel.shared.page_url.find).register(kernel.commands)
    kernel.erasure.join(records=kernel.access.page_sessions.end_all)
    kernel.erasure.join(records=kernel.access.passkeys.end_all)
    return SignInFeature()
