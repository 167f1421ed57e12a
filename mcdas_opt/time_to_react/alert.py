"""What the driver is told, and when the car may act by itself: from the escape map, which is received as a record."""

from __future__ import annotations

from mcdas_opt.domain.escapes import Escapes
from mcdas_opt.domain.settings import WarningSettings
from mcdas_opt.domain.vocabulary import Alert

_NEXT = {Alert.NONE: Alert.WARN, Alert.WARN: Alert.ACT, Alert.ACT: Alert.ACT}


def alert(escapes: Escapes, settings: WarningSettings, before: Alert = Alert.NONE) -> Alert:
    """Warn when the last comfortable moment passes, act when the last possible one nears; `before` is the alert of the cycle before.

    Nothing where the constant-input prediction meets nobody and leaves no road within `within_s`. What the map asks for is given step by
    step: who has not been warned yet is warned first.
    """
    if escapes.keeping_on_s is None or escapes.keeping_on_s > settings.within_s:
        return Alert.NONE
    last, comfortable = escapes.last_moment_s, escapes.last_comfortable_s
    if last is None or last <= settings.act_lead_s:
        return _NEXT[before]
    return Alert.WARN if comfortable is None or comfortable <= settings.warn_lead_s else Alert.NONE
