"""The total selector: exactly one mode for every state, hysteresis, and agreement with Table 1 where that has a row."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mcdas_opt.domain.settings import SelectorSettings
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.situation.rule_table import RULES, Conditions
from mcdas_opt.situation.selector import MODES, SIDES, Facts, Selection, mode_code, select, select_one, side_code
from mcdas_opt.situation.table1 import literal_rows

SETTINGS = SelectorSettings()
HOLD, CRUISE, BRAKE, ACCELERATE, EVADE, PARK = (
    mode_code(m) for m in (Mode.HOLD, Mode.CRUISE, Mode.BRAKE, Mode.ACCELERATE, Mode.EVADE, Mode.PARK)
)


def random_facts(n: int, seed: int) -> Facts:
    """States over everything that may happen, the previous cycle included."""
    r = np.random.default_rng(seed)

    def gap() -> np.ndarray:
        return np.where(r.random(n) < 0.3, np.inf, r.uniform(-2, 120, n))

    def flag(p: float = 0.5) -> np.ndarray:
        return r.random(n) < p

    v = np.where(flag(0.1), 0.0, r.uniform(0, 40, n))
    mode = r.integers(-1, 6, n)
    return Facts(
        host_speed=v,
        desired_speed=np.where(flag(0.3), v, r.uniform(0, 40, n)),
        front_seen=flag(0.85),
        front_gap=gap(),
        front_speed=r.uniform(0, 40, n),
        rear_seen=flag(0.85),
        rear_gap=gap(),
        rear_speed=r.uniform(0, 40, n),
        left_open=flag(),
        right_open=flag(),
        preferred_side=r.integers(-1, 2, n),
        park_requested=flag(0.3),
        acceleration_mps2=r.uniform(1, 5, n),
        previous_mode=mode,
        previous_side=np.where(mode == EVADE, r.integers(1, 3, n), 0),
        previous_front_threat=flag(0.3),
        previous_rear_threat=flag(0.3),
        previous_warning=flag(),
        previous_age_s=r.uniform(0, 1, n),
    )


def rows_of(facts: Facts, index: int) -> Facts:
    return Facts(**{f.name: np.broadcast_to(getattr(facts, f.name), (100_000,))[index] for f in dataclasses.fields(facts)})


FACTS = random_facts(100_000, seed=1)
CHOSEN = select(FACTS, SETTINGS)


def test_exactly_one_row_of_the_table_applies_to_each_of_all_conditions() -> None:
    bits = np.array(np.meshgrid(*[[False, True]] * len(Conditions._fields), indexing="ij")).reshape(len(Conditions._fields), -1)
    conditions = Conditions(*bits)
    hits = np.sum([rule.applies(conditions) for rule in RULES], axis=0)
    assert bits.shape[1] == 2 ** len(Conditions._fields)
    np.testing.assert_array_equal(hits, 1)


def test_a_hundred_thousand_random_states_have_exactly_one_mode_each() -> None:
    assert np.isin(CHOSEN.mode, range(len(MODES))).all()
    assert np.isin(CHOSEN.side, range(len(SIDES))).all()
    assert all((CHOSEN.mode == code).any() for code in range(len(MODES)))
    np.testing.assert_array_equal(CHOSEN.side != side_code(Side.NONE), CHOSEN.mode == EVADE)


def test_one_state_alone_gets_the_mode_it_has_among_many() -> None:
    for index in range(0, 100_000, 997):
        alone = select(rows_of(FACTS, index), SETTINGS)
        assert [int(v[0]) for v in alone] == [int(v[index]) for v in CHOSEN]
        one = Facts(**{f.name: getattr(FACTS, f.name)[index].item() for f in dataclasses.fields(Facts)})
        assert [int(v) for v in select_one(one, SETTINGS)] == [int(v[index]) for v in CHOSEN]


def test_parking_only_on_request_at_standstill_and_unthreatened() -> None:
    parking = CHOSEN.mode == PARK
    assert np.all(FACTS.park_requested[parking] & (FACTS.host_speed[parking] <= SETTINGS.standstill_mps))
    assert not np.any(parking & (CHOSEN.front_threat | CHOSEN.rear_threat))


def test_evading_only_to_an_open_side_and_in_motion() -> None:
    left, right = (CHOSEN.side == side_code(s) for s in (Side.LEFT, Side.RIGHT))
    assert FACTS.left_open[left].all()
    assert FACTS.right_open[right].all()
    slowest = SETTINGS.evading_speed_mps * np.where(FACTS.previous_mode == EVADE, SETTINGS.ttc_threat_s / SETTINGS.ttc_clear_s, 1.0)
    assert (FACTS.host_speed >= slowest)[left | right].all()


def test_no_acceleration_into_an_unseen_front() -> None:
    accelerating = (CHOSEN.mode == ACCELERATE) | ((CHOSEN.mode == CRUISE) & (FACTS.desired_speed > FACTS.host_speed))
    assert FACTS.front_seen[accelerating].all()


def test_losing_every_sensor_and_track_is_a_safe_hold() -> None:
    for speed in (0.0, 5.0, 30.0):
        for parking in (False, True):
            blind = select(Facts(host_speed=speed, desired_speed=33.0, front_seen=False, rear_seen=False, park_requested=parking), SETTINGS)
            assert MODES[int(blind.mode[0])] is (Mode.PARK if parking and speed == 0.0 else Mode.HOLD)


def test_a_threat_is_warned_of() -> None:
    assert CHOSEN.warning[CHOSEN.front_threat | CHOSEN.rear_threat].all()


def test_mirrored_states_have_mirrored_modes() -> None:
    """Left and right swapped, the tie-break too."""
    swap = np.array([0, 2, 1])
    mirrored = dataclasses.replace(
        FACTS,
        left_open=FACTS.right_open,
        right_open=FACTS.left_open,
        preferred_side=-FACTS.preferred_side,
        previous_side=swap[FACTS.previous_side],
    )
    other = select(mirrored, dataclasses.replace(SETTINGS, tie_break=Side.RIGHT))
    np.testing.assert_array_equal(other.mode, CHOSEN.mode)
    np.testing.assert_array_equal(other.side, swap[CHOSEN.side])


def with_memory(facts: Facts, chosen: Selection, age: float) -> Facts:
    return dataclasses.replace(
        facts,
        previous_mode=chosen.mode,
        previous_side=chosen.side,
        previous_front_threat=chosen.front_threat,
        previous_rear_threat=chosen.rear_threat,
        previous_warning=chosen.warning,
        previous_age_s=age,
    )


def test_the_same_state_again_keeps_its_mode() -> None:
    """A fixed state settles: the third cycle answers as the second did."""
    second = select(with_memory(FACTS, CHOSEN, np.inf), SETTINGS)
    third = select(with_memory(FACTS, second, np.inf), SETTINGS)
    for a, b in zip(second[:5], third[:5], strict=True):
        np.testing.assert_array_equal(a, b)


NOISY = {
    "time to collision": {"rear_gap": 60.0, "rear_speed": 15.0 + 60.0 / SETTINGS.ttc_threat_s},
    "distance": {"rear_gap": SETTINGS.distance_rear_m, "rear_speed": 15.0 + SETTINGS.distance_rear_m / 6.6},
    "demand": {"rear_gap": 100.0, "rear_speed": 15.0 + (2 * SETTINGS.demand_threat_mps2 * 100.0) ** 0.5},
    "closing": {"rear_gap": 2.0, "rear_speed": 15.0 + SETTINGS.closing_mps},
    "brake or evade": {"front_gap": 20.0, "front_speed": 15.0 - (2 * SETTINGS.braking_enough_mps2 * 20.0) ** 0.5},
    "followed or not": {"front_gap": 20.0, "front_speed": 3.0, "rear_gap": SETTINGS.distance_rear_m, "rear_speed": 15.0},
    "accelerate or evade": {"rear_gap": 18.0, "rear_speed": 24.45},
    "front clear or not": {"rear_gap": 20.0, "rear_speed": 20.0, "front_gap": SETTINGS.distance_front_long_m, "front_speed": 15.0},
    "room or none": {
        "rear_gap": 12.0,
        "rear_speed": 20.0,
        "front_gap": SETTINGS.accelerating_room_m,
        "front_speed": 15.0,
        "left_open": False,
    },
    "desired speed": {"desired_speed": 15.0 + SETTINGS.speed_band_mps},
}


@pytest.mark.parametrize("what", NOISY)
def test_modes_do_not_chatter_when_a_measurement_oscillates_around_a_threshold(what: str) -> None:
    """400 cycles, gaps and relative speeds 5 % noisy: without memory the mode flips on and on, with it once at most."""
    mean = {"host_speed": 15.0, "desired_speed": 15.0, "front_speed": 15.0, "left_open": True, **NOISY[what]}
    noise = np.random.default_rng(3).uniform(0.95, 1.05, (400, 2))
    chosen, since, modes, bare = None, 0.0, [], []
    for cycle, (n_gap, n_speed) in enumerate(noise):
        now = 0.1 * cycle
        noisy = {
            name: value * n_gap if "gap" in name else 15.0 + (value - 15.0) * n_speed if "speed" in name else value
            for name, value in mean.items()
        }
        facts = Facts(**noisy)
        bare.append(int(select(facts, SETTINGS).mode[0]))
        if chosen is not None:
            facts = with_memory(facts, chosen, now - since)
        chosen = select(facts, SETTINGS)
        if not modes or modes[-1] != int(chosen.mode[0]):
            since = now
        modes.append(int(chosen.mode[0]))
    assert np.count_nonzero(np.diff(bare)) > 40  # the threshold is really crossed
    assert np.count_nonzero(np.diff(modes)) <= 1


def test_a_mode_lives_its_time_unless_the_threat_is_new_or_worse() -> None:
    calm = Facts(host_speed=15.0, desired_speed=15.0)
    braking = dataclasses.replace(calm, previous_mode=BRAKE, previous_front_threat=True)
    assert select(dataclasses.replace(braking, previous_age_s=0.2), SETTINGS).mode[0] == BRAKE
    assert select(dataclasses.replace(braking, previous_age_s=0.6), SETTINGS).mode[0] == HOLD
    new = dataclasses.replace(calm, previous_mode=HOLD, previous_age_s=0.1, rear_gap=10.0, rear_speed=25.0, left_open=True)
    assert select(new, SETTINGS).mode[0] == EVADE


def test_a_hard_front_threat_is_evaded_and_a_soft_one_braked_for() -> None:
    def mode(closing: float, gap: float, **facts: object) -> Mode:
        chosen = select(Facts(host_speed=30.0, desired_speed=30.0, front_speed=30.0 - closing, front_gap=gap, **facts), SETTINGS)
        return MODES[int(chosen.mode[0])]

    assert mode(5.0, 15.0, left_open=True) is Mode.BRAKE
    assert mode(20.0, 15.0, left_open=True) is Mode.EVADE
    assert mode(20.0, 15.0) is Mode.BRAKE
    assert mode(12.0, 18.0, left_open=True) is Mode.BRAKE  # 4 m/s^2, and nobody behind
    assert mode(12.0, 18.0, left_open=True, rear_gap=10.0, rear_speed=30.0) is Mode.EVADE
    assert mode(12.0, 18.0, left_open=True, rear_seen=False) is Mode.EVADE


def test_total_selector_answers_as_table_1_does_where_that_has_a_row() -> None:
    """Rows 1-4 at times to collision where the distances alone decide; row 5, all unknown, is the row that is not followed."""
    r = np.random.default_rng(7)
    n = 200_000
    host = r.uniform(10, 40, n)
    present = r.random(n) < 0.5
    d_f, d_r = r.uniform(0, 100, n), r.uniform(0.5, 100, n)
    v_f, v_r = host - r.uniform(0, 0.4, n), host + r.uniform(0, 12, n)
    d_f[:1000], d_r[:1000], v_f[:1000], v_r[:1000], present[:1000] = 35.0, 25.0, host[:1000], host[:1000], True
    row = literal_rows(present, d_f, v_f, True, d_r, v_r, host)
    facts = Facts(
        host_speed=host,
        desired_speed=host,
        front_gap=np.where(present, d_f, np.inf),
        front_speed=v_f,
        rear_gap=d_r,
        rear_speed=v_r,
        left_open=True,
        acceleration_mps2=3.0,
    )
    chosen = select(facts, SETTINGS)
    closing = np.maximum(v_r - host, 1e-9)
    time, demand = d_r / closing, closing**2 / (2 * d_r)
    far = (time > SETTINGS.ttc_threat_s) & (demand < SETTINGS.demand_threat_mps2)
    soon = (closing > SETTINGS.closing_mps) & (time < SETTINGS.ttc_warning_s)
    enough = closing**2 / 6.0 + 0.15 * closing <= d_r - SETTINGS.occupancy_gap_m
    for number, agrees, mode in ((1, far, HOLD), (2, soon & enough, ACCELERATE), (3, True, HOLD), (4, soon, EVADE)):
        where = (row == number) & agrees
        assert where.sum() > 400
        assert (chosen.mode[where] == mode).all()
    assert chosen.warning[row == 3].all()
    assert (chosen.mode[(row == 2) & soon & ~enough] == EVADE).all()
