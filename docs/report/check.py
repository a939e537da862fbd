#!/usr/bin/env python3
"""Is the report whole? Its text is the template filled with docs/data, every picture it shows exists, has an alternative text and is
small, and no picture lies about unused. Needs nothing but Python. Prints every offence; exit code 1 when there is one."""
import re
import sys
from pathlib import Path

import template

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS / "site"))
import plugins  # noqa: E402  pylint: disable=wrong-import-position
LARGEST, LARGEST_SUM = 700_000, 9_000_000  # bytes: one picture, and all of docs/images; the repository may hold 12 MiB
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
PICTURE = re.compile(r"!\[([^\]]*)\]\(([^)\s]+)\)")


def check_text(report, offences):
    try:
        wanted = template.fill((DOCS / "report" / "report.md.in").read_text(encoding="utf-8"), template.load(DOCS / "data"))
    except KeyError as error:
        offences.append(error.args[0])
        return
    if "{{" in wanted:
        offences.append("report.md.in: a placeholder was not understood: " + wanted[wanted.index("{{"):][:60])
    if report.read_text(encoding="utf-8") != wanted:
        offences.append("docs/report.md is not docs/report/report.md.in filled with docs/data; run docs/report/figures.py --text")


def check_pictures(offences):
    objects = (DOCS / "scene_format.md").read_text(encoding="utf-8")
    shown = {DOCS / "images" / name for name in plugins.pictures(objects)}  # of the site
    for page in PAGES:
        for alternative, link in PICTURE.findall(page.read_text(encoding="utf-8")):
            picture = (page.parent / link).resolve()
            shown.add(picture)
            if not picture.exists():
                offences.append(f"{page.relative_to(ROOT)}: {link} does not exist")
            if len(alternative) < 12:
                offences.append(f"{page.relative_to(ROOT)}: {link} has no alternative text that says what there is to see")
    pictures = sorted(path.resolve() for path in (DOCS / "images").iterdir())
    for path in pictures:
        if path not in shown:
            offences.append(f"{path.relative_to(ROOT)} is shown on no page")
        if path.stat().st_size > LARGEST:
            offences.append(f"{path.relative_to(ROOT)} has {path.stat().st_size} bytes, more than {LARGEST}")
    total = sum(path.stat().st_size for path in pictures)
    if total > LARGEST_SUM:
        offences.append(f"docs/images has {total} bytes, more than {LARGEST_SUM}")


def check_gallery(offences):
    """The commands that the gallery prints are those its pictures were made with."""
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    for picture in template.load(DOCS / "data")["gallery"]["rows"]:
        if picture["command"] not in text.replace(" \\\n  ", " "):  # long commands go on in the next line
            offences.append(f"docs/gallery.md does not print the command of {picture['picture']}: {picture['command']}")


def main():
    offences = []
    check_text(DOCS / "report.md", offences)
    check_pictures(offences)
    check_gallery(offences)
    print("\n".join(offences) or "the report is whole")
    return 1 if offences else 0


if __name__ == "__main__":
    sys.exit(main())
