"""Range rates that are wrong are not believed."""

from __future__ import annotations

from mcdas_opt.tracking.range_rates import RangeRates


def test_range_rates_that_are_not_believed_are_tried_again_after_a_minute() -> None:
    rates = RangeRates()
    assert rates.are_believed(0.0)
    rates.disbelieve(10.0)
    assert [rates.are_believed(t_s) for t_s in (9.0, 10.0, 69.0, 71.0)] == [True, False, False, True]
