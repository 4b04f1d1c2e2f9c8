"""Every command of the program, within Python."""

from __future__ import annotations

import json
import logging
import os
from dataclasses import dataclass
from typing import Mapping, Optional

from . import _ardent

_log = logging.getLogger("ardent")


@dataclass(frozen=True)
class Said:
    code: int  #: 0, or 4 where numbers end badly but results are written
    text: str  #: what the program would print
    warnings: "list[str]"  #: "[name] message"
    errors: "list[str]"


def setting(value: object) -> str:
    """As `--set` takes it."""
    return value if isinstance(value, str) else json.dumps(value)


def command(*words: object, folder: "Optional[str | os.PathLike[str]]" = None, force: bool = False, threads: int = 0,
            set: Mapping[str, object] = {}) -> Said:
    """``command("study", "drive.toml", folder="s")`` does what ``ardent study drive.toml -o s`` does. What it says on its
    way goes to the logger "ardent". Raises Error, KeyboardInterrupt."""
    line = [os.fspath(word) if isinstance(word, os.PathLike) else str(word) for word in words]
    if folder is not None:
        line += ["-o", os.fspath(folder)]
    if force:
        line.append("--force")
    if threads:
        line += ["--threads", str(threads)]
    for key, value in set.items():
        line += ["--set", f"{key}={setting(value)}"]
    return Said(*_ardent.command(line, lambda text: _log.info(text.rstrip())))
