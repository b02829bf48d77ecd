"""Tables on the terminal, and that of a comparison."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from anamorph.measure.compare import Comparison
from anamorph.measure.figures import number, rows_of


def headed(title: str, caption: str, *columns: str, words: int = 1) -> Table:
    """An empty table whose first columns, `words` of them, hold text, and the others figures."""
    table = Table(title=Text(title), caption=Text(caption), title_justify="left", caption_justify="left")
    for place, column in enumerate(columns):
        table.add_column(column, justify="left" if place < words else "right")
    return table


def comparison_table(comparison: Comparison) -> Table:
    """Measures as rows, methods as columns."""
    width, height = comparison.size
    frames = max((result.timing.n for result in comparison.methods), default=0)
    plain = comparison.without_mirrors
    alone = "" if plain is None else f", {number(plain.median)} ms without mirrors"
    table = headed(
        f"{comparison.scene}, {width} x {height}, against {comparison.reference}",
        f"{comparison.adapter}; frame times over {frames} frames, the eye moving{alone}",
        "",
        "unit",
        words=2,
    )
    for result in comparison.methods:
        table.add_column(Text(result.name), justify="right", overflow="fold")
    for row in rows_of(comparison):
        table.add_row(row.label, row.unit, *(row.cell(comparison, result) for result in comparison.methods))
    return table


def print_table(table: Table) -> None:
    """Print a table on stdout: as wide as the terminal, or as wide as it needs to be where there is none."""
    console = Console(highlight=False)
    if not console.is_terminal:
        console.width = max(80, Console(width=10_000).measure(table).maximum)
    console.print(table)
