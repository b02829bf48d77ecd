"""What a program of any field needs; nothing here knows of mirrors, lenses or scenes.

| module | what it holds |
| --- | --- |
| `errors` | the one error that a user is meant to read |
| `output`, `video` | results as files, which appear whole or not at all |
| `interrupt` | Ctrl-C, which ends the command at once |
| `progress`, `logs` | what a terminal shows of work under way, and of what libraries say |
| `steps` | long work in steps, which can be left between any two |
| `compiled`, `vectors` | loops in machine code on all the cores, and vectors in them |
| `srgb` | the curve between linear light and 8-bit images |
| `versions` | which versions made a result |
"""
