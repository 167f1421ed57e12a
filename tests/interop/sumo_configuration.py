"""Configurations of our own on the shipped networks of SUMO."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.interop.sumo.columns import main_column
from mcdas_opt.interop.sumo.connection import started
from mcdas_opt.interop.sumo.episode import EpisodeSettings, wait_for
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import Edge, read_route

sumo = pytest.importorskip("sumo")
NETS = models_folder() / "sumo"


def configuration(folder: Path, routes: str, net: str = "bends", end_s: float = 60.0) -> Path:
    """These routes on a shipped network."""
    (folder / "own.rou.xml").write_text(f"<routes>{routes}</routes>", "utf-8")
    text = (NETS / f"{net}.sumocfg").read_text("utf-8").replace(f'"{net}.net.xml"', f'"{NETS / net}.net.xml"')
    text = text.replace(f"{net}.rou.xml", "own.rou.xml").replace('<end value="600"/>', f'<end value="{end_s:g}"/><route-steps value="1"/>')
    (folder / "own.sumocfg").write_text(text, "utf-8")
    return folder / "own.sumocfg"


def network(folder: Path, nodes: Mapping[str, tuple[float, float]], edges: Sequence[str], routes: str, *options: str) -> Path:
    """A configuration on a network that netconvert makes of nodes and edges (elements of its XML)."""
    places = "".join(f'<node id="{name}" x="{x:.3f}" y="{y:.3f}"/>' for name, (x, y) in nodes.items())
    (folder / "own.nod.xml").write_text(f"<nodes>{places}</nodes>", "utf-8")
    (folder / "own.edg.xml").write_text(f"<edges>{''.join(edges)}</edges>", "utf-8")
    (folder / "own.rou.xml").write_text(f"<routes>{routes}</routes>", "utf-8")
    given = ["-n", "own.nod.xml", "-e", "own.edg.xml", "-o", "own.net.xml", *options]
    subprocess.run([Path(sumo.SUMO_HOME) / "bin" / "netconvert", *given], cwd=folder, check=True, capture_output=True)
    read = '<net-file value="own.net.xml"/><route-files value="own.rou.xml"/>'
    (folder / "own.sumocfg").write_text(f"<configuration><input>{read}</input><time><end value='120'/></time></configuration>", "utf-8")
    return folder / "own.sumocfg"


def ego(*edges: str, lane: int = 0) -> str:
    """A vehicle along these edges."""
    return f'<vehicle id="ego" depart="0" departLane="{lane}" departSpeed="10"><route edges="{" ".join(edges)}"/></vehicle>'


def edge(first: str, last: str, lanes: int = 1, inside: str = "", more: str = "speed='13.9'") -> str:
    """Between two nodes."""
    return f'<edge id="{first}-{last}" from="{first}" to="{last}" numLanes="{lanes}" {more}>{inside}</edge>'


def framed(config: Path) -> tuple[RoadFrame, tuple[Edge, ...]]:
    """The ego's route, and its frame."""
    with started(config, 1) as sumo:
        wait_for(sumo, EpisodeSettings(config=config, ego="ego"))
        edges = read_route(sumo, sumo.vehicle.getRoute("ego"), int(sumo.vehicle.getLaneID("ego").rpartition("_")[2]), "passenger")
        return RoadFrame(sumo.lane, edges, main_column(edges), 0.9), edges
