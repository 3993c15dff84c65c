"""Priors by type and dimensions, and by pairs of types."""

from __future__ import annotations

import json
import math
import pickle
from typing import Any

import numpy as np
import pytest

from slam.checkpoint import settings_from_plain, settings_to_plain
from slam.config import SlamConfig
from slam.priors import ANY, TypePrior, by_pair, by_type, log_odds, names


def test_one_number_is_for_all() -> None:
    np.testing.assert_allclose(by_type(0.3, (), 0.5), [[log_odds(0.3), 0, math.inf, log_odds(0.3)]])
    np.testing.assert_allclose(by_pair(0.2, (), 0.5, mutual=True), [[math.log(0.25)]])


def test_the_last_entry_is_for_types_not_named() -> None:
    setting = {"office": 0.3, "hall": TypePrior(0.6, 2.0, 50.0, 0.05)}
    expected = [
        [log_odds(0.6), 2, 50, log_odds(0.05)],
        [log_odds(0.3), 0, math.inf, log_odds(0.3)],
        [0, 0, math.inf, 0],
    ]
    np.testing.assert_allclose(by_type(setting, ("hall", "office"), 0.5), expected)
    assert by_type({**setting, ANY: 0.1}, ("hall", "office"), 0.5)[2, 0] == pytest.approx(log_odds(0.1))


def test_the_most_exact_pair_counts() -> None:
    setting = {("table", "room"): 0.6, ("table", ANY): 0.3, (ANY, "room"): 0.2, (ANY, ANY): 0.05}
    types = ("room", "table")
    child = 1 / (1 + np.exp(-by_pair(setting, types, 0.1, mutual=False)))
    np.testing.assert_allclose(child, [[0.2, 0.05, 0.05], [0.6, 0.3, 0.3], [0.2, 0.05, 0.05]])
    link = 1 / (1 + np.exp(-by_pair({("table", "room"): 0.6}, types, 0.1, mutual=True)))
    np.testing.assert_allclose(link, [[0.1, 0.6, 0.1], [0.6, 0.1, 0.1], [0.1, 0.1, 0.1]])
    both = {("table", "room"): 0.6, ("room", "table"): 0.4}
    assert by_pair(both, types, 0.1, mutual=True)[0, 1] == pytest.approx(log_odds(0.4))


def test_named_types_are_all_that_settings_name() -> None:
    assert names([0.5, {"b": 0.1, ANY: 0.2}, {("a", ANY): 0.1, ("a", "c"): 0.2}]) == ("a", "b", "c")
    config = SlamConfig(
        prior_type={"office": 0.3}, prior_link={("door", ANY): 0.4}, prior_child={("desk", "office"): 0.6}
    )
    assert config.named_types == ("desk", "door", "office")
    p = config.priors()
    assert p.types.shape == (4, 4) and p.links.shape == p.children.shape == (4, 4)
    assert p.children[0, 2] == pytest.approx(log_odds(0.6))
    assert p.children[2, 0] == pytest.approx(log_odds(0.1))
    assert p.links[1, 3] == p.links[3, 1] == pytest.approx(log_odds(0.4))


def test_settings_survive_json_and_pickle() -> None:
    config = SlamConfig(
        prior_type={"a": 0.3, "b": TypePrior(0.6, 1, None, 0.2)}, prior_link={("a", "b"): 0.4, ("a", "c"): 0.6}
    )
    assert pickle.loads(pickle.dumps(config)) == config
    assert settings_from_plain(json.loads(json.dumps(settings_to_plain(config)))) == config
    nested = {"a": {"b": 0.4, "c": 0.6}}  # as users may have it in a file
    types = {"a": 0.3, "b": {"probability": 0.6, "min_area": 1, "outside": 0.2}}
    assert SlamConfig(prior_type=types, prior_link=nested) == config  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"prior_type": {"office": 1.2}}, r"prior_type\['office'\] is 1.2, expected a probability"),
        ({"prior_type": {"office": {"probability": 0.5, "area": 2}}}, r"prior_type\['office'\] has no field 'area'"),
        ({"prior_type": {"office": TypePrior(0.0)}}, r"prior_type\['office'\].probability is 0.0"),
        ({"prior_type": {"office": TypePrior(min_area=-1)}}, r"prior_type\['office'\].min_area is -1"),
        ({"prior_type": {"office": TypePrior(max_area=0)}}, r"prior_type\['office'\].max_area is 0"),
        ({"prior_type": {"office": TypePrior(outside=math.nan)}}, r"prior_type\['office'\].outside is nan"),
        ({"prior_type": {3: 0.5}}, r"prior_type has the key 3"),
        ({"prior_type": "high"}, r"prior_type is 'high'"),
        ({"prior_link": {"door": 0.5}}, r"prior_link has the key 'door', expected a pair"),
        ({"prior_link": {("a", "b"): 1}}, r"prior_link\[\('a', 'b'\)\] is 1, expected a probability"),
        ({"prior_child": True}, r"prior_child is True"),
    ],
)
def test_errors_name_the_entry(setting: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        SlamConfig(**setting)
