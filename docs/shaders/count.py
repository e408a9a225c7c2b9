#!/usr/bin/env python3
"""Counts the instructions of the shaders beside this file; README.md says by which rules.

count.py                    prints the table of README.md from disassembly/
count.py show COMPILER NAME compiles kernel.comp for a traversal, frame.frag ("NAME.frag"), a piece or a pass of reflections, and prints its disassembly
count.py check COMPILER     compiles everything again and compares with disassembly/
"""

import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent
GPU = "540"
# Instructions that only make an address, per load or store: [shared] address of costs.toml.
ADDRESS = 3
# Traversals, and the loads and stores for whose addresses the model pays by step.
BVH = {"node": 4, "primitive": 3}
KD = {"node": 1, "primitive": 4}
STACK = {"push": 1, "pop": 1}
TRAVERSALS = {
    "bvh-stack": BVH | STACK,
    "bvh-parent-link": {"node": 3, "up": 3, "primitive": 3},
    "bvh-restart-trail": BVH,
    "bvh-restart-trail-short": BVH,
    "kd-stack": KD | STACK,
    "kd-restart": KD,
    "kd-push-down": KD,
    "kd-push-down-short": KD,
    "kd-backtrack": KD | {"node": 3, "up": 3},
    "grid-dda": KD,
    "wide-full-4": BVH | STACK | {"node": 8},
    "wide-full-8": BVH | STACK | {"node": 16},
    "wide-compressed-8": BVH | STACK | {"node": 5},
    "wide-adreno-8": BVH | STACK | {"node": 4},
    # Tagged apart, as what stands in for the instruction makes them.
    "ray-intersection": {},
}
STEPS = ["setup", "start", "loop", "node", "leaf", "up", "restart", "push", "pop", "primitive"]
# Passes of reflections. Their instructions are not tagged where only their registers are counted.
PASSES = sorted(path.stem for path in (HERE / "reflections").glob("*.comp"))
# Instructions of a pass that belong to no step: made-up inputs and outputs, addresses, barriers.
APART = {"io", "address", "barrier"}
FLOW = {"br", "jump", "end", "bar", "fence"}
EFU = {"rcp", "rsq"}
MEMORY = {"ldgb", "stgb", "ldp", "stp", "ldl", "stl", "ldlv", "atomic"}


def kind(instruction):
    """ALU, EFU, memory, flow or nop, and how often an instruction repeats."""
    flags = re.findall(r"\((\w+)\)", instruction.split(" ")[0])
    name = re.sub(r"^(\(\w+\))*", "", instruction).split(" ")[0].split(".")[0]
    repeats = 1 + sum(int(flag[3:]) for flag in flags if flag.startswith("rpt"))
    if name in FLOW:
        return "flow", repeats
    if name in EFU:
        return "EFU", repeats
    if name in MEMORY:
        return "memory", repeats
    return ("nop" if name == "nop" else "ALU"), repeats


def read(name):
    """Instructions of a disassembly, each with the step that it belongs to."""
    lines = (HERE / "disassembly" / f"{name}.txt").read_text().splitlines()
    rows = [line.split("| ", 1) for line in lines if not line.startswith(";")]
    return lines[0], [(tag.strip(), code) for tag, code in rows]


def count(rows):
    """Counters by step."""
    steps = {}
    for tag, code in rows:
        if re.fullmatch(r"l\d+:", code):
            continue
        for step in tag.split("+"):
            what, repeats = kind(code)
            counter = steps.setdefault(step, Counter())
            counter[what] += repeats
            counter["(ss)"] += "(ss)" in code
            counter["(sy)"] += "(sy)" in code
    return steps


def row(shader, step, counter, loads):
    cost = max(counter["ALU"] - ADDRESS * loads, 0)
    columns = [shader, step, counter["ALU"], counter["EFU"], counter["memory"], counter["flow"], counter["nop"]]
    columns += [counter["(ss)"], counter["(sy)"], cost]
    print("| " + " | ".join(map(str, columns)) + " |")


