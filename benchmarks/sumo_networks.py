"""Makes the SUMO configurations that are shipped in models/sumo: a motorway with a ramp and a lane drop, and a road of bends.

    pip install 'mcdas-opt[sumo]'
    python benchmarks/sumo_networks.py --out models/sumo

Roads are straight pieces, arcs and the clothoids between them; netconvert makes the network of them, without a time stamp, so that the
same program makes the same files. The traffic is written here by hand: calm and brisk cars by three car-following models, tailgaters,
lorries, and cars that brake abruptly for no reason that anybody can see.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

_POINT_M = 5.0
_CLOTHOID_M = 80.0
_LANE_M = 3.2
_TYPES = """\
  <vTypeDistribution id="motorists">
    <vType id="calm" probability="0.4" carFollowModel="Krauss" length="4.6" width="1.8" accel="1.8" decel="4.5" tau="1.4" sigma="0.3"
           speedFactor="normc(0.95,0.07,0.75,1.1)" minGapLat="0.6"/>
    <vType id="brisk" probability="0.25" carFollowModel="IDM" length="4.4" width="1.8" accel="2.2" decel="4.0" tau="1.0"
           speedFactor="normc(1.1,0.08,0.95,1.35)" lcAssertive="1.3" minGapLat="0.5"/>
    <vType id="steady" probability="0.2" carFollowModel="EIDM" length="4.9" width="1.9" accel="1.7" decel="4.0" tau="1.2"
           speedFactor="normc(1.0,0.07,0.8,1.2)" minGapLat="0.6"/>
    <vType id="tailgater" probability="0.15" carFollowModel="Krauss" length="4.8" width="1.9" accel="3.0" decel="6.0" tau="0.5" sigma="0.2"
           minGap="1.0" speedFactor="normc(1.2,0.07,1.05,1.4)" lcSpeedGain="3" lcAssertive="2" minGapLat="0.4"/>
  </vTypeDistribution>
  <vType id="lorry" vClass="truck" length="16.5" width="2.5" accel="0.8" decel="4.0" tau="1.5" maxSpeed="23.6" speedFactor="1" sigma="0.2"/>
  <vType id="abrupt" length="4.5" width="1.8" accel="2.0" decel="7.5" tau="1.2" sigma="0.3" speedFactor="normc(1.0,0.05,0.9,1.1)"/>
  <vType id="host" length="4.5" width="1.8" accel="2.6" decel="4.5" tau="1.2" sigma="0.2" speedFactor="1" speedDev="0"/>
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Piece:
    """An edge: so many lanes, as fast, so long, turning by so many degrees in the middle at that radius (0: straight)."""

    name: str
    lanes: int
    limit_mps: float
    length_m: float
    radius_m: float = 0.0  # positive to the left


MOTORWAY = (
    Piece(name="start", lanes=3, limit_mps=33.33, length_m=1200.0),
    Piece(name="merging", lanes=4, limit_mps=33.33, length_m=300.0),
    Piece(name="bend", lanes=3, limit_mps=33.33, length_m=1200.0, radius_m=900.0),
    Piece(name="narrow", lanes=2, limit_mps=27.78, length_m=1000.0, radius_m=-800.0),
    Piece(name="wide", lanes=3, limit_mps=33.33, length_m=1300.0),
)
BENDS = (
    Piece(name="first", lanes=2, limit_mps=27.78, length_m=600.0),
    Piece(name="left", lanes=2, limit_mps=25.0, length_m=500.0, radius_m=350.0),
    Piece(name="right", lanes=2, limit_mps=25.0, length_m=500.0, radius_m=-350.0),
    Piece(name="sharp", lanes=2, limit_mps=19.44, length_m=400.0, radius_m=180.0),
    Piece(name="back", lanes=2, limit_mps=19.44, length_m=400.0, radius_m=-180.0),
    Piece(name="last", lanes=2, limit_mps=27.78, length_m=800.0, radius_m=700.0),
)


