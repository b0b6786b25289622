"""Result files: written beside their place under another name, and renamed at the end; whole or not there at all."""

from __future__ import annotations

import csv
import errno
import io
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy.typing as npt
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from hexathermal.errors import ArgumentError, FileFormatError, Problem
from hexathermal.poses import FloatArray
from hexathermal.predict.table_streams import TableStream, is_parquet

ENDINGS = (".csv", ".parquet", ".pq")
"""Of the names of result files."""

PICTURES, MARKED = (".png", ".svg"), 8192
MARK = "hexathermal"
"""Endings of pictures, within how many bytes from the begin they say who drew them, and the word for this library."""


def check_out(out: Path, sources: tuple[Path, ...], overwrite: bool) -> None:
    """Refuse a result file that must not or cannot be written, before any work is done."""
    if out.is_dir():
        raise ArgumentError(f"cannot write {out}: it is a folder; give the name of a file")
    target = target_of(out)
    if out.suffix.lower() not in ENDINGS:
        raise ArgumentError(f"cannot write {out}: a result file's name ends in .csv or .parquet, which says its format")
    refuse_no_folder(out)
    if target.exists():
        if any(target.samefile(source) for source in sources):
            raise ArgumentError(f"will not write {out}: it is one of the files that are read; give another name")
        if not overwrite:
            raise ArgumentError(f"{out} exists already; give another name, or ask for it to be overwritten (--force)")


def refuse_no_folder(out: Path) -> None:
    """Refuse a result file whose folder is not there, or where it cannot be written, before any work is done."""
    target = target_of(out)
    if not target.parent.is_dir():
        raise ArgumentError(f"cannot write {out}: there is no folder {target.parent}; create it first")
    _part_of(target).unlink()  # tried: not every place tells by its permissions


def target_of(out: Path) -> Path:
    """Return the plain file, there or not, that a name stands for, links followed; refuse devices and folders."""
    target = Path(os.path.realpath(out))
    if target.is_symlink():
        raise ArgumentError(f"cannot write {out}: it is a link that leads in a circle; remove it")
    if target.exists() and not target.is_file():
        raise ArgumentError(f"cannot write {out}: it is no plain file (a folder, device or pipe); give another name")
    return target


@contextmanager
def written_whole(out: Path) -> Iterator[Path]:
    """Give a file beside `out` to write to; it takes the place of `out` at the end, or vanishes on any error."""
    with written_together((out,)) as (part,):
        yield part


@contextmanager
def written_together(outs: Sequence[Path]) -> Iterator[tuple[Path, ...]]:
    """Give a file beside each of `outs` to write to; all take their places at the end, or all vanish on any error.

    Links are followed, and a file that is replaced hands its permissions on.
    """
    targets = tuple(target_of(out) for out in outs)
    parts: list[Path] = []
    try:
        for target in targets:
            parts.append(_part_of(target))  # noqa: PERF401 (those made so far are removed on an error)
        yield tuple(parts)
        modes = [stat.S_IMODE(target.stat().st_mode) if target.exists() else None for target in targets]
        for part, mode in zip(parts, modes, strict=True):
            if mode is not None:
                with suppress(OSError):  # some file systems have no permissions
                    part.chmod(mode)
        for part, target in zip(parts, targets, strict=True):
            os.replace(part, target)
    except BaseException as error:
        for part in parts:
            with suppress(OSError):
                part.unlink()
        say_where(error, *outs)
        raise


@contextmanager
def written_folder(folder: Path, *, force: bool = False) -> Iterator[Path]:
    """Give an empty folder to write files into; at the end they take their places in `folder`, or vanish on any error.

    `folder` and its parents are made where they are missing, and are gone again after an error. Files of the same name
    are replaced, others stay.

    Parameters
    ----------
    folder : Path
    force : bool
        Pictures of the same name that others drew may be replaced, too.

    Raises
    ------
    ArgumentError
        `folder` is no folder or cannot be made, or another run is writing it.
    FileExistsError
        It holds a picture of the same name that others drew.
    """
    target = Path(os.path.realpath(folder))
    refuse_no_place(target)
    there = target.is_dir()
    part = target / ".part" if there else target.with_name(target.name + ".part")
    made = [] if there else [one for one in part.parents if not one.exists()]
    try:
        part.parent.mkdir(parents=True, exist_ok=True)
        part.mkdir()
    except OSError as error:
        if part.exists():
            raise ArgumentError(
                f"{part} exists: another run is writing it, or was killed; remove it if none is, and try again"
            ) from None
        raise ArgumentError(f"cannot make the folder {folder}: {error.strerror or error}") from None
    try:
        yield part
        if there:
            strange = [] if force else _others_pictures(part, target)
            if strange:
                said = f"{', '.join(strange)} there: of another program, or of an earlier version"
                raise FileExistsError(errno.EEXIST, said, folder)
            for file in sorted(part.iterdir()):
                os.replace(file, target / file.name)
            part.rmdir()
        else:
            os.replace(part, target)
    except BaseException as error:
        shutil.rmtree(part, ignore_errors=True)
        with suppress(OSError):  # not empty: somebody else uses it
            for one in made:
                one.rmdir()
        say_where(error, folder)
        raise


