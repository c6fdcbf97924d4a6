"""Help that lists commands by what they are for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import click

_LONGEST = 200


class TaskGroup(click.Group):
    """A group of commands whose help has a section for each task.

    Args:
        tasks: the commands' names by task, each command once.
        options: as for `click.Group`.
    """

    def __init__(self, *, tasks: Mapping[str, Sequence[str]], **options: Any) -> None:
        super().__init__(**options)
        self.tasks = tasks

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the sections."""
        for task, names in self.tasks.items():
            with formatter.section(task):
                formatter.write_dl([(name, self.commands[name].get_short_help_str(_LONGEST)) for name in names])
