"""The program davarlab of this distribution: starts the workbench if its requirements are
installed.
"""

import sys

from .errors import missing, not_installed


def main() -> int:
    """Runs davarlab with the arguments of the command line. Returns its exit status."""
    absent = missing()
    if absent:
        print(f"davarlab: {not_installed(absent)}", file=sys.stderr)
        return 2
    from davarlab import cli

    return int(cli.main(sys.argv[1:]))
