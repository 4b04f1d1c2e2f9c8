"""From raw vibration recordings to an equation of motion with error bars.

    import ardent
    result = ardent.identify(ardent.Recording({"x": x, "f": f}, rate_hz=200))
    print(result)
"""

from . import _ardent
from ._commands import Said, command
from ._errors import Error, InputError, NumericsError, OutputError, UsageError
from ._identify import identify
from ._prepare import Prepared, Regime, find_regimes, prepare
from ._recording import Channel, Check, Interval, Recording, read
from ._result import Curves, Equation, Prediction, Response, Result, Term, load

__version__: str = _ardent.version
__all__ = ["Channel", "Check", "Curves", "Equation", "Error", "InputError", "Interval", "NumericsError", "OutputError",
           "Prediction", "Prepared", "Recording", "Regime", "Response", "Result", "Said", "Term", "UsageError",
           "command", "find_regimes", "identify", "load", "prepare", "read"]
