"""Prints the checksum of the first so many bytes of a pattern, for each count and seed on standard input."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "contrib"))
from rbt_writer import xxh3_64  # noqa: E402

data = bytes(i * i % 251 for i in range(1 << 14))
for line in sys.stdin:
    count, seed = map(int, line.split())
    print(f"{xxh3_64(data[:count], seed):016x}")
