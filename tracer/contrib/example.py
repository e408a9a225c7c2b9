"""A small ray tracer of its own that writes a trace: python3 example.py hills.rbt

Hills of triangles under a light, a BVH with boxes fetched in pairs, and a traversal with a stack. What writes the trace are the calls of `tile`
and `writer`. example.c traces the same scene.
"""

from __future__ import annotations

import sys

from rbt_writer import MISS, NODE, POP, PRIMITIVE, PUSH, Header, Node, RaySet, Tile, Tree, Writer, inner, leaf

QUADS, WIDTH, HEIGHT, LEAF, STACK = 8, 70, 64, 4, 16
Vector = tuple[float, float, float]
LIGHT: Vector = (-2.0, 2.5, 4.0)


def make_hills() -> list[list[Vector]]:
    """The corners of all triangles."""
    offsets = [[(0, 0), (1, 0), (0, 1)], [(1, 0), (1, 1), (0, 1)]]

    def corner(x: int, z: int) -> Vector:
        return (float(x), (x * 7 + z * 13) % 5 * 0.25, float(z))

    return [[corner(t // 2 % QUADS + x, t // 2 // QUADS + z) for x, z in offsets[t % 2]] for t in range(2 * QUADS * QUADS)]


class Bvh:
    """Halves of triangles along the longest axis of their box."""

    def __init__(self, triangles: list[list[Vector]]) -> None:
        self.triangles = triangles
        self.order = list(range(len(triangles)))  # as the leaves have them: the references
        self.nodes: list[Node] = [leaf(0, 0)]
        self.boxes: list[tuple[list[float], list[float]]] = [([], [])]
        self.depth = 0
        self._build(0, 0, len(triangles), 0)

    def _build(self, node: int, first: int, count: int, level: int) -> None:
        own = self.order[first : first + count]
        corners = [corner for triangle in own for corner in self.triangles[triangle]]
        least = [min(corner[axis] for corner in corners) for axis in range(3)]
        most = [max(corner[axis] for corner in corners) for axis in range(3)]
        self.boxes[node] = (least, most)
        self.depth = max(self.depth, level)
        if count <= LEAF:
            self.nodes[node] = leaf(first, count)
            return
        longest = max(range(3), key=lambda axis: most[axis] - least[axis])
        own.sort(key=lambda triangle: sum(corner[longest] for corner in self.triangles[triangle]))
        self.order[first : first + count] = own
        left = len(self.nodes)
        self.nodes[node] = inner(left)
        self.nodes += [leaf(0, 0)] * 2
        self.boxes += [([], [])] * 2
        self._build(left, first, count // 2, level + 1)
        self._build(left + 1, first + count // 2, count - count // 2, level + 1)


def enter(box: tuple[list[float], list[float]], origin: Vector, direction: Vector, end: float) -> float:
    """Where the ray enters the box before `end`; -1 if it does not."""
    begin = 0.0
    for axis in range(3):
        inverse = 1 / (direction[axis] or 1e-30)
        low, high = ((side[axis] - origin[axis]) * inverse for side in box)
        if low > high:
            low, high = high, low
        begin, end = max(begin, low), min(end, high)
    return begin if begin <= end else -1.0


def minus(a: Vector, b: Vector) -> Vector:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def hit(corners: list[Vector], origin: Vector, direction: Vector, end: float) -> float:
    """Where the ray hits the triangle before `end`; -1 if it does not (Moller and Trumbore 1997)."""
    e1, e2, s = minus(corners[1], corners[0]), minus(corners[2], corners[0]), minus(origin, corners[0])
    p, q = cross(direction, e2), cross(s, e1)
    det = dot(e1, p)
    if det == 0:
        return -1.0
    u, v, t = dot(s, p) / det, dot(direction, q) / det, dot(e2, q) / det
    return t if u >= 0 and v >= 0 and u + v <= 1 and 0 < t < end else -1.0


def trace(bvh: Bvh, tile: Tile, origin: Vector, direction: Vector, end: float, any_hit: bool) -> tuple[int, float]:
    """The triangle that the ray hits before `end`, and where; with `any_hit`, the first one found."""
    stack: list[int] = []
    node, found = 0, MISS
    tile.step(NODE, 0)
    if enter(bvh.boxes[0], origin, direction, end) < 0:
        return found, end
    while True:
        first = bvh.nodes[node].first
        if bvh.nodes[node].kind == "inner":
            at_left, at_right = (enter(bvh.boxes[child], origin, direction, end) for child in (first, first + 1))
            tile.step(NODE, first)  # with its sibling
            if at_left >= 0 and at_right >= 0:
                is_right_nearer = at_right < at_left
                tile.step(PUSH, len(stack))
                stack.append(first + (not is_right_nearer))
                node = first + is_right_nearer
                continue
            if at_left >= 0 or at_right >= 0:
                node = first + (at_right >= 0)
                continue
        else:
            for place in range(first, first + bvh.nodes[node].count):
                at = hit(bvh.triangles[bvh.order[place]], origin, direction, end)
                tile.step(PRIMITIVE, place)
                if at >= 0:
                    end, found = at, bvh.order[place]
                    if any_hit:
                        return found, end
        if not stack:
            return found, end
        node = stack.pop()
        tile.step(POP, len(stack))


def trace_pixel(bvh: Bvh, tile: Tile, number: int) -> None:
    origin: Vector = (4.0, 5.0, -3.0)
    direction: Vector = (
        ((tile.x + number % tile.width + 0.5) / WIDTH - 0.5) * 1.6,
        (0.5 - (tile.y + number // tile.width + 0.5) / HEIGHT) * 1.6 - 0.9,
        1.0,
    )
    tile.begin_ray(0, number)
    triangle, end = trace(bvh, tile, origin, direction, 1e30, False)
    tile.end_ray(triangle)
    if triangle == MISS:
        return  # and no shadow ray is cast
    x, y, z = (origin[axis] + (end * direction[axis] + (1e-6 if axis == 1 else 0.0)) for axis in range(3))
    tile.begin_ray(1, number)
    tile.end_ray(trace(bvh, tile, (x, y, z), minus(LIGHT, (x, y, z)), 1.0, True)[0])


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: example.py FILE.rbt")
    bvh = Bvh(make_hills())
    header = Header(
        generator="example",
        scene="hills",
        scene_hash=1,
        width=WIDTH,
        height=HEIGHT,
        ray_sets=[RaySet("primary"), RaySet("shadow")],
        accel="bvh",
        traversal="stack",
        node_fetch="pair",
        loop_structure="while-while",
        stack_entries=STACK,
        depth=bvh.depth,
        flat_normals=True,
    )
    with Writer(sys.argv[1], header, Tree(bvh.nodes, bvh.order, len(bvh.order))) as writer:
        for index in range(writer.tiles):
            tile = writer.tile(index)
            for number in range(tile.width * tile.height):
                trace_pixel(bvh, tile, number)
            writer.write_tile(tile)
        writer.finish()


if __name__ == "__main__":
    main()
