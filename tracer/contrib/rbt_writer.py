"""Writes raybudget trace files (.rbt, version 1) from any renderer. Python 3.9 or later, no other packages.

A trace says what each ray visited; docs/trace-format.md has the format and the meaning of every step and header field. The names are those of
rbt_writer.h, its twin in C.

    with Writer("frame.rbt", header, tree) as writer:
        for index in range(writer.tiles):
            tile = writer.tile(index)
            for each set and ray that is cast, in any order:
                tile.begin_ray(set, ray)
                tile.step(NODE, id) ...                  from inside the traversal loop
                tile.end_ray(triangle or MISS)
            writer.write_tile(tile)
        writer.finish()

What does not fit the format raises a ValueError, what is of another type a TypeError, what the disk refuses an OSError. Only a reader checks what
Header.more means and what `compress` makes. The file has another name until finish() renames it; left without it, also by an exception, the `with`
block leaves no file.

Tiles only read their writer: several can be filled and encoded (Tile.end) at once, by a thread each, and one thread writes them in rising order.

The data are in zstd frames, but not compressed. `Writer(..., compress=f)` compresses them, where `f` makes a zstd frame of bytes, such as
`compression.zstd.compress` of Python 3.14.
"""

from __future__ import annotations

import json
import operator
import os
import secrets
import struct
import sys
from dataclasses import dataclass, field, replace
from typing import Any, Callable, Optional, Sequence, Union

__all__ = [
    "POP", "RESTART", "UP", "NODE", "PUSH", "INSTANCE", "PRIMITIVE", "ANY_HIT", "MISS",
    "Header", "Node", "RaySet", "Tile", "Tree", "TwoLevel", "Writer", "inner", "leaf", "wide", "xxh3_64",
]

# What a step did, and what its id names.
POP = 0  # an entry of the stack was read; its depth, from 0
RESTART = 1  # the traversal began again; from this node
UP = 2  # an ancestor was fetched again; node
NODE = 3  # a node was fetched and tested; node
PUSH = 4  # an entry of the stack was written; its depth, from 0
INSTANCE = 5  # the ray went into an instance; instance
PRIMITIVE = 6  # a triangle was tested; its place in the list of references
ANY_HIT = 7  # an any-hit shader ran; the place in the list of references just tested

MISS = -1
"""The triangle of a ray that hit nothing."""

_OPS = ("Pop", "Restart", "Up", "Node", "Push", "Instance", "Primitive", "AnyHit")
# Ids of one kind are written as differences: stack, node, instance, primitive.
_KIND_OF_OP = (0, 1, 1, 1, 0, 2, 3, 3)
_TILE_EDGE = 32
_TILE_RAYS = 1024
_MOST_IDS = (1 << 29) - 1
_MOST_CHUNK_BYTES = 1 << 29
_MOST_TILE_STEPS = 1 << 26

# The structures, and the traversals of each.
_TRAVERSALS = {
    "bvh": ("stack", "parent-link", "restart-trail"), "wide-bvh": ("stack", "short-stack"),
    "kd": ("stack", "restart", "push-down", "backtrack"), "grid": ("dda",), "two-level": ("stack", "short-stack"),
}
_NODE_FORMATS = ("full-4", "full-8", "compressed-8", "compressed-8-pairs", "adreno-8")
_NODE_FETCHES = ("single", "pair")
_LOOP_STRUCTURES = ("while-while", "if-if", "single-loop")
# The kinds of ray sets, and the kind that each starts from.
_STARTS_FROM = {
    "primary": None, "shadow": "primary", "soft-shadow": "primary", "reflection": "primary", "reflection-shadow": "reflection",
    "ambient-occlusion": "primary", "diffuse": "primary", "diffuse-shadow": "diffuse",
}
_GOES_TO_LIGHT = ("shadow", "soft-shadow", "reflection-shadow", "diffuse-shadow")


