"""What stands in a benchmark's report, and in which order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import shorten
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.evaluation.reporting.document import Bar, Bars, Block, Card, Cards, Cell, Heading, Paragraph, Picture, Report, Table
from mcdas_opt.evaluation.row import LONGEST_REASON
from mcdas_opt.evaluation.summary import collided, kinds, lost, pairs, worst
from mcdas_opt.plotting.benchmark import draw_cycle_times, draw_families, draw_scatter
from mcdas_opt.plotting.style import png_bytes

Record = dict[str, Any]

_HEADLINE = (
    ("lost on A", "lost_on_A"),
    ("lost on A with room", "lost_on_A_with_room"),
    ("collisions on A", "collisions_on_A"),
    ("collisions on A or undecided", "collisions_on_A_or_undecided"),
    ("hit in front, on A", "front_hits_on_A"),
    ("hit from behind, on A", "rear_hits_on_A"),
    ("left the road, on A", "road_departures_on_A"),
    ("collisions, every scene", "collisions"),
    ("lost, every scene", "lost"),
    ("false interventions", "false_interventions"),
    ("time gap under 0.8 s, own doing", "short_headways"),
    ("beyond ISO 15622", "beyond_iso"),
    ("followers who brake hard", "followers_braked"),
    ("unverified plans", "unverified_plans"),
)
_WHOLE = ("lost_on_A", "lost_on_A_with_room", "lost", "unverified_plans")  # a drive that ended early makes these no smaller
_FEWEST = (
    "The fewest stand out among the lost drives and the unverified plans. Whatever else is counted is counted until the drive ended: "
    "who leaves the road early meets fewer others."
)
MOST_LISTED = 100  # lost scenes
MOST_DRAWN = 4  # planners in one chart of bars
_AFTER = (("ordinary again at the end", "ordinary_again"), ("plans by the fallback", "fallback_plans"))
_DISTRIBUTIONS = (
    ("least clearance [m]", "min_clearance_m"),
    ("least time to collision, front [s]", "min_ttc_front_s"),
    ("least time to collision, rear [s]", "min_ttc_rear_s"),
    ("largest lateral acceleration [m/s²]", "max_lateral_acceleration_mps2"),
    ("largest braking [m/s²]", "max_deceleration_mps2"),
    ("largest jerk along [m/s³]", "max_jerk_mps3"),
    ("settling error [m]", "settling_error_m"),
    ("least own time gap [s]", "least_headway_s"),
    ("time beyond ISO 15622 [s]", "outside_iso_s"),
    ("impact speed on U [m/s]", "impact_speed_on_U_mps"),
)
_MEANINGS = (
    "A scene is avoidable (A) if the oracle holds a drive, beginning no earlier than 0.2 s after the onset, that is safe whether the rear "
    "car brakes later or not, and that the judge passes. C: avoidable only by knowing what the rear car will do. U: nobody can avoid it, "
    "not even a car with more grip that changes lanes at once. ?: undecided. A dash: not asked, because the traffic reacts to the host.",
    "Rates are k of n with the interval of Clopper and Pearson at 95 %. Lost: a collision, a departure from the road, or a planner that "
    "raised, hung or took its process with it; such a failure counts as a collision too. Scripted, reacting and recorded traffic are "
    "never counted together.",
    "False interventions: of the scenes that need none, those in which the planner steered out (evaded, left its lane but by a lane change "
    "that is no evasion, or had over 2 m/s² of lateral acceleration beyond the road's bend) or braked harder than 3.5 m/s². Unverified "
    "plans: plans that left without the judge's pass. Settling error: distance from the new lane's centre when the sideways motion of a "
    "lane change ended.",
    "Time gap under 0.8 s: drives with more than 0.5 s of it, not counting 10 s after a cut-in. Beyond ISO 15622: of the scenes that need "
    "no intervention, those with more than 0.5 s of acceleration or braking (means over 2 s) or jerk (over 1 s) beyond the standard. "
    "Followers who brake hard: of the lane changes, those whose new follower braked by more than 4 m/s² from 2 s before to 3 s after, for "
    "whatever reason. "
    "Ordinary again: of the drives with an emergency, those that ended calm for 1 s, in the middle of a lane, as fast as desired speed, "
    "limit and leader let them (or gaining speed), with a time gap of 0.8 s (or an opening one); a drive that ends too early is a no.",
)


def report(
    manifest: Record,
    rows: Sequence[Record],
    cycles_ms: Sequence[Sequence[float]],
    summary: Mapping[str, Any],
    cards: Sequence[Card],
    about: Sequence[str] = (),
    pages: Mapping[int, str] | None = None,
) -> Report:
    """The whole report; `about` is what the suite says of itself, `pages` the files beside it that play the first planner's lost scenes."""
    planners = list(manifest["planners"])
    blocks: list[Block] = [block for kind in kinds(rows) for block in _lead(kind, planners, summary)]
    blocks += _lost_scenes(rows, planners, pages or {})
    for kind in kinds(rows):
        blocks += _traffic(kind, [row for row in rows if row["traffic"] == kind], planners, summary)
    blocks += _times(rows, cycles_ms, planners, summary)
    blocks += [Heading(text="Planners compared on the same scenes"), _pairs(pairs(rows, planners), planners)]
    if cards:
        blocks += [Heading(text=f"The {len(cards)} worst scenes of {planners[0]}"), Cards(cards=cards)]
    blocks += [Heading(text="How to read this"), *(Paragraph(text=text) for text in _MEANINGS)]
    if about:
        blocks += [Heading(text="The suite: sources, and what was chosen"), *(Paragraph(text=text) for text in about)]
    return Report(
        title=f"Mid-vehicle benchmark: {manifest['suite']}",
        subtitle=f"{manifest['scenes']} scenes, {len(planners)} planners, {manifest['plant']} plant, seed {manifest['seed']}",
        blocks=blocks,
        origin=_origin(manifest),
    )


