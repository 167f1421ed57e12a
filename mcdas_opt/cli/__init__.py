"""The commands, one a file: each reads, calls one public function and prints. Heavy packages load inside the command that needs them."""

from mcdas_opt.cli.app import app, main

__all__ = ["app", "main"]