@dataclass(frozen=True)
class RaySet:
    """A set of rays, at most one for each pixel.

    `sample` is which of its pixel, `light` to which its rays go, both from 0. The n-th "shadow" goes to light n, whatever `light` says.
    """

    kind: str
    sample: int = 0
    light: int = 0

    def _in_header(self) -> Union[str, dict[str, Any]]:
        if self.kind in ("primary", "shadow"):
            return self.kind
        table: dict[str, Any] = {"kind": self.kind, "sample": int(self.sample)}
        if self.kind in _GOES_TO_LIGHT:
            table["light"] = int(self.light)
        return table


@dataclass(frozen=True)
class Node:
    """A node's links. Make one with `inner`, `leaf` or `wide`."""

    kind: str
    first: int
    count: int
    leaves: int = 0


def inner(left: int) -> Node:
    """A node with the children `left` and `left + 1`, behind it."""
    return Node("inner", operator.index(left), 2)


def leaf(first: int, count: int) -> Node:
    """A node with the references `first` to `first + count - 1`."""
    return Node("leaf", operator.index(first), operator.index(count))


def wide(first: int, count: int, leaves: int) -> Node:
    """A wide node: nodes `first` to `first + count - 1` are its children, and `leaves` leaves, which are no nodes; at most 8 together."""
    return Node("wide", operator.index(first), operator.index(count), operator.index(leaves))


@dataclass
class Tree:
    """A tree without its boxes.

    `nodes` has the root first; of a grid its cells, all leaves. `references` are triangles in the order of the leaves; of a TLAS, instances.
    `triangles` is how many there are to refer to. `seconds`, only with "compressed-8-pairs", are the second places of pairs, rising.
    """

    nodes: Sequence[Node]
    references: Sequence[int]
    triangles: int
    seconds: Sequence[int] = ()


@dataclass
class TwoLevel:
    """A TLAS over instances, the mesh of each instance, and a BLAS for each mesh.

    Nodes of all trees are numbered together: the TLAS from 0, and each BLAS from the next even number; references of BLASes together, one BLAS
    after the other.
    """

    tlas: Tree
    meshes: Sequence[int]
    blases: Sequence[Tree]


