#!/usr/bin/env python3
"""Makes a site of the pages in docs: `./run site`, or build.py --out FOLDER. It needs no network, nor do its pages.

Sphinx gets the pages as they are, but for this: README.md becomes the first page, links to folders become plain words, and the tables of all
objects in docs/scene_format.md become pages of their own, a picture and the formula beside each table (plugins.py). Files that pages link
to come along. In the end every link is followed (links.py).
"""
import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import links
import plugins

ROOT = Path(__file__).resolve().parents[2]
KATEX = Path("/usr/share/javascript/katex")  # Debian's libjs-katex

# The order of pages at the side: (caption, pages of docs). Every page of docs is in here once.
CONTENTS = [
    ("Use", ["command_line", "view", "python", "image_files", "denoising", "tev", "farm"]),
    ("Scenes", ["scene_format", *(f"plugins/{name}" for name in plugins.PAGES), "mitsuba", "gltf"]),
    ("Pictures", ["gallery", "materials", "lights", "cameras", "integrators", "aovs"]),
    ("How it works", ["report", "architecture", "conventions", "bvh", "references"]),
    ("How we know", ["validation", "convergence", "benchmarks", "robustness"]),
]
PROPERTIES = re.compile(r"^(\| property \| type \|.*\n(?:\|.*\n)+)", re.M)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^)\s]+)\)")


def contents():
    out = []
    for caption, pages in CONTENTS:
        out += ["```{toctree}", ":hidden:", f":caption: {caption}", "", *(f"docs/{page}" for page in pages), "```", ""]
    return "\n".join([*out, "```{toctree}", ":hidden:", ":caption: Taking part", "", "CONTRIBUTING", "CHANGELOG", "```", ""])


class Stage:
    def __init__(self, root, out):
        self.root, self.out = root, out
        self.marks = {}  # of pages: the places that <a id="…"> marks, which Sphinx does not know

    def link(self, page, match):
        """A link as the site has it; what it leads to comes along."""
        picture, words, target = match.groups()
        if re.match(r"[a-z]+:|#", target):
            return match.group(0)
        path, _, anchor = target.partition("#")
        place = (page.parent / path).resolve()
        if place.is_dir():
            return words
        if place.suffix != ".md":
            self.copy(place)
        elif anchor in self.marks_of(place):
            return f'<a href="{path.removesuffix(".md")}.html#{anchor}">{words}</a>'
        elif place.name == "README.md" and place.parent == self.root:
            path = path.replace("README.md", "index.md")
        return f"{picture}[{words}]({path}{'#' if anchor else ''}{anchor})"

    def marks_of(self, place):
        if place not in self.marks:
            self.marks[place] = set(re.findall(r'<a id="([^"]+)"></a>', place.read_text(encoding="utf-8"))) if place.exists() else set()
        return self.marks[place]

    def copy(self, place):
        to = self.out / place.relative_to(self.root)
        to.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(place, to)

    def write(self, page, text):
        """One page of the repository, its links followed; code is left alone."""
        parts = re.split(r"(^```.*?^```$|`[^`\n]*`)", text, flags=re.M | re.S)
        # Words of a link may hold code, so links are looked for where code has been put aside.
        codes = parts[1::2]
        bare = "".join(part if i % 2 == 0 else f"\0{i // 2}\0" for i, part in enumerate(parts))
        bare = LINK.sub(lambda match: self.link(self.root / page, match), bare)
        text = re.sub("\0(\\d+)\0", lambda match: codes[int(match.group(1))], bare)
        text = PROPERTIES.sub('<div class="properties">\n\n\\1\n</div>\n', text)
        to = self.out / ("index.md" if page == Path("README.md") else page)
        to.parent.mkdir(parents=True, exist_ok=True)
        to.write_text(text, encoding="utf-8")


def lay_out(out):
    stage = Stage(ROOT, out)
    listed = {Path("docs") / f"{page}.md" for _, pages in CONTENTS for page in pages}
    for page in sorted(Path("docs") / path.name for path in (ROOT / "docs").glob("*.md")):
        if page not in listed:
            sys.exit(f"{page} is not in the contents of docs/site/build.py")
        text = (ROOT / page).read_text(encoding="utf-8")
        if page.name == "scene_format.md":
            text, made = plugins.split(text, ROOT)
            for name, body in made.items():
                stage.write(Path("docs/plugins") / f"{name}.md", body)
        stage.write(page, text)
    for page in ("CONTRIBUTING.md", "CHANGELOG.md"):
        stage.write(Path(page), (ROOT / page).read_text(encoding="utf-8"))
    stage.write(Path("README.md"), (ROOT / "README.md").read_text(encoding="utf-8") + "\n" + contents())
    shutil.copyfile(ROOT / "docs/site/conf.py", out / "conf.py")
    shutil.copytree(ROOT / "docs/site/static", out / "_static")
    (out / "_static/katex").mkdir()
    for name in ("katex.min.css", "katex.min.js"):
        shutil.copyfile(KATEX / name, out / "_static/katex" / name)
    shutil.copytree(KATEX / "fonts", out / "_static/katex/fonts", ignore=shutil.ignore_patterns("*.ttf", "*.woff"))


def need_sphinx():
    """Ends with 77, which tests understand as skipped, where something is missing."""
    missing = [f"the Python module {name}" for name in ("sphinx", "myst_parser", "furo") if importlib.util.find_spec(name) is None]
    missing += [] if (KATEX / "katex.min.js").exists() else [str(KATEX)]
    if missing:
        print(f"the site needs {', '.join(missing)}: ./run site installs it "
              "(Debian: python3-sphinx python3-myst-parser furo libjs-katex)", file=sys.stderr)  # yapf: disable
        sys.exit(77)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="folder of the site; what is in it is replaced")
    out = parser.parse_args().out.resolve()
    need_sphinx()
    stage, trees = out.parent / f"{out.name}-pages", out.parent / f"{out.name}-trees"
    for folder in (stage, trees, out):
        shutil.rmtree(folder, ignore_errors=True)
    stage.mkdir(parents=True)
    lay_out(stage)
    subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", trees, stage, out], check=True,
                   env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})  # yapf: disable
    faults = links.check(out)
    print(*faults, sep="\n", end="\n" if faults else "")
    if not faults:
        print(f"{out / 'index.html'}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
