"""One seed of a SUMO configuration, driven from the ego's departure to its end."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from mcdas_opt.catalogue.data_files import models_folder, not_shipped, shipped
from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import positive
from mcdas_opt.errors import InputError, McdasError
from mcdas_opt.interop.sumo.connection import Connection, asking, started
from mcdas_opt.interop.sumo.driver import SumoDriver
from mcdas_opt.interop.sumo.record import SumoSummary
from mcdas_opt.simulation.ordinary import Snapshot

WAIT_S = 3600.0  # for an ego to depart in a configuration without an end


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeSettings:
    """What is driven; `look_m` and `desired_mps` as in `SumoDriver`. A drive ends at its first contact."""

    config: Path
    ego: str
    desired_mps: float | None = None
    look_m: tuple[float, float] = (150.0, 100.0)

    def __post_init__(self) -> None:
        require_types(self)
        for value in self.look_m:
            positive("look_m", value, "m")
        if self.desired_mps is not None:
            positive("desired_mps", self.desired_mps, "m/s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Episode:
    """What came of it; `error` says what broke it off, and the summary is of the drive so far."""

    seed: int
    driver: str
    summary: SumoSummary | None
    snapshots: tuple[Snapshot, ...] = ()
    error: str = ""


def sumo_config(name: str) -> Path:
    """The configuration behind a path or a shipped name. Raises `InputError` that lists the shipped ones."""
    if os.path.isfile(name):
        return Path(name)
    path = models_folder() / "sumo" / f"{name}.sumocfg"
    if os.path.isfile(path):
        return path
    raise not_shipped(name, "SUMO configuration", shipped("sumo", ".sumocfg"))


def drive(settings: EpisodeSettings, seed: int, method: str) -> Episode:
    """The whole episode. What goes wrong before the ego drives raises; what goes wrong then is the episode's `error`."""
    with started(settings.config, seed) as sumo:
        wait_for(sumo, settings)
        driver = SumoDriver(sumo, settings.ego, method, desired_mps=settings.desired_mps, look_m=settings.look_m)
        error, end = "", float(sumo.simulation.getEndTime())
        try:
            while driver.step() and not driver.contacts:
                if 0.0 < end <= driver.snapshots[-1].time_s:
                    break
        except McdasError as stopped:
            error = str(stopped)
        return Episode(seed=seed, driver=method, summary=driver.summary, snapshots=tuple(driver.snapshots), error=error)


def wait_for(sumo: Connection, settings: EpisodeSettings) -> None:
    """Steps until the ego is on the road. Raises `InputError` where the configuration ends without it."""
    with asking(f"{settings.ego} was waited for"):
        end = float(sumo.simulation.getEndTime())
        last = end if end > 0.0 else WAIT_S
        while settings.ego not in sumo.vehicle.getIDList():
            if sumo.simulation.getTime() >= last or sumo.simulation.getMinExpectedNumber() == 0:
                rule = f"never departs in this configuration, which was watched until {sumo.simulation.getTime():g} s"
                raise InputError(settings.config, "ego", settings.ego, rule)
            sumo.simulationStep()
