"""How the site is built: ``make docs``. Nothing is fetched while it is built, nor when it is read."""

from __future__ import annotations

import sys
from pathlib import Path

import hexathermal

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "hexathermal"
author = "the authors of hexathermal"
project_copyright = "the authors of hexathermal; MIT licence"
version = release = hexathermal.__version__

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_design",
    "written_by_code",
]
exclude_patterns = ["_build", "_extensions", "_templates"]
templates_path = ["_templates"]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb", ".ipynb": "myst-nb"}  # first: what autosummary writes
language = "en"
smartquotes = False  # `--force` stays two hyphens
default_role = "py:obj"  # single backticks of docstrings

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

nb_execution_mode = "force"
nb_execution_timeout = 120
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_ipywidgets_js = {}  # would be fetched from elsewhere
nb_merge_streams = True

autosummary_generate = True
autodoc_typehints = "none"  # parameters say type, shape and unit
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
toc_object_entries_show_parents = "hide"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True

linkcheck_timeout = 20
linkcheck_retries = 2
linkcheck_workers = 4

html_theme = "pydata_sphinx_theme"
html_title = "hexathermal"
html_static_path = ["_static"]
html_favicon = "_static/favicon.svg"
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_context = {"default_mode": "auto"}
html_sidebars = {"index": [], "tour": [], "examples": []}
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "collapse_navigation": True,  # no folding: its handles have no name for a screen reader
    "navigation_with_keys": False,  # arrow keys scroll
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