def _traffic(kind: str, rows: Sequence[Record], planners: Sequence[str], summary: Mapping[str, Any]) -> list[Block]:
    found = {planner: summary[planner][kind] for planner in planners}
    first = found[planners[0]]
    labels = ", ".join(f"{count} {letter}" for letter, count in first["labels"].items() if count)
    shown = [(title, key) for title, key in _HEADLINE if any(figures[key]["n"] for figures in found.values())]
    blocks: list[Block] = [
        Heading(text=f"{kind.capitalize()} traffic"),
        Paragraph(text=f"{first['scenes']} scenes ({labels})."),
        _shares(shown, found),
        *([_after(found)] if any(figures["ordinary_again"]["n"] for figures in found.values()) else []),
        Heading(text="Distributions", level=3),
        _distributions(found),
    ]
    blocks += _families(found, planners, kind)
    points = {planner: points_of([row for row in rows if row["planner"] == planner]) for planner in planners}
    says = "Each drive: how near it came to anybody, against how hard it accelerated or braked; what lies beyond is drawn at the edge."
    blocks += [
        Heading(text="Clearance against comfort", level=3),
        Picture(name=f"scatter-{kind}.png", png=png_bytes(draw_scatter(points)), says=says),
    ]
    return blocks


def _lead(kind: str, planners: Sequence[str], summary: Mapping[str, Any]) -> list[Block]:
    """What counts most, first: of the avoidable scenes, how many were lost."""
    found = {planner: summary[planner][kind] for planner in planners}
    labelled = any(figures["lost_on_A"]["n"] for figures in found.values())
    shares = {planner: figures["lost_on_A" if labelled else "lost"] for planner, figures in found.items()}
    bars = [Bar(name=name, rate=q["rate"], low=q["low"], high=q["high"], says=_counted(q)) for name, q in shares.items() if q["n"]]
    what = "Lost, of the avoidable scenes (A)" if labelled else "Lost, of all scenes"
    shown = Bars(bars=bars, caption="With the 95 % interval of Clopper and Pearson.")
    return [Heading(text=f"{what}: {kind} traffic"), shown] if bars else []


def _counted(share: Record) -> str:
    return f"{share['k']} of {share['n']}, {100.0 * share['rate']:.1f} % [{100.0 * share['low']:.1f}, {100.0 * share['high']:.1f}]"


