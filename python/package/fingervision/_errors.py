"""Exceptions. Each has a ``hint``: what to do about it, or ``None``."""

from __future__ import annotations

__all__ = [
    "ArgumentError",
    "ArgumentTypeError",
    "CameraError",
    "ClosedError",
    "CommandError",
    "Error",
    "FieldError",
    "FlowError",
    "NotFoundError",
    "NoteWarning",
    "ProfileError",
    "RecordingError",
    "SceneError",
    "SourceError",
    "TrackError",
    "UsageError",
]


class Error(Exception):
    """The base of all exceptions of this package."""

    hint: str | None = None
    """What to do about it, if anything."""

    def __str__(self) -> str:
        message = super().__str__()
        return message if self.hint is None else f"{message}\nhint: {self.hint}"


class ArgumentError(Error, ValueError):
    """An argument has a value that cannot be used: a shape, a channel order, a name, an array on another device."""


class ArgumentTypeError(Error, TypeError):
    """An argument has a type, or an array a dtype, that cannot be used."""


class ProfileError(Error, ValueError):
    """A profile, or a value set in it, is wrong."""


class SceneError(Error, ValueError):
    """A scene is impossible, or cannot be rendered."""


class SourceError(Error):
    """A source of frames cannot be opened, or read further."""


class NotFoundError(SourceError, FileNotFoundError):
    """There is no file or folder of this name."""


class CameraError(SourceError):
    """A camera cannot be opened, or has stopped."""


class RecordingError(SourceError):
    """A recording cannot be read."""


class ClosedError(Error, ValueError):
    """The source is closed."""


class TrackError(Error, ValueError):
    """A frame cannot be tracked: its size or its order is wrong, or the profile does not fit."""


class FlowError(Error, ValueError):
    """Images or parameters that the flow cannot be computed with."""


class FieldError(Error, AttributeError):
    """The reading lacks this field: it was not requested, or the profile does not allow it."""


class CommandError(Error):
    """A command failed."""


class UsageError(CommandError, ValueError):
    """A command was called with wrong options."""


class NoteWarning(UserWarning):
    """A note of a command for its user."""
