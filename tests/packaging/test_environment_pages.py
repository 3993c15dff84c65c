"""The pages of the site tell what the registry, the classes and the metrics say."""

from __future__ import annotations

import inspect
import math
import re
import sys
from pathlib import Path

import gymnasium
import pytest

from regionslam_env.tasks.metrics import METRICS, RANGES

ROOT = Path(__file__).parents[2]
SITE = ROOT / "docs" / "site"

sys.path.insert(0, str(SITE))
import environment_pages  # noqa: E402

sys.path.remove(str(SITE))

TASKS = environment_pages.tasks()
PAGES = environment_pages.pages()


def page_of(task: str) -> str:
    return PAGES[f"environments/{task.lower()}.md"]


def test_every_id_is_on_the_page_of_its_task():
    ids = {spec.id for spec in gymnasium.registry.values() if spec.namespace == environment_pages.NAMESPACE}
    assert len(ids) >= 12 and {"GoTo", "Explore", "Mission"} <= set(TASKS)
    told = {
        env_id for task in TASKS for env_id in re.findall(r"^\| `(RegionSLAM/[\w-]+)`", page_of(task), re.MULTILINE)
    }
    assert told == ids
    for task, specs in TASKS.items():
        assert specs[0].id == f"RegionSLAM/{task}-v0"
        assert f"[{task}]({task.lower()}.md)" in PAGES["environments/index.md"]


@pytest.mark.parametrize("task", TASKS)
def test_a_page_has_the_sections_of_gymnasiums_pages_in_their_order(task):
    assert re.findall(r"^## (.+)$", page_of(task), re.MULTILINE) == list(environment_pages.SECTIONS)
    own = inspect.cleandoc(environment_pages.environment_class(TASKS[task][0]).__doc__)
    assert own.count("\n## ") >= 4
    for line in own.split("\n## ", 1)[1].splitlines():
        assert line in page_of(task)


@pytest.mark.parametrize("task", TASKS)
def test_a_page_tells_every_argument_of_its_class_and_every_key_of_its_observations(task):
    page, plain = page_of(task), TASKS[task][0]
    for spec in TASKS[task]:
        for name in spec.kwargs:
            assert re.search(rf"^\| {name} \|", page, re.MULTILINE), name
    kind = environment_pages.environment_class(plain)
    assert f"`{kind.__module__}.{kind.__qualname__}`" in page
    env = gymnasium.make(plain.id)
    for key, space in env.observation_space.items():
        shape = re.search(rf"^\| {key} \| {type(space).__name__} \| (\([\d, ]+\)) \|", page, re.MULTILINE)
        assert shape is not None and shape[1] == str(space.shape), key
    assert f"`{env.action_space}`" in page


def test_the_columns_of_a_row_are_told_with_their_bounds():
    rows = re.findall(r"^\| (\d+) \| `(\w+)` \| (\S+) \| (\S+) \|", PAGES["environments/index.md"], re.MULTILINE)
    assert [name for _, name, _, _ in rows] == [column.name for column in environment_pages.RegionColumn]
    assert {name: (low, high) for _, name, low, high in rows}["COS"] == ("-1", "1")


METRIC_ROWS = dict(
    re.findall(r"^\| `(\w+)` \| ([^|]+) \|", (ROOT / "docs/metrics.md").read_text(encoding="utf-8"), re.MULTILINE)
)


def test_every_metric_is_defined_and_no_other():
    assert list(METRIC_ROWS) == list(METRICS)


def test_every_metric_has_the_range_that_is_told():
    words = {"true, false": (0, 1), "0 to 1": (0, 1), "0 m or more": (0, math.inf), "0 or more": (0, math.inf)}
    assert {name: words[told] for name, told in METRIC_ROWS.items()} == RANGES