def shapes(pieces: tuple[Piece, ...]) -> dict[str, np.ndarray]:
    """The left edge of each piece, a point every 5 m, (n, 2): curvature grows and falls along a clothoid at either end of a bend."""
    found, pose, widest = {}, np.zeros(3), pieces[0].lanes
    for piece in pieces:
        steps = round(piece.length_m / 0.5)
        s = (np.arange(steps) + 0.5) * 0.5
        kappa = np.zeros(steps)
        if piece.radius_m:
            ramp = np.clip(np.minimum(s, piece.length_m - s) / _CLOTHOID_M, 0.0, 1.0)
            kappa = ramp / piece.radius_m
        heading = pose[2] + np.concatenate([[0.0], np.cumsum(0.5 * kappa)])
        middle = 0.5 * (heading[1:] + heading[:-1])
        x = pose[0] + np.concatenate([[0.0], np.cumsum(0.5 * np.cos(middle))])
        y = pose[1] + np.concatenate([[0.0], np.cumsum(0.5 * np.sin(middle))])
        every = round(_POINT_M / 0.5) if piece.radius_m else steps
        rows = np.unique([*range(0, steps + 1, every), steps])
        right = _LANE_M * max(widest - piece.lanes, 0)  # a lane that is dropped is the left one
        found[piece.name] = np.column_stack([x + right * np.sin(heading), y - right * np.cos(heading)])[rows]
        pose = np.array([x[-1], y[-1], heading[-1]])
    return found


def network(name: str, pieces: tuple[Piece, ...], out: Path, ramp_to: str | None = None) -> None:
    """`name`.net.xml, by netconvert. A piece with fewer lanes than the one before loses its left lanes; a ramp adds one to the right."""
    lines, nodes, edges, connections = shapes(pieces), [], [], []
    for k, piece in enumerate(pieces):
        line = lines[piece.name]
        nodes.append(f'<node id="n{k}" x="{line[0, 0]:.3f}" y="{line[0, 1]:.3f}"/>')
        shape = " ".join(f"{x:.3f},{y:.3f}" for x, y in line)
        edges.append(_edge(piece.name, f"n{k}", f"n{k + 1}", piece.lanes, piece.limit_mps, shape))
    end = lines[pieces[-1].name][-1]
    nodes.append(f'<node id="n{len(pieces)}" x="{end[0]:.3f}" y="{end[1]:.3f}"/>')
    for before, after in pairwise(pieces):
        added = 1 if after.name == ramp_to else 0  # lanes are counted from the right
        dropped = 1 if before.name == ramp_to else 0
        for lane in range(dropped, before.lanes):
            to = lane - dropped + added
            if to < after.lanes:
                connections.append(f'<connection from="{before.name}" to="{after.name}" fromLane="{lane}" toLane="{to}"/>')
    if ramp_to is not None:
        meet, right = lines[ramp_to][0], 4 * _LANE_M
        k = next(k for k, piece in enumerate(pieces) if piece.name == ramp_to)
        points = [(meet[0] - 350.0, meet[1] - right - 60.0), (meet[0] - 150.0, meet[1] - right - 8.0), (meet[0], meet[1] - right + _LANE_M)]
        nodes.append(f'<node id="r" x="{points[0][0]:.3f}" y="{points[0][1]:.3f}"/>')
        edges.append(_edge("ramp", "r", f"n{k}", 1, 25.0, " ".join(f"{x:.3f},{y:.3f}" for x, y in points)))
        connections.append(f'<connection from="ramp" to="{ramp_to}" fromLane="0" toLane="0"/>')
    with tempfile.TemporaryDirectory() as folder:
        for kind, rows, root in (("nod", nodes, "nodes"), ("edg", edges, "edges"), ("con", connections, "connections")):
            Path(folder, f"x.{kind}.xml").write_text(f"<{root}>\n" + "\n".join(rows) + f"\n</{root}>\n", "utf-8")
        given = [f"{option}={folder}/x.{kind}.xml" for option, kind in (("-n", "nod"), ("-e", "edg"), ("-x", "con"))]
        command = ["netconvert", *(part for text in given for part in text.split("=")), "-o", str(out / f"{name}.net.xml")]
        subprocess.run([*command, "--no-turnarounds", "true", "--write-license", "false"], check=True, capture_output=True, text=True)
    text = (out / f"{name}.net.xml").read_text("utf-8")
    begin, stop = text.index("<!-- generated"), text.index("-->") + len("-->")
    (out / f"{name}.net.xml").write_text(text[:begin] + "<!-- made by benchmarks/sumo_networks.py -->" + text[stop:], "utf-8")


