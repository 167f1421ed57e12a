"""Many seeds of a SUMO configuration, each driven by our planner and by whoever it is compared with; rows, table, pictures."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import InputError, McdasError
from mcdas_opt.evaluation import provenance
from mcdas_opt.evaluation.results_folder import JOURNAL, open_folder
from mcdas_opt.evaluation.running.executor import Executor
from mcdas_opt.evaluation.running.journal import Journal, write_whole
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.evaluation.statistics import LEVEL, Share
from mcdas_opt.evaluation.table import markdown_table
from mcdas_opt.interop.sumo.episode import Episode, EpisodeSettings, drive
from mcdas_opt.simulation.ordinary import HEADWAYS_S, NEAR_MISS_S

ROWS, PICTURES, TABLE = "rows.csv", "pictures", "table.md"
_LIMIT_S = 3600.0
_RESAMPLES = 2000
_FEWEST = 5  # episodes that an interval is made of
_SAME = 1e-9

Record = dict[str, Any]
Progress = Callable[[int, int], None]


class BrokenOffError(McdasError):
    """An episode that could not be driven to its end; what was driven so far is kept."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Ratio:
    """A sum over episodes by another sum, with the interval of a bootstrap over episodes (Efron, 1979, percentiles) at level 0.95; None
    where there are too few episodes for one, or all are the same."""

    value: float
    low: float | None
    high: float | None


def run(
    settings: EpisodeSettings,
    seeds: Sequence[int],
    drivers: Sequence[str],
    folder: Path,
    executor: Executor,
    *,
    resume: bool,
    progress: Progress,
) -> tuple[Record, ...]:
    """The rows, by seed and driver. Each is written as it comes; a picture of every contact and near miss stands beside them.

    Raises `InputError` for a folder of something else, and `BrokenOffError` where an episode breaks off, its row written.
    """
    open_folder(folder, _manifest(settings, seeds, drivers))
    with Journal(folder / JOURNAL) as journal:
        if journal.records and not resume:
            raise InputError(folder, "", None, "holds rows of this very run: add --resume to go on, or name another --out")
        there = {(row["seed"], row["driver"]) for row in journal.records}
        wanted = [(seed, driver) for seed in seeds for driver in drivers if (seed, driver) not in there]
        tasks = [Task(episode_row, (settings, seed, driver, folder / PICTURES), _LIMIT_S) for seed, driver in wanted]
        of = len(seeds) * len(drivers)
        progress(len(there), of)
        for done, (number, answer) in enumerate(executor.run(tasks), start=1 + len(there)):
            seed, driver = wanted[number]
            if answer.ended is not Ended.RETURNED:
                raise BrokenOffError(f"seed {seed}, {driver}: {answer.reason}; {len(journal.records)} rows are kept in {folder}")
            row: Record = answer.value
            if row["error"] and not row["snapshots"]:
                raise BrokenOffError(f"{row['error']} (seed {seed}, {driver})")
            if row["error"]:
                write_whole(folder / f"broken-{seed}-{driver}.json", json.dumps(row, allow_nan=False, indent=1) + "\n")
                kept = f"{len(journal.records)} rows and what was driven of this one are kept in {folder}"
                raise BrokenOffError(f"seed {seed}, {driver}: {row['error']}; {kept}")
            journal.append(row)
            progress(done, of)
        found = {(row["seed"], row["driver"]): row for row in journal.records}
    rows = tuple(found[seed, driver] for seed in seeds for driver in drivers)
    write_whole(folder / ROWS, as_csv(rows))
    return rows


def as_csv(rows: Sequence[Record]) -> str:
    """An episode a line, the figures of ordinary driving among the others; a list is JSON."""
    flat = [{**{name: value for name, value in row.items() if name != "ordinary"}, **row["ordinary"]} for row in rows]
    text = StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(name for row in flat for name in row)), restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: json.dumps(value) if isinstance(value, list) else value for name, value in row.items()} for row in flat)
    return text.getvalue()


def episode_row(settings: EpisodeSettings, seed: int, driver: str, pictures: Path) -> Record:
    """One episode as a row. Input that is bad from the start is an error in the row as well."""
    try:
        episode = drive(settings, seed, driver)
    except McdasError as error:
        episode = Episode(seed=seed, driver=driver, summary=None, error=str(error))
    return {
        "seed": seed,
        "driver": driver,
        "error": episode.error,
        "snapshots": len(episode.snapshots),
        **({} if episode.summary is None else to_document(episode.summary) | {"driver": driver}),
        "pictures": draw(episode, pictures),
    }