def _lost_scenes(rows: Sequence[Record], planners: Sequence[str], pages: Mapping[int, str]) -> list[Block]:
    """The avoidable scenes that the first planner lost, each with its page, and who else lost it."""
    first, *others = planners
    mine = [row for row in worst(rows, first, len(rows)) if lost(row) and row["label"] in "A-"]
    if not mine:
        return []
    losers: dict[int, list[str]] = {}
    for row in rows:
        if row["planner"] in others and lost(row):
            losers.setdefault(row["index"], []).append(row["planner"])
    shown = [
        [
            Cell(row["scene"], page=pages.get(row["index"], "")),
            Cell(row["family"]),
            Cell(fate(row)),
            *([Cell(", ".join(losers.get(row["index"], [])) or "nobody")] if others else []),
        ]
        for row in mine[:MOST_LISTED]
    ]
    more = f"and {len(mine) - MOST_LISTED} more, in rows.csv. " if len(mine) > MOST_LISTED else ""
    table = Table(
        columns=["scene", "family", "what happened", *(["also lost by"] if others else [])],
        rows=shown,
        caption=f"{more}Each name leads to a page that plays the drive.",
        is_text=True,
    )
    return [Heading(text=f"What {first} lost", level=3), table]


def _shares(shown: Sequence[tuple[str, str]], found: Mapping[str, Any]) -> Table:
    rows = []
    for title, key in shown:
        rates = {figures[key]["rate"] for figures in found.values()}
        is_compared = key in _WHOLE and len(rates) > 1
        best = min((rate for rate in rates if rate is not None), default=None) if is_compared else None
        rows.append([Cell(title), *(_share(figures[key], best) for figures in found.values())])
    return Table(columns=["share of drives", *found], rows=rows, caption=_FEWEST)


def _after(found: Mapping[str, Any]) -> Table:
    rows = [[Cell(title), *(_share(figures[key], None) for figures in found.values())] for title, key in _AFTER]
    return Table(columns=["after an emergency", *found], rows=rows, caption="After an emergency; the share of cycles.")


def _distributions(found: Mapping[str, Any]) -> Table:
    shown = [(title, key) for title, key in _DISTRIBUTIONS if any(figures[key]["n"] for figures in found.values())]
    rows = [[Cell(title), *(_spread(figures[key]) for figures in found.values())] for title, key in shown]
    return Table(columns=["over the drives", *found], rows=rows, caption="Median, and below it the 5 % and 95 % quantiles and n.")


def _families(found: Mapping[str, Any], planners: Sequence[str], kind: str) -> list[Block]:
    """Of few planners a picture; of many a table, which stays readable."""
    parts = found[planners[0]]["families"]
    measure = "lost_on_A" if any(part["lost_on_A"]["n"] for part in parts.values()) else "lost"
    says = {"lost_on_A": "lost, of the avoidable scenes [%]", "lost": "lost [%]"}[measure]
    shares = {
        family: {planner: found[planner]["families"][family][measure] for planner in planners}
        for family, part in parts.items()
        if part[measure]["n"]
    }
    if not shares:
        return []
    heading = Heading(text="By family", level=3)
    if len(planners) > MOST_DRAWN:
        rows = [[Cell(family), *(_share(share, 0.0) for share in of.values())] for family, of in shares.items()]
        return [heading, Table(columns=["family", *planners], rows=rows, caption=f"Share {says}; families without a loss stand out.")]
    bars = {family: {planner: _interval(share) for planner, share in of.items()} for family, of in shares.items()}
    png = png_bytes(draw_families(bars, planners, says))
    return [heading, Picture(name=f"families-{kind}.png", png=png, says=f"Share {says} by family and planner, with 95 % intervals.")]


def _times(
    rows: Sequence[Record], cycles_ms: Sequence[Sequence[float]], planners: Sequence[str], summary: Mapping[str, Any]
) -> list[Block]:
    found = [(planner, summary[planner]["cycle_ms"]) for planner in planners]
    names = ("p50", "p99", "p99.9", "max")
    table = Table(
        columns=["planner", "plans", *(f"{name} [ms]" for name in names), "plans per second", "drives per second"],
        rows=[
            _cells(p, str(f["n"]), *(_number(f[name], 2) for name in names), _number(f["plans_per_s"], 0), _number(f["drives_per_s"], 2))
            for p, f in found
        ],
        caption="Wall-clock time of the whole step (tracker, situation, planner, judge) on the machine that ran this, loaded as it was. "
        "Drives per second are one worker's, with plant, traffic and sensors.",
    )
    times = {
        planner: np.array([ms for row, cycles in zip(rows, cycles_ms, strict=True) if row["planner"] == planner for ms in cycles])
        for planner in planners
    }
    says = "Share of plans that took longer than so many milliseconds."
    return [Heading(text="Cycle time"), table, Picture(name="cycle-times.png", png=png_bytes(draw_cycle_times(times)), says=says)]


