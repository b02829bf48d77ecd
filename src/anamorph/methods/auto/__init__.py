"""The default: within half a pixel of the reference, by searching or by tracing, whichever is cheaper for a frame.

| what | module |
| --- | --- |
| the choice, and its options | `auto` |
| what searching and tracing cost | `costs` |
"""

from anamorph.methods.auto.auto import METHOD as METHOD
from anamorph.methods.auto.auto import AutoDrawing as AutoDrawing
from anamorph.methods.auto.auto import Options as Options
from anamorph.methods.auto.costs import Costs as Costs
from anamorph.methods.auto.costs import costs_here as costs_here
