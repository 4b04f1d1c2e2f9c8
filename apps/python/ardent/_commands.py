"""Every command of the program, within Python."""

from __future__ import annotations

import json
import logging
import os
from dataclasses import dataclass
from typing import Iterator, Mapping, Optional, Sequence, Union

from . import _ardent
from ._errors import UsageError

_log = logging.getLogger("ardent")


@dataclass(frozen=True)
class Said:
    code: int  #: 0, or 4 where numbers end badly but results are written
    text: str  #: what the program would print
    warnings: "list[str]"  #: "[name] message"
    errors: "list[str]"


def _setting(value: object) -> str:
    """As `--set` takes it."""
    if hasattr(value, "tolist"):
        value = value.tolist()  # of NumPy
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)


def _flat(settings: Mapping[str, object], above: str = "") -> "Iterator[tuple[str, object]]":
    """{"library": {"order": 5}} as {"library.order": 5}."""
    if not hasattr(settings, "items"):
        raise UsageError(f"set is of type {type(settings).__name__}; want {{\"library.order\": 5}}", "config.key")
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def _log_line(line: str) -> None:
    line = line.rstrip()
    level = logging.WARNING if line.startswith(("warning ", "error ")) else logging.INFO
    _log.log(level, "%s", line)


def command(name: str, *words: "Union[str, os.PathLike[str]]", options: Sequence[str] = (),
            folder: "Optional[Union[str, os.PathLike[str]]]" = None, force: bool = False, num_threads: int = 0,
            set: Optional[Mapping[str, object]] = None) -> Said:
    """``command("study", "drive.toml", folder="s")`` does what ``ardent study drive.toml -o s`` does; `options` are
    words such as "--draws=0". What it says on its way goes to the logger "ardent". Raises Error, KeyboardInterrupt,
    MemoryError."""
    line = [name, *options]
    if folder is not None:
        line += ["-o", os.fspath(folder)]
    line += ["--force"] if force else []
    line += ["--threads", str(num_threads)] if num_threads else []
    for key, value in _flat(set or {}):
        line += ["--set", f"{key}={_setting(value)}"]
    line += ["--", *(os.fspath(word) for word in words)] if words else []
    return Said(*_ardent.command(line, _log_line))
