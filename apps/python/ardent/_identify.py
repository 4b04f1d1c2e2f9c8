"""From recordings to a judged equation."""

from __future__ import annotations

import filecmp
import os
import pathlib
import tempfile
from typing import Iterable, Mapping, Optional, Union

from ._commands import command
from ._errors import OutputError, UsageError
from ._recording import Path, Recording, put, toml_text
from ._result import Result, Temporary

Recordings = Union[Recording, Path, Iterable[Union[Recording, Path]]]


class Place:
    """Where results go: a folder that somebody named, or a temporary one. Arrays, and a config where one is needed, are
    files beside it, which are gone again where no result came of it."""

    def __init__(self, folder: Optional[Path], name: str):
        self.kept = Temporary() if folder is None else None
        self.folder = self.kept.folder / name if self.kept else pathlib.Path(os.fspath(folder))
        self._written: "list[pathlib.Path]" = []

    def __enter__(self) -> "Place":
        return self

    def __exit__(self, kind, *_) -> None:
        for file in self._written if kind else []:
            file.unlink(missing_ok=True)

    def file_of(self, recording: "Recording | Path") -> str:
        """The file that a recording is, or becomes: one with the same bytes is used again."""
        found = listed(recording)
        if len(found) != 1:
            raise UsageError(f"{len(found)} recordings; want one", "recording.one")
        recording, = found
        if not isinstance(recording, Recording):
            return os.fspath(recording)
        if recording.path is not None:
            return os.fspath(recording.path)
        return str(self._beside(f"{recording.name}.npz", recording))

    def config(self, text: str) -> str:
        return str(self._beside(f"{self.folder.name}.toml", text))

    def _beside(self, name: str, what: "Recording | str") -> pathlib.Path:
        try:
            self.folder.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix=".ardent-", dir=self.folder.parent) as scratch:
                made = pathlib.Path(scratch) / name
                if isinstance(what, str):
                    made.write_text(what, encoding="utf-8")
                else:
                    what._write(made)
                return self._placed(made)
        except UnicodeEncodeError:
            raise UsageError("a name that is no text of Unicode cannot be in a config; rename it",
                             "config.name") from None
        except OutputError:
            raise
        except OSError as error:
            raise OutputError(f"{self.folder.parent} cannot be written: {error.strerror}. Choose another place",
                              "output.path") from None

    def _placed(self, made: pathlib.Path) -> pathlib.Path:
        parts = [one for one in (made, made.with_name(made.name + ".toml")) if one.exists()]
        for number in range(1, 10_000):
            stem = made.stem if number == 1 else f"{made.stem}-{number}"
            there = self.folder.parent / f"{stem}{made.suffix}"
            wanted = [there.with_name(there.name + part.name[len(made.name):]) for part in parts]
            taken = [one for one in wanted if os.path.lexists(one)]
            if len(taken) == len(parts) and all(map(_same, parts, wanted)):
                return there
            if taken or os.path.lexists(there.with_name(there.name + ".toml")):
                continue
            for part, one in zip(parts, wanted):
                put(part, one)
                self._written.append(one)
            return there
        raise OutputError(f"{self.folder.parent} has 10,000 files called {made.stem}. Choose another place",
                          "output.exists")


def _same(one: pathlib.Path, other: pathlib.Path) -> bool:
    return other.is_file() and filecmp.cmp(one, other, shallow=False)


def listed(recordings: Recordings) -> "list[Recording | Path]":
    is_one = isinstance(recordings, (Recording, str, os.PathLike, Mapping)) or not hasattr(recordings, "__iter__")
    found = [recordings] if is_one else list(recordings)
    for recording in found:
        if not isinstance(recording, (Recording, str, os.PathLike)):
            raise UsageError(f"a recording is of type {type(recording).__name__}; want the name of a file, or arrays "
                             "as ardent.Recording({\"x\": x, \"f\": f}, rate_hz=100)", "array.kind")
    return found


def options_of(recording: "Recording | Path") -> "dict[str, object]":
    """What a person said when it was read."""
    said = recording._options if isinstance(recording, Recording) else {}
    return {key: value for key, value in said.items() if value}


def identify(recordings: Recordings, folder: Optional[Path] = None, *, test: Recordings = (),
             set: Optional[Mapping[str, object]] = None, rows: bool = True, figures: bool = True, force: bool = False,
             num_threads: int = 0) -> Result:
    """`ardent run`: recordings, files or one config NAME.toml to an equation with its uncertainty and verdict.

    `folder`: results are left there; left out, they are in a temporary folder that lives as long as the result.
    Recordings from arrays are saved beside it (NAME.npz), so that the run can be repeated. `test`: recordings that are
    never fitted, only predicted. `set`: settings of the config, {"library.order": 5}; `ardent help config` lists them.
    `rows`, `figures`: whether tables with a row a sample, and figures, are written. Where no equation is found the
    result says why. Raises Error, KeyboardInterrupt, MemoryError.
    """
    fitted, tested = listed(recordings), listed(test)
    if not fitted:
        raise UsageError("there is no recording to identify; want one at least", "recording.none")
    with Place(folder, "run") as place:
        plain = len(fitted) == 1 and not tested and not options_of(fitted[0])
        word = place.file_of(fitted[0]) if plain else place.config(_config(place, fitted, tested))
        options = [*([] if rows else ["--no-rows"]), *([] if figures else ["--no-figures"])]
        said = command("run", word, options=options, folder=place.folder, force=force, num_threads=num_threads,
                       set=set)
        return Result(place.folder, place.kept, said.warnings + said.errors)


def _config(place: Place, fitted: list, tested: list) -> str:
    text = "schema = 1\n"
    for recording, is_test in [*((one, False) for one in fitted), *((one, True) for one in tested)]:
        text += f"\n[[recording]]\nfile = {toml_text(os.path.abspath(place.file_of(recording)))}\n"
        options = options_of(recording)
        if is_test and "use" in options:
            raise UsageError(f"{recording.name}: channels of a test recording are those of the first; read it without "
                             "use", "channel.role")
        for key, value in options.items():
            if key == "use":
                pairs = ", ".join(f"{role} = {toml_text(name)}" for role, name in value.items())
                text += f"use = {{ {pairs} }}\n"
            elif key == "sidecar":
                text += f"sidecar = {toml_text(os.path.abspath(value))}\n"
            else:
                text += f"{key} = {str(value).lower()}\n"
        text += 'use = "test"\n' if is_test else ""
    return text
