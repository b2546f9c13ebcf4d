"""Every command there is: of the kernel, and of each feature that is installed with it."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from rosic import features
from rosic.core.language.command import Command, CommandTable
from rosic.gateway import builtin_commands


def command_table() -> CommandTable:
    """Return the commands of the kernel and of every feature, by what their modules declare.

    A feature declares its own in ``COMMANDS`` of its ``commands.py``; nothing else lists them.

    Raises:
        ValueError: Two of them share a word, or a place on a page or in a menu.
    """
    declared: list[Command] = [*builtin_commands.COMMANDS]
    for feature in sorted(module.name for module in iter_modules(features.__path__)):
        declared += import_module(f"{features.__name__}.{feature}.commands").COMMANDS
    return CommandTable(declared)
