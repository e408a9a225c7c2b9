"""Writes a trace with numbers of another package's type, and compares it with one of Python's: foreign.py FILE.rbt"""

import functools
import os
import sys
from dataclasses import replace
from pathlib import Path

from one_ray import HEADER
from rbt_writer import PRIMITIVE, Tree, Writer, inner, leaf


@functools.total_ordering
class Foreign:
    """A number to compare and to index with, as of numpy, whose sums and differences overflow."""

    def __init__(self, value: int) -> None:
        self._value = value

    def __index__(self) -> int:
        return self._value

    def __eq__(self, other: object) -> bool:
        return self._value == other

    def __lt__(self, other: int) -> bool:
        return self._value < other


def write(path: str, number: type) -> bytes:
    one = number(1)
    header = replace(HEADER, rays=one, depth=one, stack_entries=one, scene_hash=one)
    tree = Tree([inner(one), leaf(number(0), one), leaf(one, one)], [one, number(0)], 2)
    with Writer(path, header, tree) as writer:
        tile = writer.tile(0)
        tile.begin_ray(0, 0)
        tile.step(PRIMITIVE, one)
        tile.end_ray(number(0))
        writer.write_tile(tile)
        writer.finish()
    return Path(path).read_bytes()


path = sys.argv[1]
plain = write(path + ".rbt", int)
os.remove(path + ".rbt")
print("the same" if write(path, Foreign) == plain else "another")
