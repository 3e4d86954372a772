"""Exceptions of powergs. Texts of the simulator name the file, the place and the remedy."""

from __future__ import annotations

from typing import Any


class PowergsError(Exception):
    """Whatever powergs raises itself."""


class ConfigError(PowergsError, ValueError):
    """An invalid configuration, an unknown name, or a request that cannot be met."""

    #: The file, where it is about one.
    file: str | None
    #: Its first faulty line, from 1.
    line: int | None
    #: What was probably meant.
    suggestion: str | None

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        suggestion: str | None = None,
    ) -> None:
        super().__init__(message, file, line, suggestion)
        self.file, self.line, self.suggestion = file, line, suggestion

    def __str__(self) -> str:
        return str(self.args[0])


class InvalidDesign(ConfigError):
    """A point of a space that is no machine: a search goes on without it."""


class InputError(PowergsError, ValueError):
    """A file or an array that cannot be used."""

    #: The file, where it is about one.
    file: str | None

    def __init__(self, message: str, file: str | None = None) -> None:
        super().__init__(message, file)
        self.file = file

    def __str__(self) -> str:
        return str(self.args[0])


class MissingFileError(InputError, FileNotFoundError):
    """A file that is not there."""


class GoalMissed(PowergsError):
    """It ran, and the goal was not met."""

    #: What a command of ``powergs.commands`` found all the same: its ``Outcome``.
    outcome: Any = None


class InternalError(PowergsError, RuntimeError):
    """A defect of the simulator; please report it."""
