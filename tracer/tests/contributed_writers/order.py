"""Calls the writer in Python out of order and says what it says, beside one sound trace: order.py FILE.rbt"""

import sys
from typing import Callable

from one_ray import begin, filled

path = sys.argv[1]


def say(what: str, call: Callable[[], None]) -> None:
    try:
        call()
        print(f"{what}: nothing")
    except ValueError as error:
        print(f"{what}: {error}")


writer, other = begin(path), begin(path + ".rbt")
tile = filled(other)
say("another", lambda: writer.write_tile(tile))
writer.abandon()
other.abandon()
say("abandoned", lambda: other.write_tile(tile))
say("abandoned", other.finish)

with begin(path) as writer:
    tile = filled(writer)
    writer.write_tile(tile)
    writer.finish()
say("finished", lambda: writer.write_tile(tile))
say("finished", writer.finish)
