"""What one file or one picture may ask for: whoever asks for more is told before memory is taken for it."""

MOST_BYTES = 2**31
"""Of a file that is read, 2 GiB."""

MOST_PIXELS = 2**26
"""Of an image that is read, or a picture that is drawn: 8192 x 8192."""

MOST_NUMBERS = 2**28
"""Of one array in a file, whose header may ask for any count without bytes behind it."""

SCENE_BYTES = 2**22
"""Of a scene file, 4 MiB."""

LONGEST_KEY = 16
"""Names of a dotted key in a scene file: reading costs the square of their number."""

LONGEST_CHAIN = 32
"""Scene files that start from each other."""