def table():
    print("| shader | step | ALU | EFU | memory | flow | nops | (ss) | (sy) | ALU without addresses |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, loads in TRAVERSALS.items():
        steps = count(read(name)[1])
        for step in STEPS:
            for tag in (step, step + "'"):
                if tag in steps:
                    row(name, tag, steps[tag], loads.get(step, 0))
    for piece in sorted((HERE / "pieces").iterdir()):
        counter = count(read(piece.stem)[1])[piece.stem]
        loads = sum("ldgb" in code for _, code in read(piece.stem)[1])
        row("pieces", piece.stem, counter, loads)
    for name in PASSES:
        for step, counter in count(read(name)[1]).items():
            if step not in APART:
                row(name, step, counter, 0)
    print("\n| traversal or pass | registers |\n|---|---|")
    for name in [*TRAVERSALS, *PASSES]:
        found = re.search(r"needs (\d+) registers", read(name)[0])
        if found:
            print(f"| {name} | {found[1]} |")


def expand(path, values):
    """Source lines with includes in place: the compiler has none."""
    for line in path.read_text().splitlines():
        include = re.match(r'#include (?:"(.*)"|(\w+))', line)
        if include:
            yield from expand(HERE / (include[1] or values[include[2]]), values)
        else:
            yield line


def compiled(compiler, name):
    """The compiler's output for a kernel, a frame ("NAME.frag"), a piece or a pass."""
    pieces = {piece.stem: piece for piece in (HERE / "pieces").iterdir()}
    traversal = name.removesuffix(".frag")
    path = pieces.get(name) or HERE / ("frame.frag" if name.endswith(".frag") else "kernel.comp")
    if name in PASSES:
        path = HERE / "reflections" / f"{name}.comp"
    values = {"TRAVERSAL": traversal.removesuffix("-short") + ".glsl"}
    entries = 4 if traversal.endswith("-short") else 0
    source = ["#version 310 es", f"#define SHORT_STACK {entries}", *expand(path, values)]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / path.name
        file.write_text("\n".join(source) + "\n")
        return subprocess.run(
            [compiler, "--gpu", GPU, str(file)], check=True, capture_output=True, text=True
        ).stdout


def disassembly(output):
    lines = output[output.index("NIR compiler") :].splitlines()[1:]
    code = [line for line in lines if not line.startswith((";", "@"))]
    end = next(place for place, line in enumerate(code) if re.fullmatch(r"(\(\w+\))*end", line))
    return code[: end + 1]


def registers(output):
    return re.search(r"(\d+) full", output)[1]


def instructions(output):
    """All but nops."""
    found = count([("all", code) for code in disassembly(output)])["all"]
    return sum(found[what] for what in ("ALU", "EFU", "memory", "flow"))


def check(compiler):
    differing = []
    for name in [*TRAVERSALS, *(piece.stem for piece in (HERE / "pieces").iterdir())]:
        header, rows = read(name)
        if disassembly(compiled(compiler, name)) != [code for _, code in rows]:
            differing.append(name)
        needed = re.search(r"needs (\d+) registers", header)
        if needed and registers(compiled(compiler, name + ".frag")) != needed[1]:
            differing.append(name + ".frag")
    for name in PASSES:
        header, rows = read(name)
        output = compiled(compiler, name)
        same = not rows or disassembly(output) == [code for _, code in rows]
        if not same or f"needs {registers(output)} registers" not in header:
            differing.append(name)
        size = re.search(r"has (\d+) instructions", header)
        if size and instructions(output) != int(size[1]):
            differing.append(name + " (size)")
    print("differing: " + ", ".join(differing) if differing else "all the same")
    return bool(differing)


if __name__ == "__main__":
    if len(sys.argv) == 1:
        table()
    elif sys.argv[1:2] == ["check"] and len(sys.argv) == 3:
        sys.exit(check(sys.argv[2]))
    elif sys.argv[1:2] == ["show"] and len(sys.argv) == 4:
        output = compiled(sys.argv[2], sys.argv[3])
        print("\n".join(disassembly(output)), f"\n; {registers(output)} registers")
    else:
        sys.exit(__doc__)
