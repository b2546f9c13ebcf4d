"""All faults that are planted."""

from __future__ import annotations

from tests.planted.faults import FAULTS
from tests.planted.faults_of_accounts import OF_ACCOUNTS
from tests.planted.faults_of_alerts import OF_ALERTS
from tests.planted.faults_of_among import OF_AMONG
from tests.planted.faults_of_assurance import OF_ASSURANCE
from tests.planted.faults_of_breaks import OF_BREAKS
from tests.planted.faults_of_busy import OF_BUSY
from tests.planted.faults_of_cancelling import OF_CANCELLING
from tests.planted.faults_of_cards import OF_CARDS
from tests.planted.faults_of_dispatch import OF_DISPATCH
from tests.planted.faults_of_fleet import OF_FLEET, OF_TASKS
from tests.planted.faults_of_groups import OF_GROUPS
from tests.planted.faults_of_hanging import OF_HANGING
from tests.planted.faults_of_interpreting import OF_INTERPRETING
from tests.planted.faults_of_keeping import OF_KEEPING
from tests.planted.faults_of_live import OF_LIVE
from tests.planted.faults_of_matrix import OF_MATRIX
from tests.planted.faults_of_orders import OF_ORDERS
from tests.planted.faults_of_programs import OF_PROGRAMS
from tests.planted.faults_of_reading import OF_READING
from tests.planted.faults_of_recording import OF_RECORDING
from tests.planted.faults_of_rosbridge import OF_ROSBRIDGE
from tests.planted.faults_of_scheduling import OF_SCHEDULING
from tests.planted.faults_of_telling import OF_TELLING
from tests.planted.faults_of_ways import OF_WAYS
from tests.planted.faults_of_webhooks import OF_WEBHOOKS
from tests.planted.faults_of_xmpp import OF_XMPP
from tests.planted.messenger_faults import MESSENGER_FAULTS

ALL = (
    *FAULTS,
    *OF_ORDERS,
    *OF_DISPATCH,
    *OF_CARDS,
    *OF_TELLING,
    *OF_ACCOUNTS,
    *OF_ALERTS,
    *OF_AMONG,
    *OF_FLEET,
    *OF_TASKS,
    *OF_KEEPING,
    *OF_ASSURANCE,
    *OF_BREAKS,
    *OF_LIVE,
    *OF_CANCELLING,
    *OF_BUSY,
    *OF_HANGING,
    *OF_READING,
    *OF_GROUPS,
    *OF_INTERPRETING,
    *OF_SCHEDULING,
    *OF_PROGRAMS,
    *OF_RECORDING,
    *OF_MATRIX,
    *OF_ROSBRIDGE,
    *OF_WAYS,
    *OF_WEBHOOKS,
    *OF_XMPP,
    *MESSENGER_FAULTS,
)
