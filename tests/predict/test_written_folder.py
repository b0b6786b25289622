"""Folders of results: whole or not there at all."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from hexathermal.errors import ArgumentError
from hexathermal.predict.table_writing import written_folder
from hexathermal.show.figures import save_figure


def files_below(folder: Path) -> set[str]:
    return {str(item.relative_to(folder)) for item in folder.rglob("*")}


def test_files_take_their_places_at_the_end(tmp_path: Path) -> None:
    """A new folder, with its parents, and an old one: nothing is in its place before the end; other files stay."""
    new, old = tmp_path / "a" / "b", tmp_path / "old"
    old.mkdir()
    (old / "kept").write_text("1", encoding="utf-8")
    (old / "replaced").write_text("1", encoding="utf-8")
    for folder in (new, old):
        with written_folder(folder) as part:
            (part / "replaced").write_text("2", encoding="utf-8")
            assert folder.exists() == (folder == old)
            assert (old / "replaced").read_text(encoding="utf-8") == "1"
    assert (old / "replaced").read_text(encoding="utf-8") == "2"
    assert files_below(tmp_path) == {"a", "a/b", "a/b/replaced", "old", "old/kept", "old/replaced"}


def _written(folder: Path, error: type[BaseException]) -> None:
    with written_folder(folder) as part:
        (part / "kept").write_text("2", encoding="utf-8")
        raise error("x")


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError, ArgumentError])
def test_an_error_leaves_what_was_there(tmp_path: Path, error: type[BaseException]) -> None:
    """After any error neither files nor folders that were made are left."""
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "kept").write_text("1", encoding="utf-8")
    for folder in (tmp_path / "a" / "b", tmp_path / "old"):
        with pytest.raises(error):
            _written(folder, error)
    assert files_below(tmp_path) == {"old", "old/kept"}
    assert (tmp_path / "old" / "kept").read_text(encoding="utf-8") == "1"


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    """A file in the place of the folder or of its parent, and another run that writes at the same time."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ArgumentError, match="is no folder"), written_folder(tmp_path / "file"):
        pass
    with pytest.raises(ArgumentError, match="nothing can be made in"), written_folder(tmp_path / "file" / "deep"):
        pass
    with written_folder(tmp_path / "report") as part:
        (part / "mine").write_text("1", encoding="utf-8")
        with pytest.raises(ArgumentError, match="another run is writing it"), written_folder(tmp_path / "report"):
            pass
    assert (tmp_path / "report" / "mine").exists()


def test_pictures_that_others_drew_are_not_replaced(tmp_path: Path) -> None:
    """One of our own is, and others with force; an error names them, and nothing of the folder was touched."""
    folder = tmp_path / "plots"

    def write(*, force: bool = False) -> None:
        with written_folder(folder, force=force) as part:
            save_figure(Figure(), part / "gain.png")
            save_figure(Figure(), part / "gain.svg")
            (part / "numbers.json").write_text("{}", encoding="utf-8")

    write()
    write()
    for name in ("gain.png", "gain.svg"):
        (folder / name).write_bytes(b"drawn elsewhere")
        with pytest.raises(FileExistsError, match=name):
            write()
        assert (folder / name).read_bytes() == b"drawn elsewhere"
        write(force=True)
    assert files_below(folder) == {"gain.png", "gain.svg", "numbers.json"}
