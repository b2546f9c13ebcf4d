"""The four rooms in one value, as the composition root made them."""

from __future__ import annotations

from collections.abc import Mapping

import msgspec

from rosic.authoriser.authoriser import Authoriser
from rosic.container.container import Containers
from rosic.core.language import Vocabulary, VocabularyHolder
from rosic.core.robot.profile import Profile, RobotId
from rosic.core.stop_registry import StopRegistry
from rosic.linker.linker import Linker
from rosic.organiser.organiser import Organiser


class Components(msgspec.Struct, frozen=True):
    """The paper's four components, and the snapshots they share.

    Attributes:
        vocabularies: Holds what can be said now.
        stops: Which robots are stopped; written by the linker alone.
    """

    authoriser: Authoriser
    organiser: Organiser
    container: Containers
    linker: Linker
    vocabularies: VocabularyHolder
    profiles: Mapping[RobotId, Profile]
    stops: StopRegistry

    @property
    def vocabulary(self) -> Vocabulary:
        """What can be said now; not to be kept, as it may be replaced."""
        return self.vocabularies.current