def _others_pictures(part: Path, target: Path) -> list[str]:
    """Return which pictures would be replaced although no hexathermal that marks its own drew them."""
    there = (target / file.name for file in sorted(part.iterdir()) if file.suffix in PICTURES)
    return [file.name for file in there if file.is_file() and MARK.encode() not in _begin(file)]


def _begin(file: Path) -> bytes:
    """Return the first bytes of a file."""
    with file.open("rb") as stream:
        return stream.read(MARKED)


def say_where(error: BaseException, *places: Path) -> None:
    """Give an error of the system the places that were written: a full disk names none, or one gone again."""
    if isinstance(error, OSError) and error.errno is not None and ".part" in str(error.filename or ".part"):
        error.filename = ", ".join(str(place) for place in places)


def refuse_no_place(folder: Path) -> None:
    """Refuse a folder for results that is none, or where nothing can be made, before any work is done."""
    if folder.exists() and not folder.is_dir():
        raise ArgumentError(f"cannot write into {folder}: it is no folder; give another name")
    target = Path(os.path.realpath(folder))
    there = next(one for one in (target, *target.parents) if os.path.exists(one))
    try:
        os.rmdir(tempfile.mkdtemp(".part", dir=there))
    except OSError as error:
        raise ArgumentError(
            f"cannot write into {folder}: nothing can be made in {there} ({error.strerror or error}); give another "
            "place"
        ) from None


def _part_of(target: Path) -> Path:
    """Create the file that is written in the place of `target`, readable by no more people than that."""
    part = target.with_name(target.name + ".part")
    private = target.exists() and not stat.S_IMODE(target.stat().st_mode) & 0o077
    try:
        os.close(os.open(part, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600 if private else 0o666))
    except FileExistsError:
        raise ArgumentError(
            f"{part} exists: another run is writing it, or was killed; remove it if none is, and try again"
        ) from None
    except OSError as error:
        raise ArgumentError(
            f"cannot write into the folder {target.parent}: {error.strerror or error}; give another place"
        ) from None
    return part


class TableWriter:
    """Writes blocks of columns to a CSV or Parquet file; opened with the first block."""

    def __init__(self, part: Path, out: Path, source: TableStream) -> None:
        self.part, self.parquet, self.source = part, is_parquet(out), source
        self._writer: Any = None
        self._sink: Any = None

    def __enter__(self) -> TableWriter:
        return self

    def __exit__(self, *_error: object) -> None:
        for open_ in (self._writer, self._sink):
            if open_ is not None:
                open_.close()

    def write(self, columns: dict[str, FloatArray], extras: tuple[Any, ...]) -> None:
        """Write the next rows."""
        arrays: dict[str, npt.NDArray[Any] | pa.Array] = dict(columns)
        for name, column in zip(self.source.header.extras, extras, strict=True):
            arrays[name] = column if self.parquet else self._text(name, column)
        block = pa.RecordBatch.from_pydict(arrays)
        if self._writer is None:
            self._writer = self._opened(block.schema)
        self._writer.write_batch(block)

    def _opened(self, schema: Any) -> Any:
        """Return a writer. The header of a CSV file is written here: Arrow would put every name in quotes."""
        if self.parquet:
            return pa.parquet.ParquetWriter(self.part, schema)
        line = io.StringIO()
        csv.writer(line, lineterminator="\n").writerow(schema.names)
        self._sink = pa.OSFile(str(self.part), "wb")
        self._sink.write(line.getvalue().encode())
        return pa.csv.CSVWriter(self._sink, schema, write_options=pa.csv.WriteOptions(include_header=False))

    def _text(self, name: str, column: Any) -> Any:
        """Return a copied column as texts."""
        try:
            return column.cast(pa.string())
        except (pa.ArrowNotImplementedError, pa.ArrowInvalid):
            header = self.source.header
            message = f"column {name} holds {column.type}, which cannot be written as CSV; write Parquet or remove it"
            raise FileFormatError(str(self.source.path), (Problem(1, header.column(name), message),)) from None
