"""The family of :class:`Mistake`: bad input is one of Python's own exceptions as well, where there is one for it."""

from __future__ import annotations

from ._core import Mistake


class NoSuchName(Mistake, KeyError):
    """A name that a result, a table or the list of scenes does not have."""

    def __str__(self) -> str:
        # A KeyError shows the repr of its text.
        return str(self.args[0])


class NoSuchFile(Mistake, FileNotFoundError):
    """A file that does not exist."""


class WrongType(Mistake, TypeError):
    """An argument of another type, or a keyword that is neither an option nor a parameter."""
