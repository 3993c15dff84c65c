import dataclasses

import pytest

from regionslam_env.tasks.rewards import REWARD_SETS, RewardConfig, goto_reward, reward_set

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
    assert reward_set("standard") == reward_set(None) == reward_set({}) == RewardConfig()
    assert reward_set({"time": -0.5}) == RewardConfig(time=-0.5)
    assert reward_set(RewardConfig(success=3.0)).success == 3.0


@pytest.mark.parametrize(("given", "near"), [("sparce", "sparse"), ({"colision": -1}, "collision")])
def test_unknown_names_tell_the_nearest(given, near):
    with pytest.raises(ValueError, match=f"did you mean '{near}'"):
        reward_set(given)
