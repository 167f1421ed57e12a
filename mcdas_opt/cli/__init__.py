"""The commands, one a file: each reads, calls one public function and prints. Heavy packages load inside the command that needs them."""

import sys

try:
    from mcdas_opt.cli.app import app, main
except KeyboardInterrupt:  # Ctrl-C while the commands themselves were being loaded
    sys.stderr.write("mcdas-opt: interrupted; what was not yet written is lost\n")
    sys.exit(130)

__all__ = ["app", "main"]