def draw(episode: Episode, folder: Path) -> list[str]:
    """A picture of each contact, and of each near miss; their names."""
    if episode.summary is None:
        return []
    events = [(one.time_s, f"contact with {one.other}: {one.why}", one.other) for one in episode.summary.contacts]
    for miss in episode.summary.ordinary.near_misses:
        made = "it had come in between" if miss.made_by_others else "nobody came in between"
        text = f"{miss.time_to_collision_s:.2f} s to a collision with {miss.other}; {made}"
        if not any(abs(time - miss.time_s) < 1.0 for time, _, _ in events):
            events.append((miss.time_s, text, miss.other))
    if not events:
        return []
    from mcdas_opt.plotting.style import save_png
    from mcdas_opt.plotting.traffic_moments import draw_moments

    folder.mkdir(parents=True, exist_ok=True)
    names = []
    for time, text, other in sorted(events):
        names.append(f"{episode.driver}-{episode.seed}-{time:.1f}s.png")
        title = f"{episode.driver}, seed {episode.seed}, {time:.1f} s: {text}"
        save_png(draw_moments(episode.snapshots, time, other, title), folder / names[-1], dpi=80)
    return names


def summarise(rows: Sequence[Record], drivers: Sequence[str]) -> Record:
    """By driver: counts with Clopper-Pearson intervals, ratios of sums with intervals over episodes; and speed against the last driver.

    A figure that nothing was driven for is None; so is the speed against somebody who never moved.
    """
    by_driver = {driver: [row for row in rows if row["driver"] == driver] for driver in drivers}
    found = {driver: _figures(mine) for driver, mine in by_driver.items()}
    reference = by_driver[drivers[-1]]
    for driver in drivers[:-1]:
        own = {row["seed"]: row["ordinary"] for row in by_driver[driver]}
        pairs = [(own[row["seed"]], row["ordinary"]) for row in reference if row["seed"] in own]
        driven = [(ours, theirs) for ours, theirs in pairs if min(ours["duration_s"], theirs["duration_s"]) > 0.0]
        speeds = np.array([[one[key] for one in pair for key in ("distance_m", "duration_s")] for pair in driven]).reshape(-1, 4)
        ratio = _bootstrap(speeds, _over) if speeds[:, 2].any() else None
        found[driver][f"speed_over_{drivers[-1]}"] = None if ratio is None else to_document(ratio)
    return found


def _figures(rows: Sequence[Record]) -> Record:
    drives = [row["ordinary"] for row in rows]
    time = np.array([one["duration_s"] for one in drives])
    following = np.array([one["following_s"] for one in drives])
    closing = [one["least_time_to_collision_s"] for one in drives if one["least_time_to_collision_s"] is not None]
    headways = [one["least_headway_s"] for one in drives if one["least_headway_s"] is not None]

    def of(part: Sequence[float], whole: Array) -> Record | None:
        table = np.column_stack([np.asarray(part, dtype=np.float64), whole])
        return to_document(_bootstrap(table, lambda sums: sums[..., 0] / np.maximum(sums[..., 1], 1e-9))) if whole.sum() > 0.0 else None

    def counted(test: Callable[[Record], bool]) -> Record:
        return Share(k=sum(map(test, rows)), n=len(rows)).to_dict()

    return {
        "episodes": len(rows),
        "distance_km": 1e-3 * sum(one["distance_m"] for one in drives),
        "hours": float(time.sum()) / 3600.0,
        "mean_speed_mps": of([one["distance_m"] for one in drives], time),
        "collisions_by_host": counted(lambda row: any(one["cause"] == "host" for one in row["contacts"])),
        "collisions_by_others": counted(lambda row: any(one["cause"] == "other" for one in row["contacts"])),
        "vanished": counted(lambda row: row["ended"] == "vanished"),
        **{
            f"own_headway_under_{limit:g}_s": of([one["short_headway_s"][k] for one in drives], following)
            for k, limit in enumerate(HEADWAYS_S)
        },
        f"any_headway_under_{HEADWAYS_S[-1]:g}_s": of([one["short_headway_any_s"] for one in drives], following),
        "least_own_headway_s": min(headways, default=None),
        "least_time_to_collision_s": min(closing, default=None),
        "near_misses": counted(lambda row: bool(row["ordinary"]["near_misses"])),
        "followers_braked": Share(k=sum(one["followers_braked"] for one in drives), n=sum(one["lane_changes"] for one in drives)).to_dict(),
        "outside_iso": of([one["outside_iso_s"] for one in drives], time),
        "fallback_plans": Share(
            k=sum(row["fallbacks"] + row["unavoidable"] for row in rows), n=sum(row["plans"] for row in rows)
        ).to_dict(),
        "unverified_plans": sum(row["unverified_plans"] for row in rows),
    }


