"""The measurements of Mei, Popescu and Sacks, "A hybrid backward-forward method for interactive reflections", again.

What the paper (2007) prints, of a 3.4 GHz Pentium 4 with a Quadro FX 3400, is in `assets/`: its tables 1 and 2.
"""
