"""The ``tremie`` program: ``tremie`` after an installation, or ``python -m tremie``."""

import os
import signal
import sys
from typing import NoReturn

from tremie import _tremie


def main() -> NoReturn:
    """Does what the command line asks for."""
    # The program has its own: a run ends in order at Ctrl-C. A component ignores it, and goes on so.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_tremie.program(sys.argv[1:], sys.executable, os.path.abspath(__file__)))


if __name__ == "__main__":
    main()
