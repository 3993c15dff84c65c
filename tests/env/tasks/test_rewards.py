import dataclasses

import pytest

from regionslam_env.tasks.rewards import (
    EXPLORE_REWARD_SETS,
    REWARD_SETS,
    ExploreRewardConfig,
    RewardConfig,
    explore_reward,
    goto_reward,
    reward_set,
)

QUIET = {"progress": 0.0, "success": False, "collided": False, "false_arrival": False}


def terms(weights=RewardConfig(), **happened):  # noqa: B008 - frozen
    return goto_reward(weights, **(QUIET | happened))


def test_every_weight_is_a_term():
    assert set(terms()) == {field.name for field in dataclasses.fields(RewardConfig)}


def test_coming_nearer_pays_and_going_away_costs_as_much():
    assert terms(progress=0.1)["progress"] == pytest.approx(0.1)
    assert terms(progress=-0.1)["progress"] == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("event", "term", "sign"),
    [("success", "success", 1), ("collided", "collision", -1), ("false_arrival", "false_arrival", -1)],
)
def test_sign_of_what_happens(event, term, sign):
    assert terms()[term] == 0
    assert terms(**{event: True})[term] * sign > 0


def test_time_costs_in_every_step():
    assert terms()["time"] < 0


def test_standing_still_for_an_episode_costs_less_than_a_false_arrival():
    assert 1000 * terms()["time"] >= terms(false_arrival=True)["false_arrival"]


def test_sparse_reward_is_the_success_alone():
    assert sum(terms(REWARD_SETS["sparse"], progress=3.0, collided=True, false_arrival=True).values()) == 0
    assert sum(terms(REWARD_SETS["sparse"], success=True).values()) == 1


def test_weights_by_name_dictionary_or_object():
    assert (
        reward_set("standard", REWARD_SETS)
        == reward_set(None, REWARD_SETS)
        == reward_set({}, REWARD_SETS)
        == RewardConfig()
    )
    assert reward_set({"time": -0.5}, REWARD_SETS) == RewardConfig(time=-0.5)
    assert reward_set(RewardConfig(success=3.0), REWARD_SETS).success == 3.0


@pytest.mark.parametrize(("given", "near"), [("sparce", "sparse"), ({"colision": -1}, "collision")])
def test_unknown_names_tell_the_nearest(given, near):
    with pytest.raises(ValueError, match=f"did you mean '{near}'"):
        reward_set(given, REWARD_SETS)


def exploring(weights=ExploreRewardConfig(), **happened):  # noqa: B008 - frozen
    quiet = {"recall": 0.0, "edges": 0.0, "success": False, "collided": False, "false_arrival": False}
    return explore_reward(weights, **(quiet | happened))


def test_every_weight_of_exploring_is_a_term_with_its_sign():
    assert set(exploring()) == {field.name for field in dataclasses.fields(ExploreRewardConfig)}
    assert exploring(recall=0.1)["recall"] == -exploring(recall=-0.1)["recall"] == pytest.approx(2.0)
    assert exploring(edges=0.1)["edges"] == -exploring(edges=-0.1)["edges"] == pytest.approx(1.0)
    assert exploring(success=True)["success"] > 0 and exploring()["success"] == 0
    assert exploring(collided=True)["collision"] < 0 and exploring()["collision"] == 0
    assert exploring(false_arrival=True)["false_arrival"] < 0 and exploring()["false_arrival"] == 0
    assert sum(exploring(EXPLORE_REWARD_SETS["sparse"], recall=0.5, edges=0.5, success=True).values()) == 1


def test_weights_belong_to_their_task():
    assert reward_set({"edges": 2}, EXPLORE_REWARD_SETS) == ExploreRewardConfig(edges=2.0)
    with pytest.raises(ValueError, match="unknown key of reward 'progress'"):
        reward_set({"progress": 2}, EXPLORE_REWARD_SETS)
