"""The exported C solver against Python's on every shipped scene: how far apart they are, and how long a solve takes on either side.

    python benchmarks/c_export.py --steps 1000 --out c_export.jsonl

Three comparisons a scene: plain C (-O3 -Wall -Wextra) against Python's kernel built portably; C with Python's own flags against Python as
it flies; and plain C against Python as it flies, whose sines come from the vector library. In the first two both sides calculate
alike; the third says how many solves hang on the last digit of a sine.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

from mcdas_opt.catalogue.data_files import shipped
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.interop.c_export.export import FLAGS, run_replay
from mcdas_opt.interop.c_export.recording import Arithmetic, record
from mcdas_opt.interop.c_export.source import files, native_flags
from mcdas_opt.native.build import compiler
from mcdas_opt.solvers.outcome import Ending

COMPARED: tuple[tuple[Arithmetic, tuple[tuple[str, str], ...]], ...] = (
    ("portable", (("plain", FLAGS),)),
    ("native", (("vectors", native_flags()), ("plain", FLAGS))),
)


def rows(scene: str, steps: int, neighbours: int) -> list[dict[str, object]]:
    found: list[dict[str, object]] = []
    for arithmetic, builds in COMPARED:
        recording = record(load_scene(scene), steps, neighbours, arithmetic)
        took = sorted(recording.took_us)
        with tempfile.TemporaryDirectory() as name:
            for file, content in files(recording).items():
                (Path(name) / file).write_bytes(content)
            for build, flags in builds:
                said, warnings = run_replay(Path(name), compiler(), flags)
                found.append(
                    {
                        "scene": scene,
                        "solves": len(recording.steps),
                        "capped": sum(step.outcome.ending is Ending.LIMIT for step in recording.steps),
                        "python": recording.solver,
                        "c": build,
                        "max_error": said["max_error"],
                        "apart": said["apart"],
                        "mismatches": said["mismatches"],
                        "warnings": len(warnings.splitlines()),
                        "python_p50_us": float(took[len(took) // 2]),
                        "c_p50_us": said["timing_us"]["p50"],
                        "c_p99_us": said["timing_us"]["p99"],
                    }
                )
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=shipped("scenes"), help="default: every shipped one")
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--neighbours", type=int, default=4)
    parser.add_argument("--out", type=Path, default=None, help="rows as JSON lines")
    wanted = parser.parse_args()
    print(
        "scene                          python's kernel              C        solves  max error  > 1e-6  otherwise  python us  C us (p50)"
    )
    for scene in wanted.scenes:
        for row in rows(scene, wanted.steps, wanted.neighbours):
            print(
                f"{row['scene']:<30} {row['python']:<28} {row['c']:<8} {row['solves']:>6}  {row['max_error']:>9.1e}  {row['apart']:>6}  "
                f"{row['mismatches']:>9}  {row['python_p50_us']:>9.0f}  {row['c_p50_us']:>10.0f}",
                flush=True,
            )
            if wanted.out is not None:
                with wanted.out.open("a", encoding="utf-8") as file:
                    file.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main()
