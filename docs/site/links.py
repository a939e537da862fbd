"""Follows every link of the site: to pages, to places within them, to pictures, scripts and style sheets. Nothing a page shows may come from
elsewhere."""
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

SHOWN = {("img", "src"), ("script", "src"), ("link", "href"), ("source", "src"), ("iframe", "src")}


class Page(HTMLParser):
    """What a page links to, what it shows, and the places in it that can be linked to."""

    def __init__(self, text):
        super().__init__()
        self.targets, self.shown, self.places = set(), set(), set()
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id":
                self.places.add(value)
            elif (tag, name) in SHOWN and value:
                self.shown.add(value)
            elif (tag, name) == ("a", "href") and value:
                self.targets.add(value)


def check(site):
    """A line for each fault."""
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in sorted(site.rglob("*.html"))}
    faults = []
    for path, page in pages.items():
        name = path.relative_to(site)
        for target in sorted(page.shown | page.targets):
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                if target in page.shown and parts.scheme != "data":
                    faults.append(f"{name}: {target} is shown from elsewhere")
                continue
            to = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not to.is_file():
                faults.append(f"{name}: {target} leads nowhere")
            elif parts.fragment and to in pages and unquote(parts.fragment) not in pages[to].places:
                faults.append(f"{name}: {target}: that page has no such place")
    return faults
