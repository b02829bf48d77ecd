"""From an optician's prescription to a lens.

| module | what it holds |
| --- | --- |
| `prescription` | what an optician writes down, and the two surfaces that follow from it |
| `lens` | a lens between any two surfaces, as three meshes that close |
| `making` | the lens that a prescription describes, before an eye or anywhere |
"""
