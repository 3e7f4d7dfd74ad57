"""The ``tremie`` program: ``tremie`` after an installation, or ``python -m tremie``."""

import os
import signal
import sys
from typing import NoReturn

if __package__:
    from . import _tremie
else:
    # As a script, for each component of a run: without the package and NumPy, which take time to import.
    try:
        import _tremie
    except ImportError:
        # Where PYTHONSAFEPATH keeps the script's folder from the path.
        from tremie import _tremie


def main() -> NoReturn:
    """Does what the command line asks for."""
    # The program has its own: a run ends in order at Ctrl-C. A component ignores it, and goes on so.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_tremie.program(sys.argv[1:], sys.executable, os.path.abspath(__file__)))


if __name__ == "__main__":
    main()