def _edge(name: str, begin: str, end: str, lanes: int, limit: float, shape: str) -> str:
    where = f'from="{begin}" to="{end}" numLanes="{lanes}" speed="{limit}" priority="{1 if name == "ramp" else 9}"'
    return f'<edge id="{name}" {where} spreadType="right" shape="{shape}"/>'


def traffic(name: str, pieces: tuple[Piece, ...], out: Path, flows: list[str], depart_s: float) -> None:
    """`name`.rou.xml and `name`.sumocfg."""
    edges = " ".join(piece.name for piece in pieces)
    routes = [
        "<routes>",
        _TYPES.rstrip(),
        f'  <route id="through" edges="{edges}"/>',
        *(f"  {flow}" for flow in flows),
        f'  <vehicle id="ego" type="host" route="through" depart="{depart_s:g}" departLane="1" departPos="60" departSpeed="avg"/>',
        "</routes>",
    ]
    (out / f"{name}.rou.xml").write_text("\n".join(routes) + "\n", "utf-8")
    (out / f"{name}.sumocfg").write_text(
        f"""<configuration>
  <input>
    <net-file value="{name}.net.xml"/>
    <route-files value="{name}.rou.xml"/>
  </input>
  <time>
    <end value="600"/>
    <step-length value="0.1"/>
  </time>
  <processing>
    <lateral-resolution value="0.8"/>
    <collision.action value="warn"/>
    <time-to-teleport value="-1"/>
  </processing>
  <report>
    <no-step-log value="true"/>
    <no-warnings value="true"/>
  </report>
</configuration>
""",
        "utf-8",
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("models/sumo"))
    out = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    network("motorway", MOTORWAY, out, ramp_to="merging")
    free = 'begin="0" end="600" departLane="free" departSpeed="avg" departPos="0"'
    fast = 'begin="0" end="600" departLane="free" departSpeed="desired" departPos="base"'
    traffic(
        "motorway",
        MOTORWAY,
        out,
        [
            f'<flow id="car" type="motorists" route="through" {fast} probability="0.65"/>',
            f'<flow id="lorry" type="lorry" route="through" {fast.replace("free", "0")} probability="0.08"/>',
            f'<flow id="abrupt" type="abrupt" route="through" {fast} probability="0.03">'
            '<stop lane="bend_1" startPos="500" endPos="520" speed="12"/></flow>',
            f'<flow id="hesitant" type="abrupt" route="through" {fast} probability="0.03">'
            '<stop lane="wide_0" startPos="600" endPos="620" speed="8"/></flow>',
            f'<flow id="merger" type="motorists" from="ramp" to="wide" {free} probability="0.1"/>',
        ],
        110.0,
    )
    network("bends", BENDS, out)
    traffic(
        "bends",
        BENDS,
        out,
        [
            f'<flow id="car" type="motorists" route="through" {fast} probability="0.3"/>',
            f'<flow id="lorry" type="lorry" route="through" {fast.replace("free", "0")} probability="0.03"/>',
            f'<flow id="abrupt" type="abrupt" route="through" {fast} probability="0.02">'
            '<stop lane="right_0" startPos="250" endPos="270" speed="7"/></flow>',
        ],
        80.0,
    )


if __name__ == "__main__":
    main()
