"""The one error a user is meant to read."""


class AnamorphError(ValueError):
    """Something the user can mend: one line that names the file, the field and the remedy.

    The command line prints it on stderr and exits with code 2.
    """
