"""From recordings to a judged equation."""

from __future__ import annotations

import json
import pathlib
from dataclasses import dataclass
from typing import Iterable, Mapping, Optional, Union

from ._commands import command
from ._errors import UsageError
from ._recording import Path, Recording
from ._result import Result, Temporary


@dataclass
class Place:
    """Where results go, and arrays beside them: a folder that somebody named, or a temporary one."""

    folder: pathlib.Path
    kept: Optional[Temporary]

    def file_of(self, recording: "Recording | Path") -> str:
        """The file that a recording is, or becomes."""
        if not isinstance(recording, Recording):
            return str(recording)
        if recording.path is not None:
            return str(recording.path)
        file = self.folder.parent / f"{recording.name}.npz"
        for number in range(2, 10_000):
            if not file.exists() and not file.with_name(file.name + ".toml").exists():
                break
            file = self.folder.parent / f"{recording.name}-{number}.npz"
        return str(recording.save(file))


def place_of(folder: Optional[Path], name: str) -> Place:
    if folder is not None:
        return Place(pathlib.Path(folder), None)
    kept = Temporary()
    return Place(kept.folder / name, kept)


def _options_of(recording: Recording) -> "dict[str, object]":
    """What a person said when it was read, as a config has it."""
    return {key: value for key, value in recording._options.items() if value}


def identify(recordings: "Recording | Path | Iterable[Union[Recording, Path]]", folder: Optional[Path] = None, *,
             test: "Iterable[Union[Recording, Path]]" = (), set: Mapping[str, object] = {},
             rows: bool = True, figures: bool = True, force: bool = False, threads: int = 0) -> Result:
    """`ardent run`: recordings, files or one config NAME.toml to an equation with its uncertainty and verdict.

    `folder`: results are left there; left out, they are in a temporary folder that lives as long as the result.
    Recordings from arrays are saved beside it (NAME.npz), so that the run can be repeated. `test`: recordings that are
    never fitted, only predicted. `set`: settings of the config, {"library.order": 5}; `ardent help config` lists them.
    `rows`, `figures`: whether tables with a row a sample, and figures, are written. Where no equation is found the result
    says why. Raises Error, KeyboardInterrupt.
    """
    place = place_of(folder, "run")
    fitted = [recordings] if isinstance(recordings, (Recording, str, pathlib.PurePath)) else list(recordings)
    tested = list(test)
    plain = len(fitted) == 1 and not tested and not (isinstance(fitted[0], Recording) and _options_of(fitted[0]))
    words = [place.file_of(fitted[0]) if plain else _config(place, fitted, tested)]
    words += [] if rows else ["--no-rows"]
    words += [] if figures else ["--no-figures"]
    said = command("run", *words, folder=place.folder, force=force, threads=threads, set=set)
    return Result(place.folder, place.kept, said.warnings + said.errors)


def _config(place: Place, fitted: list, tested: list) -> str:
    text = "schema = 1\n"
    for recording, is_test in [*((one, False) for one in fitted), *((one, True) for one in tested)]:
        file = pathlib.Path(place.file_of(recording)).absolute()
        text += f"\n[[recording]]\nfile = {json.dumps(str(file))}\n"
        options = _options_of(recording) if isinstance(recording, Recording) else {}
        if is_test and "use" in options:
            raise UsageError(f"{recording.name}: channels of a test recording are those of the first; read it without use",
                             "channel.role")
        for key, value in options.items():
            if key == "use":
                value = ", ".join(f"{role} = {json.dumps(name)}" for role, name in value.items())
                text += f"use = {{ {value} }}\n"
            else:
                value = str(pathlib.Path(value).absolute()) if key == "sidecar" else value
                text += f"{key} = {json.dumps(value)}\n"
        text += 'use = "test"\n' if is_test else ""
    config = place.folder.parent / f"{place.folder.name}.toml"
    with open(config, "x", encoding="utf-8") as out:
        out.write(text)
    return str(config)
