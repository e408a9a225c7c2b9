"""A trace of one ray that visits one node."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "contrib"))
from rbt_writer import MISS, NODE, Header, RaySet, Tile, Tree, Writer, leaf  # noqa: E402

HEADER = Header("one ray", "one ray", 0, [RaySet("primary")], "bvh", "stack", "pair", "while-while", rays=1)
TREE = Tree([leaf(0, 1)], [0], 1)


def begin(path: str) -> Writer:
    return Writer(path, HEADER, TREE)


def filled(writer: Writer) -> Tile:
    tile = writer.tile(0)
    tile.begin_ray(0, 0)
    tile.step(NODE, 0)
    tile.end_ray(MISS)
    return tile
