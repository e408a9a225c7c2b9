"""Tries what the types of C exclude and says how it is refused, beside one sound trace: limits.py FILE.rbt"""

import sys
from dataclasses import replace
from typing import Callable

from one_ray import HEADER, TREE, begin, filled
from rbt_writer import Node, RaySet, Tree, Writer, wide

path = sys.argv[1]


def say(call: Callable[[], object]) -> None:
    try:
        call()
        print("nothing")
    except (TypeError, ValueError) as error:
        print(f"{type(error).__name__}: {error}")


for change in (
    {"ray_sets": [RaySet("primary"), RaySet("diffuse", sample=-1)]},
    {"ray_sets": [RaySet("primary"), RaySet("soft-shadow", light=1 << 40)]},
    {"depth": -1},
    {"depth": 1 << 40},
    {"depth": 1.5},
    {"stack_entries": 1.5},
    {"scene_hash": -1},
    {"sah_costs": (1.0,)},
    {"sah_costs": (1.0, 10**400)},
    {"scene": "\ud800"},
    {"more": {"remarks": float("nan")}},
    {"more": {"depth": 1}},
    {"more": {"node_format": "full-4"}},
):
    say(lambda: Writer(path, replace(HEADER, **change), TREE))
wide_header = replace(HEADER, accel="wide-bvh", node_format="full-4", node_fetch="single")
say(lambda: Writer(path, wide_header, Tree([wide(1 << 32, 0, 1)], [0], 1)))
say(lambda: Writer(path, HEADER, Tree([Node("inner", 1, 1), *TREE.nodes], [0], 1)))
with begin(path) as writer:
    writer.write_tile(filled(writer))
    say(lambda: writer.finish(-1))
    say(lambda: writer.finish(1 << 64))
    writer.finish()