@dataclass
class Header:
    """What the trace is a trace of.

    The frame is an image of `width` by `height` pixels, each from 1 to 32768, or a list of 1 to 2^30 `rays`. `stack_entries` are those in memory,
    `short_stack` those in registers, each at most 65536. `trail_bits` is 32 or 64 with a restart trail, else 0. `more` has keys that are not among
    these, such as "remarks". That it is JSON is checked; only a reader checks what it means.
    """

    generator: str
    scene: str
    scene_hash: int
    ray_sets: Sequence[RaySet]
    accel: str
    traversal: str
    node_fetch: str
    loop_structure: str
    width: int = 0
    height: int = 0
    rays: int = 0
    node_format: Optional[str] = None
    stack_entries: int = 0
    short_stack: int = 0
    trail_bits: int = 0
    sah_costs: tuple[float, float] = (0.0, 0.0)
    depth: int = 0
    closest_hit_shadows: bool = False
    flat_normals: bool = False
    more: dict[str, Any] = field(default_factory=dict)

    def _in_ints(self) -> Header:
        """The same with numbers that cannot overflow; numpy's can."""
        keys = ("scene_hash", "width", "height", "rays", "stack_entries", "short_stack", "trail_bits", "depth")
        return replace(self, **{key: int(operator.index(getattr(self, key))) for key in keys})

    def _text(self, triangles: int) -> bytes:
        frame = {"image": {"width": self.width, "height": self.height}} if self.width else {"list": {"rays": self.rays}}
        keys: dict[str, Any] = {
            "generator": self.generator,
            "scene": self.scene,
            "scene_hash": f"{self.scene_hash:016x}",
            "triangles": triangles,
            "frame": frame,
            "ray_sets": [ray_set._in_header() for ray_set in self.ray_sets],
            "accel": self.accel,
            "traversal": self.traversal,
            "node_format": self.node_format,
            "node_fetch": self.node_fetch,
            "loop_structure": self.loop_structure,
            "stack_entries": self.stack_entries,
            "short_stack": self.short_stack,
            "trail_bits": self.trail_bits or None,
            "sah_costs": [float(cost) for cost in self.sah_costs],
            "depth": self.depth,
            "shadow_query": "closest-hit" if self.closest_hit_shadows else None,
            "normals": False if self.flat_normals else None,
        }
        for key in self.more:
            if key in keys:
                raise ValueError(f'more has "{key}", which the header has already')
        keys = {key: value for key, value in keys.items() if value is not None}
        keys.update(self.more)
        return json.dumps(keys, separators=(",", ":"), ensure_ascii=False, allow_nan=False).encode()

    def _sources(self) -> list[Optional[int]]:
        """Checks the header. Of each ray set, the place of the set from whose hits its rays start."""
        edges = (self.width, self.height)
        is_image = any(edges)
        fits = min(edges) >= 1 and max(edges) <= 32768 and not self.rays if is_image else 1 <= self.rays <= 1 << 30
        if not fits:
            raise ValueError("an image of 1 to 32768 pixels per edge or a list of 1 to 2^30 rays expected")
        _check_text("generator", self.generator)
        _check_text("scene", self.scene)
        try:
            more = json.dumps(self.more, ensure_ascii=False, allow_nan=False)
        except ValueError as error:
            raise ValueError("more is not JSON") from error
        _check_text("more", more)
        _check_name("accel", self.accel, tuple(_TRAVERSALS))
        if self.traversal not in _TRAVERSALS[self.accel]:
            raise ValueError(f'{self.accel} has no traversal "{self.traversal}"')
        _check_name("node_fetch", self.node_fetch, _NODE_FETCHES)
        _check_name("loop_structure", self.loop_structure, _LOOP_STRUCTURES)
        if self.node_format is not None:
            _check_name("node_format", self.node_format, _NODE_FORMATS)
        if self.accel != "two-level" and (self.node_format is not None) != (self.accel == "wide-bvh"):
            raise ValueError("node_format belongs to wide-bvh, perhaps to two-level, and to no other")
        if self.traversal == "short-stack" and self.node_format is None:
            raise ValueError("a short-stack without a node_format")
        stacks = (self.stack_entries, self.short_stack)
        if min(stacks) < 0 or max(stacks) > 65536:
            raise ValueError("stacks of 0 to 65536 entries expected")
        _check_number("a scene_hash", self.scene_hash, 64)
        if self.trail_bits not in (0, 32, 64):
            raise ValueError(f"trail_bits of {self.trail_bits}, 0, 32 or 64 expected")
        if len(self.sah_costs) != 2:
            raise ValueError(f"sah_costs of {len(self.sah_costs)} numbers, 2 expected")
        if not all(abs(cost) <= sys.float_info.max for cost in self.sah_costs):
            raise ValueError("sah_costs are not finite")
        _check_number("a depth", self.depth, 32)
        if not 1 <= len(self.ray_sets) <= 1024:
            raise ValueError(f"{len(self.ray_sets)} ray sets, 1 to 1024 expected")
        sources: list[Optional[int]] = []
        for place, ray_set in enumerate(self.ray_sets):
            _check_name("ray set", ray_set.kind, tuple(_STARTS_FROM))
            _check_number("a sample", ray_set.sample, 32)
            _check_number("a light", ray_set.light, 32)
            origin = _STARTS_FROM[ray_set.kind]
            source = next(
                (
                    at
                    for at, other in enumerate(self.ray_sets)
                    if other.kind == origin and (origin == "primary" or other.sample == ray_set.sample)
                ),
                None,
            )
            if ray_set.kind not in ("primary", "shadow") and (source is None or source > place):
                raise ValueError(f"ray set {place} ({ray_set.kind}) without the set before it from whose hits it starts")
            sources.append(source)
        return sources


