"""How Sphinx makes the site out of the pages that stage.py has laid out."""
# pylint: disable=invalid-name
import html
import os

from docutils.nodes import SkipNode

project = "Etendue"
html_title = "Etendue"
version = release = os.environ.get("ETENDUE_VERSION", "")
language = "en"
root_doc = "index"
extensions = ["myst_parser"]
source_suffix = {".md": "markdown"}
myst_heading_anchors = 4  # named as GitHub names them, which the pages' links rely on
myst_enable_extensions = ["dollarmath"]
html_theme = "furo"
html_static_path = ["_static"]
html_css_files = ["katex/katex.min.css", "site.css"]
html_js_files = ["katex/katex.min.js", "formulas.js"]
html_math_renderer = "katex"
html_copy_source = False
html_show_sourcelink = False
html_show_copyright = False
html_show_sphinx = False
html_use_index = False
pygments_style = "default"
pygments_dark_style = "monokai"


def keep_inline(writer, node):
    """The formula as it was written; formulas.js hands it to KaTeX."""
    writer.body.append(f'<span class="formula">{html.escape(node.astext())}</span>')
    raise SkipNode


def keep_block(writer, node):
    writer.body.append(f'<div class="formula">{html.escape(node.astext())}</div>')
    raise SkipNode


def setup(app):
    app.add_html_math_renderer("katex", (keep_inline, None), (keep_block, None))
