"""Writes the trace that a listing on standard input tells of, through the writer in Python: rewrite.py FILE.rbt < listing"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "contrib"))
from rbt_writer import Header, RaySet, Tree, TwoLevel, Writer, inner, leaf, wide  # noqa: E402

# Bytes that are not UTF-8 become lone surrogates.
sys.stdin.reconfigure(encoding="utf-8", errors="surrogateescape")
generator, scene, more, rest = sys.stdin.read().split("\n", 3)
words = iter(rest.split())


def number() -> int:
    return int(next(words))


def numbers(count: int) -> list:
    return [number() for _ in range(count)]


def tree() -> Tree:
    nodes = []
    for _ in range(number()):
        kind, first, count, leaves = numbers(4)
        nodes.append([inner(first), leaf(first, count), wide(first, count, leaves)][kind])
    references = numbers(number())
    seconds = numbers(number())
    return Tree(nodes, references, number(), seconds)


scene_hash, width, height, rays = numbers(4)
ray_sets = [RaySet(next(words), number(), number()) for _ in range(number())]
accel, traversal, node_format, node_fetch, loop_structure = (next(words) for _ in range(5))
stack_entries, short_stack, trail_bits = numbers(3)
sah_costs = (float(next(words)), float(next(words)))
depth, closest_hit_shadows, flat_normals = numbers(3)
header = Header(
    generator=generator,
    scene=scene,
    scene_hash=scene_hash & (1 << 64) - 1,
    ray_sets=ray_sets,
    accel=accel,
    traversal=traversal,
    node_fetch=node_fetch,
    loop_structure=loop_structure,
    width=width,
    height=height,
    rays=rays,
    node_format=None if node_format == "-" else node_format,
    stack_entries=stack_entries,
    short_stack=short_stack,
    trail_bits=trail_bits,
    sah_costs=sah_costs,
    depth=depth,
    closest_hit_shadows=bool(closest_hit_shadows),
    flat_normals=bool(flat_normals),
    more=json.loads("{" + more + "}"),
)
first = tree()
meshes = numbers(number())
blases = [tree() for _ in range(number())]
structure = TwoLevel(first, meshes, blases) if accel == "two-level" else first
try:
    with Writer(sys.argv[1], header, structure) as writer:
        for _ in range(number()):
            tile = writer.tile(number())
            for _ in range(number()):
                ray_set, ray, triangle, steps = numbers(4)
                tile.begin_ray(ray_set, ray)
                for _ in range(steps):
                    tile.step(number(), number())
                tile.end_ray(triangle)
            writer.write_tile(tile)
        writer.finish(number())
except (ValueError, OSError) as error:
    print(error, file=sys.stderr)
    sys.exit(1)
