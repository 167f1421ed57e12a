"""A command that refuses an option that is given twice: only its last value would count."""

from __future__ import annotations

from collections import Counter
from typing import Any

from typer.core import TyperCommand

from mcdas_opt.errors import InputError


class OnceCommand(TyperCommand):
    """Raises `InputError` that names the option."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        given = self.make_parser(ctx).parse_args(list(args))[2]
        for parameter, count in Counter(given).items():
            if count > 1 and parameter.param_type_name == "option" and not getattr(parameter, "is_flag", False):
                raise InputError(parameter.opts[0], "", None, f"is given {count} times, and takes one value")
        return super().parse_args(ctx, args)
