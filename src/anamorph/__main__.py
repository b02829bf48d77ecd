"""The command `anamorph`, also as `python -m anamorph`: minds interrupts before anything heavy is imported."""

import sys

from anamorph.base.interrupt import leave_on_interrupt


def main() -> int:
    """Run the command line and return its exit code."""
    leave_on_interrupt()
    from anamorph.cli.commands import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
