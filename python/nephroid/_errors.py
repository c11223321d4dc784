"""What can go wrong. All errors of the module are an :class:`Error`."""

from __future__ import annotations


class Error(Exception):
    """An error of nephroid."""


class RefusedError(Error):
    """A scene or a sensor that a method cannot work on: one sentence names what cannot be, and what can."""


class SettingError(Error, ValueError):
    """A name that does not exist, or a value that a setting cannot have."""


class LoadError(Error):
    """A file, a text or a dict that does not become a scene, or a file that does not become a study.

    ``problems`` lists all that was found as (message, file, line, column); the attributes are of the first.
    """

    problems: list[tuple[str, str, int, int]]
    #: The problem, and what is allowed.
    message: str
    #: The file, or ``<string>``, or ``<dict>``.
    file: str
    #: Line and column, from 1; 0 of a file as a whole.
    line: int
    column: int
    #: The place in the dict, as ``"lens.bsdf.int_ior"``; None of files and texts.
    path: str | None

    def __init__(self, problems: list[tuple[str, str, int, int]], path: str | None = None) -> None:
        self.problems = list(problems)
        self.message, self.file, self.line, self.column = self.problems[0]
        self.path = path
        super().__init__(self.problems, path)

    @property
    def hint(self) -> str | None:
        """What would be allowed, if the message says so: its part after the first semicolon."""
        _, found, hint = self.message.partition("; ")
        return hint if found else None

    def __str__(self) -> str:
        if self.path is not None:
            place = self.path or "the dict"
        elif self.line:
            place = f"{self.file}:{self.line}:{self.column}"
        else:
            place = self.file
        more = len(self.problems) - 1
        return f"{place}: {self.message}" + (f" (and {more} more: problems lists them)" if more else "")
