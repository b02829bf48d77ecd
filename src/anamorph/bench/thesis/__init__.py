"""The measurements of Vallance, "Trilinear projection" (PhD thesis, 2005), chapter 8 and appendix D, made again.

Its printed figures, of an 800 MHz Athlon with a GeForce 2 MX, are in `assets/`: tables C.1 and C.2
(`c-configurations`), D.1 to D.7, and 8.1 (`table-8-1`; the tracer's times of 7.4 and 7.6 are printed once, for (a)).
"""
