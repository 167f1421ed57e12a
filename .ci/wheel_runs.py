"""In an environment that holds the wheel and nothing of the source tree: the compiled form runs, plans, and drives; exits 1 else."""

import sys
from pathlib import Path

import mcdas_opt as mo
from mcdas_opt.native.build import LIBRARY


def main() -> str:
    """What is wrong; empty where all is well."""
    where = Path(mo.__file__).parent
    if (where.parent / "pyproject.toml").exists():
        return f"{where} is a source tree"
    plan = mo.plan(mo.load_situation("sandwich-60-40"))
    if plan.solver != "interior-point (compiled)" or not plan.verdict.passed:
        return f"{plan.solver}: {plan.verdict.reason}"
    drive = mo.simulate(mo.load_scene("cut-in"))
    if drive.unverified_plans:
        return f"{drive.unverified_plans} unverified plans"
    sys.stdout.write(f"{LIBRARY}: {plan.solver}, {drive.plans} plans\n")
    return ""


if __name__ == "__main__":
    sys.exit(main() or None)