def _pairs(found: Sequence[Record], planners: Sequence[str]) -> Table:
    """Of many planners the first against each of the others."""
    is_cut = len(planners) > MOST_DRAWN
    rows = []
    for pair in found:
        if is_cut and planners[0] not in (pair["first"], pair["second"]):
            continue
        counts = (str(pair[key]) for key in ("n", "only_first", "only_second"))
        rows.append(_cells(f"{pair['first']} against {pair['second']}", pair["traffic"], pair["measure"], *counts, _p(pair["p"])))
    return Table(
        columns=["pair", "traffic", "measure", "scenes", "only the first lost", "only the second lost", "p"],
        rows=rows,
        caption="Exact McNemar test, two-sided; not corrected for the number of pairs."
        + (" The other pairs are in summary.json." if is_cut else ""),
    )


def _origin(manifest: Record) -> list[tuple[str, str]]:
    versions = ", ".join(f"{name} {version}" for name, version in manifest["versions"].items())
    return [
        ("suite hash", manifest["suite_hash"]),
        ("labels hash", manifest["labels_hash"]),
        ("rows hash", manifest["rows_hash"]),
        ("seed", str(manifest["seed"])),
        ("versions", versions),
        ("commit", manifest["commit"] or "none (not a checkout)"),
    ]


def points_of(rows: Sequence[Record]) -> Array:
    """(n, 3): least clearance [m], largest acceleration [m/s^2], and 1 where the drive was lost; of the drives that have both."""
    found = [
        (row["min_clearance_m"], max(row["max_lateral_acceleration_mps2"], row["max_deceleration_mps2"]), float(lost(row)))
        for row in rows
        if row["min_clearance_m"] is not None and row["max_deceleration_mps2"] is not None
    ]
    return np.array(found, dtype=np.float64).reshape(-1, 3)


def fate(row: Record) -> str:
    """How a drive ended, in words."""
    told: str = row["outcome"].replace("_", " ") or f"{row['ended']}: {row['error']}"
    if row["collided_with"]:
        other = row["collided_with"]
        told = f"hit from behind by {other}" if row["hit"] == "rear" else f"collision with {other} ({row['hit']})"
        return told + f" at {row['impact_speed_mps']:.1f} m/s, {row['duration_s']:.2f} s"
    if not collided(row) and row["min_clearance_m"] is not None:
        told += f", never nearer than {row['min_clearance_m']:.2f} m"
    return told


def card(row: Record, png: bytes, command: str, page: str = "") -> Card:
    """One of the worst scenes."""
    words = [
        f"label {row['label']}" if row["label"] != "-" else "",
        row["modes"],
        shorten(row["first_reason"], LONGEST_REASON, placeholder=" …"),
    ]
    title = f"{row['scene']}: {fate(row)}"
    picture = Picture(name=f"worst-{row['scene']}.png", png=png, says=title)
    return Card(title=title, facts="; ".join(word for word in words if word), picture=picture, command=command, page=page)


def _interval(share: Record) -> tuple[float, float, float, int]:
    return share["rate"] or 0.0, share["low"], share["high"], share["n"]


def _cells(*texts: str) -> list[Cell]:
    return [Cell(text) for text in texts]


def _share(share: Record, best: float | None) -> Cell:
    if not share["n"]:
        return Cell("-")
    interval = f"{share['k']}/{share['n']} [{100.0 * share['low']:.1f}, {100.0 * share['high']:.1f}]"
    return Cell(f"{100.0 * share['rate']:.1f} %", interval, best=share["rate"] == best)


def _spread(found: Record) -> Cell:
    if not found["n"]:
        return Cell("-")
    return Cell(f"{found['p50']:.2f}", f"{found['p5']:.2f} .. {found['p95']:.2f} (n {found['n']})")


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _p(value: float) -> str:
    return f"{value:.3f}" if value >= 1e-3 else f"{value:.0e}"
