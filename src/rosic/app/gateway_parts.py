"""What a gateway is made of once its rooms are set up, for what is added to it afterwards."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rosic.app.access import AccessFeature
    from rosic.app.alert_feature import AlertFeature
    from rosic.app.data_feature import DataFeature
    from rosic.app.features import FeatureSetup
    from rosic.app.policy import PolicyEnforcer, PolicyService
    from rosic.contracts.robot import Robot
    from rosic.core.robot.profile import Profile, RobotId
    from rosic.features.media.context import MediaContext
    from rosic.features.robot_to_robot.service import RobotMessaging
    from rosic.gateway import Pipeline
    from rosic.gateway.components import Components
    from rosic.gateway.delivery.translation import ChatLanguages
    from rosic.gateway.robot_registry import RobotRegistry
    from rosic.gateway.stop import StopLane


class RunningGateway:
    """The rooms, the way through them, and the features.

    Attributes:
        pipeline, registry, rooms, stop_lane, robots: Made when the gateway opens.
        profiles: Of every robot; what the rooms look into, so that it grows for all of them.
        authority, enforcer, access, features, data_feature: Likewise.
        languages, media_feature, alarms, among: Likewise.
    """

    pipeline: Pipeline
    registry: RobotRegistry
    rooms: Components
    stop_lane: StopLane
    robots: dict[RobotId, Robot]
    profiles: dict[RobotId, Profile]
    authority: PolicyService
    enforcer: PolicyEnforcer
    access: AccessFeature
    features: FeatureSetup
    data_feature: DataFeature
    media_feature: MediaContext
    languages: ChatLanguages
    alarms: AlertFeature
    among: RobotMessaging
