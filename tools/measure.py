#!/usr/bin/env python3
"""Writes the section "Speed against accuracy" of docs/BENCHMARKS.md from a sweep, or compares a sweep with it.

    diffract trade --quick -o FOLDER
    tools/measure.py FOLDER            writes the section
    tools/measure.py FOLDER --check    fails if a setting became slower beside the others, or less exact

Times of two runs are never compared: --check compares each time over the geometric mean of all times of its run. Where a run was busy,
its ratios mean little, so both refuse a sweep that calls its times unreliable, unless --noisy is given.
"""

import csv
import datetime
import math
import re
import sys
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs/BENCHMARKS.md"
BEGIN, END = "## Speed against accuracy\n", "\n## "
# The setting that others are told in multiples of.
TABLE = "--method table --tolerance 2e-2"
# Times of a quiet machine repeat within 12 %, errors to the last digit.
SLOWER = 1.25
LESS_EXACT = 1.05


def sweep(folder: Path) -> list[dict[str, str]]:
    with open(folder / "trade.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    return sorted(rows, key=lambda row: float(row["frame_ms"]))


def processor() -> str:
    text = Path("/proc/cpuinfo").read_text()
    names = re.findall(r"^model name\s*: (.*)", text, re.MULTILINE)
    return f"{len(names)} cores of {names[0]}" if names else "an unknown processor"


def ratios(text: str, folder: Path) -> str:
    times = {row["flags"]: float(row["frame_ms"]) for row in sweep(folder)}
    table = times[TABLE]
    others = {name.split(",")[0].split(":")[0]: time for name, time in times.items() if "for comparison" in name}
    told = [f"{name if name.startswith('the ') else 'the ' + name} {time / table:.2f} times" for name, time in others.items()]
    return f"{text}Compared with the frame of `{TABLE}`, others take: " + ", ".join(told) + " as long.\n"


def section(folder: Path) -> str:
    described, _, rest = (folder / "trade.md").read_text().split("\n", 1)[1].strip().partition("\n\n")
    table = rest.split("\n\n")[0]
    day = datetime.date.today().isoformat()
    head = f"{BEGIN}\n```console\nmake measure\n```\n\n{day}, {processor()}: {described}\n\n"
    tail = "\n\nThe tables are of the mean over coherence areas, the others of one window: each is judged by the reference of its question.\n"
    return ratios(head, folder) + "\n" + table + tail


def written(page: str) -> dict[str, tuple[float, float]]:
    """Time [ms] and error of each setting in the table of the page."""
    part = page[page.index(BEGIN) :].split(END)[0]
    rows = re.findall(r"^\| `(.*?)` \| ([\d.]+) ms \| [\d.]+ \| ([\d.e-]+) ", part, re.MULTILINE)
    return {flags: (float(time), float(error)) for flags, time, error in rows}


def check(folder: Path) -> None:
    before = written(PAGE.read_text())
    now = {row["flags"]: (float(row["frame_ms"]), float(row["relative_l2"])) for row in sweep(folder)}
    common = sorted(set(before) & set(now))
    if len(common) < 3:
        sys.exit("measure: the page and the sweep share fewer than three settings; sweep with --quick")

    def mean(times: dict[str, tuple[float, float]]) -> float:
        return math.exp(sum(math.log(times[name][0]) for name in common) / len(common))

    worse = []
    for name in common:
        slower = (now[name][0] / mean(now)) / (before[name][0] / mean(before))
        # The page rounds errors to two digits.
        less_exact = now[name][1] / before[name][1]
        print(f"{slower:5.2f} {less_exact:5.2f}  {name}")
        if slower > SLOWER or less_exact > LESS_EXACT:
            worse.append(name)
    if worse:
        sys.exit("measure: slower beside the others, or less exact: " + "; ".join(worse))


def main(folder: str, *options: str) -> None:
    if "unreliable" in Path(folder, "trade.md").read_text() and "--noisy" not in options:
        sys.exit("measure: the machine was busy and times of this sweep are unreliable; sweep again on a quiet machine, or add --noisy")
    if "--check" in options:
        return check(Path(folder))
    page = PAGE.read_text()
    begin = page.index(BEGIN)
    end = page.index(END, begin + len(BEGIN))
    PAGE.write_text(page[:begin] + section(Path(folder)) + page[end:])


if len(sys.argv) < 2:
    sys.exit(__doc__)
main(*sys.argv[1:])
