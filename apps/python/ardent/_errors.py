"""What goes wrong in the world outside the code, as the program says it."""


class Error(Exception):
    """`str()` says what was found, what was wanted and what to try; `name` is stable, as "container.truncated";
    `lines`, usually empty, are to be pasted into a sidecar or config."""

    def __init__(self, message: str, name: str = "", lines: str = ""):
        super().__init__(message)
        self.name = name
        self.lines = lines

    def __str__(self) -> str:
        text = f"[{self.name}] {self.args[0]}" if self.name else str(self.args[0])
        return f"{text}\n{self.lines}" if self.lines else text


class UsageError(Error, ValueError):
    """An argument, a setting or a sidecar asks for what cannot be done."""


class InputError(Error):
    """A recording cannot be used."""


class NumericsError(Error, ArithmeticError):
    """The numbers end badly: nothing selected, a motion that runs away, no memory."""


class OutputError(Error, OSError):
    """A result cannot be written."""


#: Where the program's own remedy is of the command line.
_IN_PYTHON = {"output.exists": "force=True, or another folder", "output.foreign": "another folder"}


def of_kind(kind: int, message: str, name: str, lines: str) -> Error:
    if name in _IN_PYTHON:
        message += f" In Python: {_IN_PYTHON[name]}."
    return (UsageError, InputError, NumericsError, OutputError)[kind](message, name, lines)
