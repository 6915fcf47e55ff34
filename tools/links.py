"""Checks and mends the links of the book as HTML: `python links.py target/book`.

mdBook takes every relative link to be one within the book: ../README.md becomes ../README.html, beside the folder of the book. Such links are led to the
files of the clone. The README.md of a folder becomes index.html, which links to it do not follow. Ends with 1 and names each link that leads to no file or to
no heading.
"""

import os
import re
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parents[1] / "docs"
LINK = re.compile(r'\b(href|src)="([^"]*)"')


def outside(page: Path, target: str, book: Path) -> Path | None:
    """Returns the file of the clone that a link of `page` means, if there is one."""
    source = (DOCS / page.relative_to(book)).parent / target
    for file in (source, source.with_suffix(".md")):
        if file.exists():
            return file.resolve()
    return None


def main() -> None:
    book = Path(sys.argv[1]).resolve()
    # The page of missing pages has links from the root of a server.
    pages = {page: page.read_text(encoding="utf-8") for page in book.rglob("*.html") if page.name != "404.html"}
    headings = {page: set(re.findall(r'\bid="([^"]*)"', text)) for page, text in pages.items()}
    wrong = []
    for page, text in pages.items():

        def lead(match: re.Match[str], page: Path = page) -> str:
            attribute, link = match.groups()
            target, _, heading = link.partition("#")
            if re.match(r"[a-z]+:", link):
                return match[0]
            file = (page.parent / target).resolve() if target else page
            if file.is_relative_to(book):
                index = (file if file.is_dir() else file.parent) / "index.html"
                if index.exists() and (file.is_dir() or file.name == "README.html"):
                    return f'{attribute}="{os.path.relpath(index, page.parent)}"'
                if not file.exists() or (heading and heading not in headings.get(file, {heading})):
                    wrong.append(f"{page.relative_to(book)}: {link}")
                return match[0]
            file = outside(page, target, book) or file
            if not file.exists():
                wrong.append(f"{page.relative_to(book)}: {link}")
            return f'{attribute}="{os.path.relpath(file, page.parent)}"'

        led = LINK.sub(lead, text)
        if led != text:
            page.write_text(led, encoding="utf-8")
    if wrong:
        sys.exit("links: these lead nowhere:\n" + "\n".join(wrong))


main()
