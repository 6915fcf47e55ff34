#!/usr/bin/env python3
"""Prints the licences of what the program links, with their texts.

    tools/licences.py [TARGET [MANIFEST]]      e.g. x86_64-unknown-linux-gnu, which is the default, and python/Cargo.toml

The packages are those of Cargo.lock that `cargo metadata` has for the target, without those that only build or test the program.
Texts come from the packages themselves. A package that has none is given those of a package of its repository or the notice at the
head of its sources, or Apache-2.0 where it may be used under that; else this ends with an error.
"""

import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
# Files that hold a licence, in the folder of a package or one below it.
LICENCE_FILE = re.compile(r"(licen[cs]e|copying|notice|unlicense|copyright|[^/]*[-_]licen[cs]e\b|OFL|UFL|[^/]*-Regular)[^/]*$", re.I)
TEXT_ENDINGS = {"", ".txt", ".md", ".apache2", ".apache-2.0", ".mit", ".zlib", ".boost", ".bsd"}
# Begin of a notice at the head of a C or C++ source.
HEAD = re.compile(r"/\*.*?(?:Redistribution and use|SPDX-License-Identifier).*?\*/", re.S)


def linked(metadata):
    """Returns the packages that the program links, by name and version."""
    packages = {package["id"]: package for package in metadata["packages"]}
    nodes = {node["id"]: node for node in metadata["resolve"]["nodes"]}
    root = metadata["resolve"]["root"]
    found, left = set(), [root]
    while left:
        package = left.pop()
        if package in found:
            continue
        found.add(package)
        left += [d["pkg"] for d in nodes[package]["deps"] if any(kind["kind"] is None for kind in d["dep_kinds"])]
    others = (packages[package] for package in found if packages[package]["source"])  # those of this repository have none
    return sorted(others, key=lambda package: (package["name"], package["version"]))


def folder(package):
    return pathlib.Path(package["manifest_path"]).parent


def texts(package):
    """Returns the texts of the licence files of a package by their names."""
    place = folder(package)
    files = [f for f in sorted(place.glob("*")) + sorted(place.glob("*/*")) if f.is_file()]
    files = [f for f in files if LICENCE_FILE.match(f.name) and f.suffix.lower() in TEXT_ENDINGS]
    return {str(f.relative_to(place)): f.read_text(errors="replace").strip() for f in files}


def heads(package):
    """Returns the notices at the heads of the C and C++ sources of a package, each once."""
    found = {}
    for source in sorted(folder(package).rglob("*.h")) + sorted(folder(package).rglob("*.c*")):
        head = HEAD.search(source.read_text(errors="replace")[:8000])
        if head and head[0] not in found.values():
            found[f"the head of {source.relative_to(folder(package))}"] = head[0]
    return found


def all_texts(packages):
    """Returns the texts of each package. Ends with an error where there are none."""
    own = {package["id"]: texts(package) for package in packages}
    of_repository = {}
    for package in packages:
        repository = (package["repository"] or "").rstrip("/").removesuffix(".git")
        if repository and own[package["id"]]:
            of_repository.setdefault(repository, own[package["id"]])
    for package in packages:
        if own[package["id"]]:
            continue
        licence = package["license"] or ""
        repository = (package["repository"] or "").rstrip("/").removesuffix(".git")
        found = dict(of_repository.get(repository, {})) | heads(package)
        if "Apache-2.0" in licence:
            found["Apache License 2.0"] = (ROOT / "LICENSE-APACHE").read_text().strip()
        if not found:
            sys.exit(f"licences: {package['name']} {package['version']} ({licence}) comes without a text; look for one in {package['repository']}")
        own[package["id"]] = found
    return own


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else "x86_64-unknown-linux-gnu"
    manifest = sys.argv[2] if len(sys.argv) > 2 else "Cargo.toml"
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--filter-platform", target, "--manifest-path", manifest]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE).stdout)
    packages = linked(metadata)
    by_package = all_texts(packages)
    print(f"diffract links {len(packages)} packages of others on {target}. Each is used under the licence beside it; texts are below.\n")
    for package in packages:
        print(f"{package['name']} {package['version']}: {package['license'] or package['license_file']}, {package['repository'] or 'no repository'}")
    users = {}
    for package in packages:
        for name, text in by_package[package["id"]].items():
            users.setdefault(text, []).append(f"{package['name']} {package['version']} ({name})")
    for text, names in sorted(users.items(), key=lambda item: item[1]):
        print(f"\n{'=' * 100}\n{', '.join(names)}\n{'-' * 100}\n{text}")


main()
