"""Makes the SUMO configuration `town` that is shipped in models/sumo: lights, a crossing with a main road, a roundabout, turns to the left.

    pip install 'mcdas-opt[sumo]'
    python benchmarks/sumo_town.py --out models/sumo

Four junctions at the corners of a square of 250 m, two-way streets of one lane between them and out of the town. The ego drives in from the
west: straight on at the lights, left out of the minor road at the crossing, round the roundabout, and left across oncoming traffic twice.
"""

from __future__ import annotations

import argparse
import math
import subprocess
import tempfile
from pathlib import Path

_SIDE_M, _OUT_M, _RING_M = 250.0, 300.0, 18.0
_TOWN_MPS, _RING_MPS = 13.89, 8.33
_ROUTE = "west-a a-b b-c3 c3-c0 c0-c1 c1-c2 c2-d d-a a-south"
_TYPES = """\
  <vTypeDistribution id="townspeople">
    <vType id="calm" probability="0.5" length="4.6" width="1.8" accel="1.8" decel="4.5" tau="1.4" sigma="0.3"
           speedFactor="normc(0.9,0.07,0.75,1.0)" minGapLat="0.6"/>
    <vType id="brisk" probability="0.4" carFollowModel="IDM" length="4.4" width="1.8" accel="2.2" decel="4.0" tau="1.0"
           speedFactor="normc(1.0,0.06,0.9,1.15)" minGapLat="0.5"/>
    <vType id="van" probability="0.1" vClass="delivery" length="6.5" width="2.2" accel="1.5" decel="4.0" tau="1.4"/>
  </vTypeDistribution>
  <vType id="cyclist" vClass="bicycle" length="1.8" width="0.6" maxSpeed="5" minGapLat="0.3" latAlignment="right"/>
  <vType id="host" length="4.5" width="1.8" accel="2.6" decel="4.5" tau="1.2" sigma="0.2" speedFactor="1" speedDev="0"/>
"""


def network(out: Path) -> None:
    """town.net.xml, by netconvert: a at (0, 0) with lights, b east of it, d north of it, c0 to c3 around the fourth corner."""
    s = _SIDE_M
    nodes = {"a": (0.0, 0.0, "traffic_light"), "b": (s, 0.0, "priority"), "d": (0.0, s, "priority")}
    nodes |= {f"c{k}": (s + _RING_M * math.cos(k * math.pi / 2), s + _RING_M * math.sin(k * math.pi / 2), "priority") for k in range(4)}
    outside = {"west": ("a", -_OUT_M, 0.0), "south": ("a", 0.0, -_OUT_M), "below": ("b", s, -_OUT_M), "right": ("b", s + _OUT_M, 0.0)}
    outside |= {"east": ("c0", s + _OUT_M, s), "north": ("c1", s, s + _OUT_M), "up": ("d", 0.0, s + _OUT_M), "left": ("d", -_OUT_M, s)}
    nodes |= {name: (x, y, "priority") for name, (_, x, y) in outside.items()}
    streets = [("a", "b", 3), ("b", "c3", 9), ("c2", "d", 5), ("d", "a", 5)]
    streets += [(name, at, 9 if at == "b" and name == "below" else 3) for name, (at, _, _) in outside.items()]
    edges = [_edge(*ends, priority) for one, other, priority in streets for ends in ((one, other), (other, one))]
    for k in range(4):
        turns = (k * math.pi / 2 + i * math.pi / 16 for i in range(9))
        ring = " ".join(f"{s + _RING_M * math.cos(turn):.2f},{s + _RING_M * math.sin(turn):.2f}" for turn in turns)
        edges.append(_edge(f"c{k}", f"c{(k + 1) % 4}", 9, _RING_MPS, f' shape="{ring}"'))
    edges.append('<roundabout nodes="c0 c1 c2 c3" edges="c0-c1 c1-c2 c2-c3 c3-c0"/>')
    rows = [f'<node id="{name}" x="{x:.2f}" y="{y:.2f}" type="{kind}"/>' for name, (x, y, kind) in nodes.items()]
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "x.nod.xml").write_text("<nodes>\n" + "\n".join(rows) + "\n</nodes>\n", "utf-8")
        Path(folder, "x.edg.xml").write_text("<edges>\n" + "\n".join(edges) + "\n</edges>\n", "utf-8")
        given = ["netconvert", "-n", f"{folder}/x.nod.xml", "-e", f"{folder}/x.edg.xml", "-o", str(out / "town.net.xml")]
        subprocess.run([*given, "--no-turnarounds", "true", "--write-license", "false"], check=True, capture_output=True, text=True)
    text = (out / "town.net.xml").read_text("utf-8")
    begin, stop = text.index("<!-- generated"), text.index("-->") + len("-->")
    (out / "town.net.xml").write_text(text[:begin] + "<!-- made by benchmarks/sumo_town.py -->" + text[stop:], "utf-8")


def _edge(begin: str, end: str, priority: int, limit_mps: float = _TOWN_MPS, more: str = "") -> str:
    return f'<edge id="{begin}-{end}" from="{begin}" to="{end}" numLanes="1" speed="{limit_mps}" priority="{priority}"{more}/>'


def traffic(out: Path) -> None:
    """town.rou.xml and town.sumocfg: from every way into the town to every way out, and bicycles."""
    outside = ("west-a", "south-a", "below-b", "right-b", "east-c0", "north-c1", "up-d", "left-d")
    flows = []
    for begin in outside:
        for end in outside:
            if begin != end:
                into, at = end.split("-")
                ways = f'from="{begin}" to="{at}-{into}" departLane="free" departSpeed="avg"'
                flows.append(f'  <flow id="{begin}.{into}" type="townspeople" begin="0" end="600" {ways} probability="0.004"/>')
    for begin, end in (("west-a", "a-b"), ("up-d", "d-a"), ("north-c1", "c2-d")):
        flows.append(f'  <flow id="bicycle.{begin}" type="cyclist" begin="0" end="600" from="{begin}" to="{end}" probability="0.005"/>')
    ego = '  <vehicle id="ego" type="host" route="round" depart="60" departPos="30" departSpeed="avg"/>'
    routes = ["<routes>", _TYPES.rstrip(), f'  <route id="round" edges="{_ROUTE}"/>', *flows, ego, "</routes>"]
    (out / "town.rou.xml").write_text("\n".join(routes) + "\n", "utf-8")
    (out / "town.sumocfg").write_text((out / "bends.sumocfg").read_text("utf-8").replace("bends.", "town."), "utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("models/sumo"))
    out = parser.parse_args().out
    network(out)
    traffic(out)


if __name__ == "__main__":
    main()
