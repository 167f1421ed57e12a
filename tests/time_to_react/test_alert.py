"""The alert: a record in, a word out."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.escapes import Escape, Escapes
from mcdas_opt.domain.settings import WarningSettings
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.errors import ParameterError
from mcdas_opt.time_to_react.alert import alert

RANK = {Alert.NONE: 0, Alert.WARN: 1, Alert.ACT: 2}
moments = st.one_of(st.none(), st.floats(0.0, 10.0))


@st.composite
def candidates(draw: st.DrawFn) -> Escape:
    last = draw(moments)
    easy = None if last is None else draw(st.one_of(st.none(), st.floats(0.0, last)))
    return Escape(open=last is not None, last_moment_s=last, last_comfortable_s=easy)


maps = st.builds(Escapes, brake=candidates(), accelerate=candidates(), left=candidates(), right=candidates(), keeping_on_s=moments)


@given(found=maps, before=st.sampled_from(Alert), act=st.floats(0.0, 2.0), warn=st.floats(0.0, 2.0), more=st.floats(0.0, 2.0))
def test_longer_leads_never_alert_less(found: Escapes, before: Alert, act: float, warn: float, more: float) -> None:
    early = alert(found, WarningSettings(act_lead_s=act + more, warn_lead_s=warn + more), before)
    assert RANK[early] >= RANK[alert(found, WarningSettings(act_lead_s=act, warn_lead_s=warn), before)]


@given(found=maps, before=st.sampled_from(Alert))
def test_nobody_is_acted_for_unwarned_and_nothing_is_said_without_need(found: Escapes, before: Alert) -> None:
    told = alert(found, WarningSettings(), before)
    assert RANK[told] <= RANK[before] + 1
    if found.keeping_on_s is None:
        assert told is Alert.NONE
    if told is Alert.ACT:
        assert found.last_moment_s is None or found.last_moment_s <= WarningSettings().act_lead_s


@given(found=maps)
def test_what_is_comfortable_in_time_is_not_warned_of(found: Escapes) -> None:
    if (found.last_comfortable_s or 0.0) > WarningSettings().act_lead_s:
        assert alert(found, WarningSettings()) is Alert.NONE


@pytest.mark.parametrize("wrong", [{"comfort_mps2": 0.0}, {"comfort_share": 2.0}, {"act_lead_s": -0.1}, {"warn_lead_s": float("nan")}])
def test_settings_that_mean_nothing_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match=next(iter(wrong))):
        WarningSettings(**wrong)
