#!/usr/bin/env python3
"""Compares the documented items of the library with docs/PUBLIC_ITEMS.txt.

    python3 tools/front.py           fails if they differ
    python3 tools/front.py --write   writes the file

An item is a type, a function, a constant, a module, or a method; fields and variants are listed, too, and do not count. What is hidden from the
documentation is no part of it. The list comes from rustdoc's JSON, an unstable option, which stable rustdoc takes where RUSTC_BOOTSTRAP is set: a small script
sets it for rustdoc alone, because for the compiler it would mean another compiler, and everything would be built anew.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LIST = ROOT / "docs/PUBLIC_ITEMS.txt"
MOST_ITEMS = 150
# Crates whose types no public signature may name: their versions would be promised, too.
INNER_CRATES = {"ash", "gpu_allocator", "nalgebra", "glam", "egui", "winit", "num_complex", "half", "image"}
NOT_COUNTED = {"field", "variant"}


def documentation():
    """Returns rustdoc's JSON of the library."""
    with tempfile.TemporaryDirectory() as folder:
        rustdoc = Path(folder) / "rustdoc"
        rustdoc.write_text('#!/bin/sh\nRUSTC_BOOTSTRAP=1 exec rustdoc "$@"\n')
        rustdoc.chmod(0o755)
        command = ["cargo", "rustdoc", "--locked", "--quiet", "--lib", "--"]
        command += ["-Z", "unstable-options", "--output-format", "json", "--document-hidden-items"]
        subprocess.run(command, check=True, cwd=ROOT, env={**os.environ, "RUSTDOC": str(rustdoc)})
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return json.loads((target / "doc/diffract.json").read_text())


class Front:
    """Documented items: lines of text by kind, and the crates that their signatures name."""

    def __init__(self, documentation):
        # Public items stand in a hidden module, with which rustdoc would leave them out: the hidden ones are left out here.
        is_hidden = lambda item: any("doc(hidden)" in str(attribute).replace(" ", "") for attribute in item["attrs"])
        self.index = {number: item for number, item in documentation["index"].items() if not is_hidden(item)}
        self.paths = documentation["paths"]
        self.crates = documentation["external_crates"]
        self.items = []
        self.named = set()
        self.seen = set()
        self.visit(documentation["root"], "")

    def add(self, kind, name, item):
        self.items.append((kind, name))
        self.look(item["inner"], name)

    def look(self, part, name):
        """Notes the inner crates whose types `part` of a signature names."""
        if isinstance(part, dict):
            path = part.get("resolved_path")
            if isinstance(path, dict):
                known = self.paths.get(str(path["id"]), {})
                crate = self.crates.get(str(known.get("crate_id")), {}).get("name")
                if crate in INNER_CRATES:
                    self.named.add(f"{name} names {crate}::{known['path'][-1]}")
            for key, value in part.items():
                if key not in ("impls", "items"):
                    self.look(value, name)
        elif isinstance(part, list):
            for value in part:
                self.look(value, name)

    def visit(self, number, path):
        item = self.index.get(str(number))
        if item is None:
            return
        (kind, inner), name = next(iter(item["inner"].items())), item["name"]
        if kind == "use":
            target = self.index.get(str(inner["id"]))
            if target and not inner.get("is_glob"):
                self.visit(inner["id"], path)
            return
        if number in self.seen:
            return
        self.seen.add(number)
        full = f"{path}::{name}" if path else name
        if kind == "module":
            if path:
                self.add(kind, full, {"inner": {}})
            for below in inner["items"]:
                self.visit(below, full)
            return
        self.add(kind, full, item)
        if kind in ("struct", "enum", "trait"):
            self.members(kind, inner, full)

    def members(self, kind, inner, full):
        if kind == "struct" and isinstance(inner["kind"], dict):
            for field in inner["kind"].get("plain", {}).get("fields", []):
                self.member("field", field, full)
        for variant in inner.get("variants", []):
            self.member("variant", variant, full)
        for below in inner.get("items", []):
            self.member("method", below, full)
        for number in inner.get("impls", []):
            block = self.index.get(str(number), {}).get("inner", {}).get("impl")
            if block and block["trait"] is None:
                for below in block["items"]:
                    self.member("method", below, full)

    def member(self, kind, number, full):
        item = self.index.get(str(number))
        if item:
            self.add(kind, f"{full}::{item['name']}", item)

    def text(self):
        return "".join(sorted(f"{name} ({kind})\n" for kind, name in self.items))

    def count(self):
        return sum(kind not in NOT_COUNTED for kind, _ in self.items)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="write the file instead of comparing with it")
    arguments = parser.parse_args()
    front = Front(documentation())
    kinds = ", ".join(f"{count} of kind {kind}" for kind, count in sorted(Counter(kind for kind, _ in front.items).items()))
    print(f"{front.count()} public items: {kinds}")
    if front.named:
        sys.exit("public signatures name types of other crates:\n" + "\n".join(sorted(front.named)))
    if front.count() > MOST_ITEMS:
        sys.exit(f"more than {MOST_ITEMS} public items; hide some, or move them behind `internals`")
    if arguments.write:
        LIST.write_text(front.text())
    elif not LIST.is_file() or LIST.read_text() != front.text():
        known = set(LIST.read_text().splitlines()) if LIST.is_file() else set()
        found = set(front.text().splitlines())
        lines = [f"- {line}" for line in sorted(known - found)] + [f"+ {line}" for line in sorted(found - known)]
        sys.exit("the public items have changed; if that is meant: python3 tools/front.py --write\n" + "\n".join(lines))


if __name__ == "__main__":
    main()
