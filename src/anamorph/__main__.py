"""`python -m anamorph` is the command `anamorph`."""

import sys

from anamorph.cli import main

sys.exit(main())
