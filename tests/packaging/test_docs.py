"""The page that leads from the paper to the code names what is there, and the demo is one and the same."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "region-slam.md"
TEXT = PAGE.read_text(encoding="utf-8")
ROOT = PAGE.parents[1]

DRAWN = {"fig5.png", "fig6.png"}
"""Figures that `regionslam reproduce` draws."""

LINKS = re.findall(r"\[([^\]]*)\]\(([^):]+)\)", TEXT)
NAMED = sorted({(text.strip("`"), target) for text, target in LINKS if text.startswith("`")})


def defined(path: Path) -> set[str]:
    """Return the functions and classes of a file, and methods as `Class.method`."""
    found = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        if isinstance(node, ast.ClassDef):
            found |= {f"{node.name}.{inner.name}" for inner in node.body if isinstance(inner, ast.FunctionDef)}
    return found


def test_the_demo_is_the_same_run_with_make_and_without():
    (demo,) = re.findall(r"^\t\$\(BIN\)/(regionslam run .*)$", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    assert f"`{demo}`" in (ROOT / "README.md").read_text("utf-8")


@pytest.mark.parametrize("number", range(1, 24))
def test_every_equation_of_the_paper_is_mentioned(number):
    assert f"({number})" in TEXT


@pytest.mark.parametrize(("name", "target"), NAMED)
def test_what_is_named_is_in_the_linked_file(name, target):
    path = (PAGE.parent / target).resolve()
    package, *parts = path.relative_to(ROOT).with_suffix("").parts
    module = ".".join(parts)
    assert package in ("slam", "agents")
    assert name == module or name in {f"{module}.{thing}" for thing in defined(path)}


def test_every_linked_file_exists():
    targets = {target for _, target in LINKS} - DRAWN
    assert {target for target in targets if not (PAGE.parent / target).is_file()} == set()


def test_every_module_after_an_equation_of_the_paper_is_linked():
    cited = {
        path
        for path in (ROOT / "slam").rglob("*.py")
        if re.search(r"\beqs?\. ?\(?\d", ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "")
    }
    linked = {(PAGE.parent / target).resolve() for _, target in NAMED}
    assert cited
    assert cited - linked == set()


BUILDINGS = PAGE.with_name("bring-your-own-building.md").read_text(encoding="utf-8")


def test_the_examples_for_buildings_are_what_importers_read(tmp_path):
    import yaml

    from regionslam_env.worlds.importers.vocabulary import vocabulary

    (annotations,) = re.findall(r"```yaml\n(.*?)```", BUILDINGS, flags=re.DOTALL)
    assert set(yaml.safe_load(annotations)) == {"rooms", "doors"}
    (table,) = re.findall(r"```json\n(.*?)```", BUILDINGS, flags=re.DOTALL)
    (tmp_path / "t.json").write_text(table, encoding="utf-8")
    words = vocabulary("ifc", tmp_path / "t.json")
    assert words.type_of("Chemistry") == "laboratory" and words.area_of("Aula") == 120
    assert words.type_of("Executive Office 2.13") == "office"


def test_every_option_of_an_import_is_told():
    import inspect

    from agents.world_commands import import_world

    told = set(re.findall(r"`--(?:no-)?([a-z-]+)", BUILDINGS))
    assert {name.replace("_", "-") for name in inspect.signature(import_world).parameters} - {"file"} == told


@pytest.mark.parametrize("page", sorted(path.name for path in PAGE.parent.glob("*.md")))
def test_every_link_leads_to_a_file_that_is_there_without_the_site(page):
    links = re.findall(r"\]\(([^):#]+)(?:#[^)]*)?\)", (PAGE.parent / page).read_text(encoding="utf-8"))
    assert [link for link in links if not (PAGE.parent / link).is_file()] == []


def test_every_setting_is_told_with_its_default():
    from dataclasses import fields, is_dataclass

    from regionslam_env.config import NoiseConfig, RobotConfig, SensorConfig

    def settings(config):
        for entry in fields(config):
            value = getattr(config, entry.name)
            yield from settings(value) if is_dataclass(value) else [(entry.name, value)]

    text = PAGE.with_name("settings.md").read_text(encoding="utf-8")
    told = re.findall(r"^\| `(\w+)` \| (\S+) \|", text, flags=re.MULTILINE)
    defaults = [pair for config in (RobotConfig(), SensorConfig(), NoiseConfig()) for pair in settings(config)]
    assert {name: float(value == "True" or value) for name, value in told} == {
        name: pytest.approx(float(value), abs=1e-3 if name == "field_of_view" else 0) for name, value in defaults
    }
    assert len(told) == len(defaults)


README = ROOT / "README.md"


def test_every_file_the_readme_points_to_exists():
    links = re.findall(r"\]\(([^):]+)\)", README.read_text(encoding="utf-8"))
    assert links and all((ROOT / link).is_file() for link in links)
