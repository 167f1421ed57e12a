"""The commands, one a file: each reads, calls one public function and prints. Heavy packages load inside the command that needs them."""

from mcdas_opt.cli.ending import ended_by_interrupts

__all__ = ["main"]


def main() -> None:
    """Entry point of `mcdas-opt` and of `python -m mcdas_opt`."""
    with ended_by_interrupts():
        from mcdas_opt.cli.app import run

        run()
