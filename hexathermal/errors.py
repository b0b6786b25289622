"""Every error of the package: one base, and children that carry the leg, the value and the limits.

Children also inherit `ValueError` (the input is wrong) or `RuntimeError` (the work could not be done).
"""

from __future__ import annotations

from dataclasses import dataclass


class HexathermalError(Exception):
    """Base of all errors raised on purpose by hexathermal."""


class ArgumentError(HexathermalError, ValueError):
    """An argument has the wrong shape, type, unit or value."""


class DataError(ArgumentError):
    """Measured data do not suffice for what is asked of them: too few rows, no values, nothing that changes."""


class UnknownNameError(HexathermalError, ValueError):
    """A name is not known; `available` lists those that are."""

    def __init__(self, message: str, available: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.available = available

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self), (str(self), self.available))


class _FieldsError(HexathermalError, ValueError):
    """An error with fields beside its message; both survive pickling."""

    def __reduce__(self) -> tuple[object, ...]:
        return (_rebuilt, (type(self), str(self), self.__dict__))


def _rebuilt(kind: type[_FieldsError], message: str, fields: dict[str, object]) -> _FieldsError:
    """Return a pickled error as it was."""
    error = kind(message)
    error.__dict__.update(fields)
    return error


class KinematicsError(_FieldsError):
    """A pose or a set of leg lengths that the machine cannot take.

    Attributes
    ----------
    leg : int or None
        Number of the leg, 1 to 6.
    value, lower, upper : float or None
        What was found, and the limits it was held against (SI units, as the message says).
    index : tuple of int
        Place in the batch, empty for a single pose.
    """

    def __init__(
        self,
        message: str,
        *,
        leg: int | None = None,
        value: float | None = None,
        lower: float | None = None,
        upper: float | None = None,
        index: tuple[int, ...] = (),
    ) -> None:
        super().__init__(message)
        self.leg, self.value, self.lower, self.upper, self.index = leg, value, lower, upper, index


class OutOfStrokeError(KinematicsError):
    """A leg would have to be shorter or longer than its stroke allows."""


class JointConeError(KinematicsError):
    """A leg leans further out of its home direction than a joint allows."""


class SingularPoseError(KinematicsError):
    """The platform is at, or too near, a singular pose: leg lengths no longer hold it."""


class NotConvergedError(KinematicsError, RuntimeError):
    """No pose with these leg lengths was found on the branch of the start."""


class OtherBranchError(KinematicsError):
    """The lengths were met, but only in another posture than the one reached from the start."""


class ThermalModelError(HexathermalError, ValueError):
    """The machine has no thermal law (compensation is not active), or the law is unusable."""


class TemperatureError(_FieldsError):
    """A temperature is missing, not a number, impossible, or outside the law's range.

    Attributes
    ----------
    sensor : str
        Name of the sensor.
    value, lower, upper : float or None
        Temperature found and the law's range, degrees Celsius.
    index : tuple of int
        Place in the batch, empty for a single set of temperatures.
    """

    def __init__(
        self,
        message: str,
        *,
        sensor: str = "",
        value: float | None = None,
        lower: float | None = None,
        upper: float | None = None,
        index: tuple[int, ...] = (),
    ) -> None:
        super().__init__(message)
        self.sensor, self.value, self.lower, self.upper, self.index = sensor, value, lower, upper, index


@dataclass(frozen=True)
class Problem:
    """One bad field of a file: where it stands and what is wrong with it."""

    line: int
    column: int
    message: str

    def __str__(self) -> str:
        return f"line {self.line}, column {self.column}: {self.message}"


class FileFormatError(HexathermalError, ValueError):
    """A file breaks its format; `problems` lists every bad field, not only the first."""

    def __init__(self, path: str, problems: tuple[Problem, ...]) -> None:
        lines = "\n".join(f"  {path}, {problem}" for problem in problems)
        count = f"{len(problems)} problem" + ("s" if len(problems) != 1 else "")
        super().__init__(f"{path}: {count}\n{lines}")
        self.path, self.problems = path, problems

    def __reduce__(self) -> tuple[object, ...]:
        return (FileFormatError, (self.path, self.problems))