def _over(sums: Array) -> Array:
    """Distance by duration, by distance by duration; not a number where the other stood."""
    ours, theirs = sums[..., 0] * sums[..., 3], sums[..., 1] * sums[..., 2]
    return np.asarray(np.divide(ours, theirs, out=np.full_like(ours, np.nan), where=theirs > 0.0))


def _bootstrap(parts: Array, figure: Callable[[Array], Array]) -> Ratio:
    """`figure` of the column sums of (episodes, columns), and its percentiles over resampled episodes that it is a number for."""
    rng = np.random.default_rng(1)
    chosen = rng.integers(0, len(parts), (_RESAMPLES, len(parts)))
    spread = figure(parts[chosen].sum(axis=1))
    low, high = (float(end) for end in np.nanquantile(spread, [0.5 * (1.0 - LEVEL), 0.5 * (1.0 + LEVEL)]))
    value = float(figure(parts.sum(axis=0)))
    if len(parts) < _FEWEST or high - low <= _SAME * max(abs(value), 1.0):
        return Ratio(value=value, low=None, high=None)
    return Ratio(value=value, low=low, high=high)


def lines(summary: Record) -> list[tuple[str, list[str]]]:
    """The table: a title, and a cell for each driver."""
    drivers = list(summary)

    def each(title: str, tell: Callable[[Record], str]) -> tuple[str, list[str]]:
        return title, [tell(summary[driver]) for driver in drivers]

    def percent(key: str) -> Callable[[Record], str]:
        return lambda one: "-" if one[key] is None else _in_percent(one[key])

    def count(key: str) -> Callable[[Record], str]:
        return lambda one: (
            f"{one[key]['k']} of {one[key]['n']} [{100 * one[key]['low']:.1f}, {100 * one[key]['high']:.1f} %]" if one[key]["n"] else "-"
        )

    def least(key: str) -> Callable[[Record], str]:
        return lambda one: "-" if one[key] is None else f"{one[key]:.2f} s"

    speeds = next((key for one in summary.values() for key in one if key.startswith("speed_over_")), None)
    table = [
        each("driven", lambda one: f"{one['episodes']} episodes, {one['distance_km']:.1f} km, {one['hours']:.2f} h"),
        each("collisions caused by the host", count("collisions_by_host")),
        each("collisions caused by others", count("collisions_by_others")),
        *(each(f"time gap under {limit:g} s, own doing, of following", percent(f"own_headway_under_{limit:g}_s")) for limit in HEADWAYS_S),
        each(f"time gap under {HEADWAYS_S[-1]:g} s, whoever made it", percent(f"any_headway_under_{HEADWAYS_S[-1]:g}_s")),
        each("least own time gap", least("least_own_headway_s")),
        each("least time to collision ahead", least("least_time_to_collision_s")),
        each(f"episodes with one under {NEAR_MISS_S:g} s", count("near_misses")),
        each("followers who brake > 4 m/s^2, of lane changes", count("followers_braked")),
        each("time beyond ISO 15622", percent("outside_iso")),
        each("mean speed", lambda one: "-" if one["mean_speed_mps"] is None else f"{one['mean_speed_mps']['value']:.2f} m/s"),
        each("plans by the fallback", count("fallback_plans")),
        each("unverified plans", lambda one: str(one["unverified_plans"]) if one["fallback_plans"]["n"] else "-"),
    ]
    if speeds is not None:
        name = speeds.removeprefix("speed_over_")
        table.append(each(f"mean speed over {name}'s, same seeds", lambda one: percent(speeds)(one) if speeds in one else "-"))
    return table


def _in_percent(ratio: Record) -> str:
    value, low, high = (None if ratio[key] is None else 100.0 * ratio[key] for key in ("value", "low", "high"))
    return f"{value:.2f} % [too few]" if low is None else f"{value:.2f} [{low:.2f}, {high:.2f}] %"


def markdown(title: str, summary: Record) -> str:
    """The table as a page."""
    said = "Intervals: 95 %; Clopper-Pearson for counts, a bootstrap over episodes for shares (too few: fewer than five, or all the same)."
    return f"# {title}\n\n{markdown_table(['', *summary], lines(summary))}\n{said}\n"


def _manifest(settings: EpisodeSettings, seeds: Sequence[int], drivers: Sequence[str]) -> Record:
    return {
        "schema_version": 1,
        "config": str(settings.config.resolve()),
        "ego": settings.ego,
        "desired_mps": settings.desired_mps,
        "look_m": list(settings.look_m),
        "seeds": list(seeds),
        "drivers": list(drivers),
        "versions": provenance.versions(),
        "commit": provenance.commit(),
    }
