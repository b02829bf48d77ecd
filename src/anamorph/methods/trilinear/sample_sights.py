"""What each sample sees: of the pairs of its ray triangle, the nearest whose scene triangle its ray meets. Compiled.

Over a block of samples a quadratic is at most its tangent at the middle plus a bound on its second-order terms. A block
in which something of a pair is negative everywhere sees nothing of it; others are halved, until so few samples are left
that each is asked. The samples of two ray triangles are never the same, so that cores share nothing.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.pairs import Workspace
from anamorph.methods.trilinear.sights import Sights
from anamorph.methods.trilinear.terms import ACROSS, AHEAD, TERMS, falls_short, is_inside

BLOCK = 24
"""Samples of a block that is not halved any more."""

PARTS = 8
"""Of a sample's side, where it matters what is shown between samples."""


@compiled
def look(beams: Beams, words: np.ndarray, work: Workspace, pairs: int, sights: Sights) -> None:
    """Have the samples of ray triangles keep what is nearest of the first `pairs` of a workspace.

    Parameters
    ----------
    beams : Beams
    words : (F, 2) uint32
        What is written for each scene triangle, seen from its back and from its front.
    work, pairs
    sights : Sights
        Changed.
    """
    stack = work.blocks
    for pair in range(pairs):
        k, terms = work.pair[pair, 0], work.terms[pair]
        word = words[work.pair[pair, 1], work.pair[pair, 2]]
        for end in range(4):
            stack[0, end] = beams.box[k, end]
        waiting = 1
        while waiting > 0:
            waiting -= 1
            x0, y0, x1, y1 = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3]
            if (x1 - x0) * (y1 - y0) <= BLOCK:
                _ask(terms, beams.center[k], beams.number[k], word, x0, y0, x1, y1, sights)
                continue
            x, y = 0.5 * (x0 + x1 - 1) - beams.center[k, 0], 0.5 * (y0 + y1 - 1) - beams.center[k, 1]
            if falls_short(terms, x, y, 0.5 * (x1 - x0 - 1), 0.5 * (y1 - y0 - 1)):
                continue
            _halve(stack, waiting)
            waiting += 2


@compiled
def keep_shown(beams: Beams, work: Workspace, pairs: int) -> int:
    """Leave out the pairs that are shown nowhere, at samples or between them; returns how many are left."""
    kept = 0
    for pair in range(pairs):
        if _may_show(beams, work, pair):
            for number in range(3):
                work.pair[kept, number] = work.pair[pair, number]
            for number in range(TERMS):
                work.terms[kept, number] = work.terms[pair, number]
            kept += 1
    return kept


@inlined
def _may_show(beams: Beams, work: Workspace, pair: int) -> bool:
    """Whether somewhere in the ray triangle, to a part of a sample, no function of a pair is negative."""
    k, terms, stack = work.pair[pair, 0], work.terms[pair], work.blocks
    for end in range(4):
        stack[0, end] = PARTS * beams.box[k, end] - PARTS // 2
    waiting = 1
    while waiting > 0:
        waiting -= 1
        x0, y0, x1, y1 = stack[waiting, 0], stack[waiting, 1], stack[waiting, 2], stack[waiting, 3]
        x, y = 0.5 * (x0 + x1) / PARTS - beams.center[k, 0], 0.5 * (y0 + y1) / PARTS - beams.center[k, 1]
        half_x, half_y = 0.5 * (x1 - x0) / PARTS, 0.5 * (y1 - y0) / PARTS
        outside = falls_short(terms, x, y, half_x, half_y)
        for corner in range(3):
            a, b, c = beams.weights[k, 0, corner], beams.weights[k, 1, corner], beams.weights[k, 2, corner]
            outside = outside or a * x + b * y + c + abs(a) * half_x + abs(b) * half_y < 0.0
        if outside:
            continue
        if (x1 - x0) * (y1 - y0) <= 1:
            return True
        _halve(stack, waiting)
        waiting += 2
    return False


@inlined
def _halve(blocks: np.ndarray, place: int) -> None:
    """Put the halves of a block at a place there and behind it."""
    x0, y0, x1, y1 = blocks[place, 0], blocks[place, 1], blocks[place, 2], blocks[place, 3]
    for half in range(2):
        blocks[place + half, 0], blocks[place + half, 1] = x0, y0
        blocks[place + half, 2], blocks[place + half, 3] = x1, y1
    if x1 - x0 > y1 - y0:
        blocks[place, 2] = blocks[place + 1, 0] = (x0 + x1) // 2
    else:
        blocks[place, 3] = blocks[place + 1, 1] = (y0 + y1) // 2


@inlined
def _ask(
    terms: np.ndarray,
    center: np.ndarray,
    number: int,
    word: int,
    x0: int,
    y0: int,
    x1: int,
    y1: int,
    sights: Sights,
) -> None:
    for row in range(y0, y1):
        y = float(row - center[1])
        for column in range(x0, x1):
            x = float(column - center[0])
            if sights.owner[row, column] == number and is_inside(terms, x, y):
                across = terms[ACROSS] * x + terms[ACROSS + 1] * y + terms[ACROSS + 2]
                ahead = terms[AHEAD] * x + terms[AHEAD + 1] * y + terms[AHEAD + 2]
                if ahead < sights.way[row, column] * across:
                    sights.way[row, column], sights.seen[row, column] = ahead / across, word