class Writer:
    """Writes a trace file. Use it in a `with` statement, or call `finish` or `abandon` at the end."""

    def __init__(
        self,
        path: Union[str, os.PathLike[str]],
        header: Header,
        structure: Union[Tree, TwoLevel],
        compress: Optional[Callable[[bytes], bytes]] = None,
    ) -> None:
        """Opens a temporary file beside `path` and writes the header and the structure."""
        header = header._in_ints()
        self._sources = header._sources()
        self._plain = [ray_set.kind in ("primary", "shadow") for ray_set in header.ray_sets]
        self._compress = compress
        encoded, nodes, references, instances, self._triangles = _structure(header, structure)
        # A pair reads the sibling too; the root has none.
        pairs = header.node_fetch == "pair" and not isinstance(structure, TwoLevel)
        node_steps = max(nodes - 1, 1) if pairs else nodes
        stack = max(header.stack_entries, header.short_stack)
        self._id_limits = (stack, nodes, nodes, node_steps, stack, instances, references, references)
        self._image = (header.width, header.height) if header.width else None
        self._rays = header.rays
        self.tiles: int = -(-header.width // _TILE_EDGE) * -(-header.height // _TILE_EDGE) if self._image else -(-header.rays // _TILE_RAYS)
        """How many tiles the frame has."""
        text = header._text(self._triangles)
        if len(text) > 1 << 20:
            raise ValueError(f"a header of {len(text)} bytes, at most 2^20 fit")
        head = b"RBTRACE\x01" + struct.pack("<I", len(text)) + text
        chunk = self._chunk(bytes(encoded), 1)
        self._path = os.path.abspath(os.fsdecode(path))
        self._offsets: list[int] = []
        self._position = 0
        self._steps = 0
        self._part = f"{self._path}.{secrets.token_hex(4)}.part"
        self._file = open(self._part, "xb")
        try:
            self._write(head + _hash_bytes(head, 0))
            self._offsets.append(self._position)
            self._write(chunk)
        except BaseException:
            self.abandon()
            raise

    def tile(self, index: int) -> Tile:
        """An empty tile, counted in rows from the upper left."""
        return Tile(self, index)

    def write_tile(self, tile: Tile) -> None:
        """Appends the next tile."""
        if self._file.closed:
            raise ValueError("no trace is open")
        if tile._writer is not self:
            raise ValueError(f"tile {tile.index} is of another writer")
        expected = len(self._offsets) - 1
        if tile.index != expected:
            raise ValueError(f"tile {tile.index} is written where tile {expected} is expected")
        chunk = tile.end()
        self._offsets.append(self._position)
        self._steps += tile.steps
        self._write(chunk)

    def finish(self, stalls: int = 0) -> None:
        """Ends the file and gives it its name. `stalls` is the number of traversals cut off by a bound on their loop."""
        if self._file.closed:
            raise ValueError("no trace is open")
        _check_number("a number of stalls", stalls, 64)
        try:
            missing = self.tiles - (len(self._offsets) - 1)
            if missing:
                raise ValueError(f"{missing} tiles of {self.tiles} are missing")
            trailer = struct.pack("<4Q", self._position, self.tiles, self._steps, stalls)
            index = struct.pack(f"<{len(self._offsets)}Q", *self._offsets)
            self._write(index + _hash_bytes(index, 2))
            self._write(trailer + _hash_bytes(trailer, 3) + b"RBTREND\x01")
            self._file.close()
            os.replace(self._part, self._path)
        except BaseException:
            self.abandon()
            raise

    def abandon(self) -> None:
        """Gives up and removes what was written; nothing after `finish`."""
        self._file.close()
        if os.path.exists(self._part):
            os.remove(self._part)

    def __enter__(self) -> Writer:
        return self

    def __exit__(self, *_: object) -> None:
        self.abandon()

    def _write(self, data: bytes) -> None:
        self._file.write(data)
        self._position += len(data)

    def _chunk(self, data: bytes, seed: int) -> bytes:
        frame = self._compress(data) if self._compress else _stored_frame(data)
        if len(data) > _MOST_CHUNK_BYTES or len(frame) + 16 > _MOST_CHUNK_BYTES:
            raise ValueError("a tile or tree too large for a trace file")
        chunk = struct.pack("<II", len(frame), len(data)) + frame
        return chunk + _hash_bytes(chunk, seed)


class Tile:
    """The rays of a tile. `x`, `y`, `width` and `height` are in pixels; of a list, its first ray, 0, its number of rays, and 1."""

    def __init__(self, writer: Writer, index: int) -> None:
        if not 0 <= index < writer.tiles:
            raise ValueError(f"tile {index} of {writer.tiles}")
        self._writer = writer
        self.index = index
        if writer._image:
            width, height = writer._image
            columns = -(-width // _TILE_EDGE)
            self.x, self.y = index % columns * _TILE_EDGE, index // columns * _TILE_EDGE
            self.width, self.height = min(_TILE_EDGE, width - self.x), min(_TILE_EDGE, height - self.y)
        else:
            self.x, self.y = index * _TILE_RAYS, 0
            self.width, self.height = min(_TILE_RAYS, writer._rays - self.x), 1
        self.steps = 0
        """Steps of all rays so far."""
        rays = self.width * self.height
        # Of each ray of each set: its number of steps and these as bytes; 0 without a hit, else 1 plus the triangle.
        self._recorded: list[list[Optional[tuple[int, bytes]]]] = [[None] * rays for _ in writer._sources]
        self._hits = [[0] * rays for _ in writer._sources]
        self._ray: Optional[tuple[int, int]] = None
        self._bytes = bytearray()
        self._count = 0
        self._previous = [0, 0, 0, 0]
        self._chunk: Optional[bytes] = None

    def begin_ray(self, ray_set: int, ray: int) -> None:
        """Steps that follow belong to this ray: `ray` is row in the tile * width + column.

        Rays come in any order, each at most once. A ray that is left out was not cast. Only these may not be left out: rays of sets that start from
        no hit ("primary"), and those of "shadow" where the ray that they start from hit.
        """
        if self._chunk is not None or self._ray is not None:
            raise ValueError("a ray begins where none can")
        if not 0 <= ray_set < len(self._hits):
            raise ValueError(f"ray set {ray_set} of {len(self._hits)}")
        if not 0 <= ray < self.width * self.height:
            raise ValueError(f"ray {ray} of a tile of {self.width * self.height}")
        if self._recorded[ray_set][ray] is not None:
            raise ValueError(f"ray {ray} of set {ray_set} of tile {self.index} comes twice")
        self._ray = (ray_set, ray)
        self._bytes = bytearray()
        self._count = 0
        self._previous = [0, 0, 0, 0]

    def step(self, op: int, id: int) -> None:
        """Records a step of the ray."""
        if self._ray is None:
            raise ValueError("a step outside of a ray")
        id = operator.index(id)
        if not 0 <= op <= 7:
            raise ValueError(f"a step of kind {op}, below 8 expected")
        if not 0 <= id < self._writer._id_limits[op]:
            raise ValueError(f"a {_OPS[op]} step with id {id}, below {self._writer._id_limits[op]} expected")
        kind = _KIND_OF_OP[op]
        _put_varint(self._bytes, _zigzag(id - self._previous[kind]) << 3 | op)
        self._previous[kind] = id
        self._count += 1

    def end_ray(self, triangle: int) -> None:
        """Ends the ray that hit `triangle`, in file order, or `MISS`."""
        if self._ray is None:
            raise ValueError("a ray ends where none began")
        if not -1 <= triangle < self._writer._triangles:
            raise ValueError(f"a hit of triangle {triangle} of {self._writer._triangles}")
        ray_set, ray = self._ray
        self._recorded[ray_set][ray] = (self._count, bytes(self._bytes))
        self._hits[ray_set][ray] = operator.index(triangle) + 1
        self.steps += self._count
        self._ray = None

    def end(self) -> bytes:
        """Encodes the tile, unless that was done: the work worth doing in parallel. Returns its bytes in the file."""
        if self._chunk is None:
            if self._ray is not None:
                raise ValueError("a tile ends where it cannot")
            data = bytearray()
            for ray_set in range(len(self._hits)):
                self._put_set(ray_set, data)
            self._chunk = self._writer._chunk(bytes(data), 1 << 32 | self.index)
        return self._chunk

    def _put_set(self, ray_set: int, data: bytearray) -> None:
        recorded, hits = self._recorded[ray_set], self._hits[ray_set]
        for ray in (ray for ray, steps in enumerate(recorded) if steps is None):
            self._leave_out(ray_set, ray)
        counts = [steps[0] if steps else 0 for steps in recorded]
        if sum(counts) > _MOST_TILE_STEPS:
            raise ValueError("more than 2^26 steps in a ray set of a tile")
        for count in counts:
            _put_varint(data, count)
        previous = 0
        for hit in hits:
            _put_varint(data, _zigzag(hit - previous))
            previous = hit
        data += b"".join(steps[1] for steps in recorded if steps)

    def _leave_out(self, ray_set: int, ray: int) -> None:
        """The hit of a ray that was not recorded: 1 plus the number of triangles where the ray that it would start from hit."""
        triangles = self._writer._triangles
        source = self._writer._sources[ray_set]
        source_hit = source is not None and 0 < self._hits[source][ray] <= triangles
        if source is None or (source_hit and self._writer._plain[ray_set]):
            raise ValueError(f"ray {ray} of set {ray_set} of tile {self.index} is missing")
        self._hits[ray_set][ray] = triangles + 1 if source_hit else 0


def _check_name(key: str, name: str, names: Sequence[str]) -> None:
    if name not in names:
        raise ValueError(f'{key} "{name}" is not known')


def _check_number(what: str, number: int, bits: int) -> None:
    if not 0 <= operator.index(number) < 1 << bits:
        raise ValueError(f"{what} of {number}, 0 to 2^{bits} - 1 expected")


def _check_text(key: str, text: str) -> None:
    try:
        str.encode(text)
    except UnicodeEncodeError:
        raise ValueError(f"{key} is not UTF-8") from None


def _structure(header: Header, structure: Union[Tree, TwoLevel]) -> tuple[bytearray, int, int, int, int]:
    """Encoded, with its numbers of nodes, references, instances and triangles of the scene."""
    if isinstance(structure, TwoLevel) != (header.accel == "two-level"):
        raise ValueError(f"{header.accel} with a {type(structure).__name__}")
    data = bytearray()
    is_wide = header.node_format is not None
    has_pairs = header.node_format == "compressed-8-pairs"
    if isinstance(structure, Tree):
        _check_tree(structure, is_wide, header.accel == "grid")
        _put_tree(data, structure, has_pairs)
        return data, len(structure.nodes), len(structure.references), 0, int(structure.triangles)
    # With a fetch in pairs the TLAS is binary.
    _check_tree(structure.tlas, is_wide and header.node_fetch == "single", False)
    nodes, references = len(structure.tlas.nodes), 0
    for number, blas in enumerate(structure.blases):
        _check_tree(blas, is_wide, False)
        if len(blas.references) != blas.triangles:
            raise ValueError(f"BLAS {number} has {len(blas.references)} references to {blas.triangles} triangles, one to each expected")
        nodes += nodes % 2 + len(blas.nodes)
        references += len(blas.references)
    if max(nodes, references) > _MOST_IDS:
        raise ValueError(f"more than {_MOST_IDS} nodes or references in all trees")
    instances = structure.tlas.triangles
    if len(structure.meshes) != instances:
        raise ValueError(f"meshes of {len(structure.meshes)} instances, {instances} expected")
    for mesh in structure.meshes:
        if not 0 <= mesh < len(structure.blases):
            raise ValueError(f"an instance of mesh {mesh} of {len(structure.blases)}")
    triangles = sum(structure.blases[mesh].triangles for mesh in structure.meshes)
    if triangles > _MOST_IDS:
        raise ValueError(f"more than {_MOST_IDS} triangles in all instances")
    _put_tree(data, structure.tlas, False)
    _put_differences(data, structure.meshes)
    _put_varint(data, len(structure.blases))
    for blas in structure.blases:
        _put_tree(data, blas, has_pairs)
    return data, nodes, references, instances, triangles


def _check_tree(tree: Tree, is_wide: bool, is_grid: bool) -> None:
    nodes, references = len(tree.nodes), len(tree.references)
    if not 1 <= nodes <= _MOST_IDS or references > _MOST_IDS or not 0 <= tree.triangles <= _MOST_IDS:
        raise ValueError(
            f"a tree of {nodes} nodes, {references} references and {tree.triangles} triangles, at least a node and at most {_MOST_IDS} of each expected"
        )
    kinds = ("wide",) if is_wide else ("leaf",) if is_grid else ("inner", "leaf")
    for index, node in enumerate(tree.nodes):
        if node.kind not in kinds or (node.kind == "inner" and node.count != 2):
            raise ValueError(f"node {index} is of a kind that this structure does not have")
        end = node.first + node.count
        if node.kind == "leaf":
            fits = end <= references
        else:
            fits = node.first > index and end <= nodes if node.count else node.first < 1 << 32
        if not fits or min(node.first, node.count) < 0:
            raise ValueError(f"node {index} leads to {node.count} from {node.first}: children lie behind it, and nothing leads outside")
        if node.kind == "wide" and not 0 <= node.leaves <= 8 - node.count:
            raise ValueError(f"node {index} has more than 8 children")
    for place, reference in enumerate(tree.references):
        if not 0 <= reference < tree.triangles:
            raise ValueError(f"reference {place} is to {reference} of {tree.triangles}")
    least = 1
    for second in tree.seconds:
        if not least <= second < references:
            raise ValueError(f"place {second} cannot be second to the one before")
        least = second + 2


def _put_tree(data: bytearray, tree: Tree, has_pairs: bool) -> None:
    for number in (len(tree.nodes), len(tree.references), tree.triangles):
        _put_varint(data, number)
    link = place = 0
    for node in tree.nodes:
        is_leaf = node.kind == "leaf"
        _put_varint(data, _zigzag(node.first - (place if is_leaf else link)) << 1 | is_leaf)
        if node.kind != "inner":
            _put_varint(data, node.count)
        if node.kind == "wide":
            _put_varint(data, node.leaves)
        if is_leaf:
            place = node.first + node.count
        else:
            link = node.first + (node.count if node.kind == "wide" else 0)
    _put_differences(data, tree.references)
    if has_pairs:
        _put_varint(data, len(tree.seconds))
        previous = 0
        for second in map(operator.index, tree.seconds):
            _put_varint(data, second - previous)
            previous = second


def _put_differences(data: bytearray, numbers: Sequence[int]) -> None:
    previous = 0
    for number in map(operator.index, numbers):
        _put_varint(data, _zigzag(number - previous))
        previous = number


def _put_varint(data: bytearray, value: int) -> None:
    while value >= 0x80:
        data.append(value & 0x7F | 0x80)
        value >>= 7
    data.append(value)


def _zigzag(value: int) -> int:
    """Small whatever the sign: 2s from 0 on, -2s - 1 below."""
    return value << 1 if value >= 0 else (-value << 1) - 1


def _stored_frame(data: bytes) -> bytes:
    """A zstd frame: a header with a window of 128 KiB and the length, and blocks of up to 128 KiB as they are."""
    most = 1 << 17
    parts = [b"\x28\xb5\x2f\xfd\x80\x38", struct.pack("<I", len(data))]
    for start in range(0, max(len(data), 1), most):
        block = data[start : start + most]
        is_last = start + most >= len(data)
        parts += [(len(block) << 3 | is_last).to_bytes(3, "little"), block]
    return b"".join(parts)


# XXH3-64 with a seed, as in xxHash 0.8.

_SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221"
    "b8084674f743248ee03590e6813a264c3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364eac5ac8334d3ebc3c581a0fffa1363eb"
    "170ddd51b7f0da49d316552629d4689e2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e"
)
_M64 = (1 << 64) - 1
_M32 = (1 << 32) - 1
_PRIME = 0x9E3779B185EBCA87
_LANES = (0xC2B2AE3D, _PRIME, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63, 0x85EBCA77, 0x27D4EB2F165667C5, 0x9E3779B1)


def xxh3_64(data: bytes, seed: int) -> int:
    """XXH3-64 of at least 9 bytes, which everything in a trace file has."""
    count = len(data)
    if count > 240:
        return _hash_long(data, seed)
    hash = count * _PRIME
    if count > 128:
        hash = _avalanche(hash + sum(_mix16(data, 16 * i, 16 * i, seed) for i in range(8)))
        hash += sum(_mix16(data, 16 * i, 16 * (i - 8) + 3, seed) for i in range(8, count // 16))
        return _avalanche(hash + _mix16(data, count - 16, 119, seed))
    if count > 16:
        for i in range((count - 1) // 32 + 1):
            hash += _mix16(data, 16 * i, 32 * i, seed) + _mix16(data, count - 16 * (i + 1), 32 * i + 16, seed)
        return _avalanche(hash)
    if count < 9:
        raise ValueError(f"{count} bytes to hash, at least 9 expected")
    low = _word(data, 0) ^ ((_word(_SECRET, 24) ^ _word(_SECRET, 32)) + seed & _M64)
    high = _word(data, count - 8) ^ ((_word(_SECRET, 40) ^ _word(_SECRET, 48)) - seed & _M64)
    swapped = int.from_bytes(low.to_bytes(8, "big"), "little")
    return _avalanche(count + swapped + high + _fold(low, high))


def _hash_long(data: bytes, seed: int) -> int:
    words = struct.unpack("<24Q", _SECRET)
    secret = struct.pack("<24Q", *((word - seed if i % 2 else word + seed) & _M64 for i, word in enumerate(words)))
    keys = [struct.unpack_from("<8Q", secret, 8 * i) for i in range(17)]
    lanes = list(_LANES)
    stripes = (len(data) - 1) // 64
    for stripe in range(stripes):
        _accumulate(lanes, struct.unpack_from("<8Q", data, 64 * stripe), keys[stripe % 16])
        if stripe % 16 == 15:
            lanes = [((lane & _M64) ^ (lane & _M64) >> 47 ^ key) * 0x9E3779B1 & _M64 for lane, key in zip(lanes, keys[16])]
    _accumulate(lanes, struct.unpack_from("<8Q", data, len(data) - 64), struct.unpack_from("<8Q", secret, 121))
    hash = len(data) * _PRIME
    for i in range(4):
        low, high = (lanes[2 * i + j] & _M64 ^ _word(secret, 11 + 16 * i + 8 * j) for j in range(2))
        hash += _fold(low, high)
    return _avalanche(hash)


def _accumulate(lanes: list[int], words: tuple[int, ...], keys: tuple[int, ...]) -> None:
    """Sums of lanes are cut to 64 bits only where that matters."""
    for lane in range(8):
        word = words[lane]
        key = word ^ keys[lane]
        lanes[lane ^ 1] += word
        lanes[lane] += (key & _M32) * (key >> 32)


def _word(data: bytes, at: int) -> int:
    return int.from_bytes(data[at : at + 8], "little")


def _fold(a: int, b: int) -> int:
    """Both halves of the product of 128 bits, xored."""
    product = a * b
    return product & _M64 ^ product >> 64


def _avalanche(hash: int) -> int:
    hash &= _M64
    hash = (hash ^ hash >> 37) * 0x165667919E3779F9 & _M64
    return hash ^ hash >> 32


def _mix16(data: bytes, at: int, secret: int, seed: int) -> int:
    low = _word(data, at) ^ (_word(_SECRET, secret) + seed & _M64)
    high = _word(data, at + 8) ^ (_word(_SECRET, secret + 8) - seed & _M64)
    return _fold(low, high)


def _hash_bytes(data: bytes, seed: int) -> bytes:
    return struct.pack("<Q", xxh3_64(data, seed))
