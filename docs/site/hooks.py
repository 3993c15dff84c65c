"""What the site adds to the pages in `docs`: README and changelog, and pages made from the code."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))  # the pages tell of this checkout, whatever is installed

from api_pages import link_modules, module_page, modules_in, public_page  # noqa: E402
from command_pages import command_page  # noqa: E402
from environment_pages import pages  # noqa: E402

APIS = {
    "regionslam_env": "What `import regionslam_env` offers beside the ids; nothing is loaded before it is asked for.",
    "slam": "The filter as a library of its own: NumPy and Numba only.",
}


def on_config(config: Any) -> Any:
    """Put the generated pages about environments into the navigation."""
    entry = next(item for item in config.nav if isinstance(item, dict) and "Environments" in item)
    entry["Environments"] = list(pages())
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the generated pages."""
    texts = [Path(file.abs_src_path).read_text(encoding="utf-8") for file in files.documentation_pages()]
    modules = sorted(set().union(*map(modules_in, texts)))
    generated = {
        "index.md": (ROOT / "README.md").read_text(encoding="utf-8").replace("](docs/", "]("),
        "changelog.md": (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"),
        "command-line.md": command_page(),
        **pages(),
        **{f"api/{package}.md": public_page(package, text) for package, text in APIS.items()},
        **{f"api/modules/{module}.md": module_page(module) for module in modules},
    }
    for place, text in generated.items():
        files.append(File.generated(config, place, content=text))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Point links out of `docs` to what the site has instead."""
    return link_modules(markdown).replace("](../README.md", "](index.md")
