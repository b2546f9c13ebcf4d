"""Verifying people's devices: /verify, and comparing emoji with whoever looks after ROSIC."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosic.features.verification.commands import VerificationCommands
from rosic.features.verification.service import DeviceVerifications
from rosic.gateway.feature import Feature

if TYPE_CHECKING:
    from rosic.gateway.feature import Kernel

__all__ = ["VerificationFeature", "setup"]


class VerificationFeature(Feature):
    """Has emoji compared.

    Attributes:
        verifications: Those under way.
    """

    def __init__(self, verifications: DeviceVerifications) -> None:
        self.verifications = verifications


def setup(kernel: Kernel) -> VerificationFeature:
    """Ask people here wherever a messenger's devices can be verified."""
    verifications = DeviceVerifications(
        kernel.rooms, kernel.reach, kernel.changes, kernel.admins, kernel.machine_clock
    )
    for messenger in kernel.messengers:
        verifications.serve(messenger)
    VerificationCommands(verifications, kernel.rooms).register(kernel.commands)
    return VerificationFeature(verifications)
