from regionslam_env.errors import hint, unknown


def test_the_nearest_name_is_named():
    names = ["institute", *(f"floor {n}" for n in "abcdef")]
    assert unknown("world", "institut", names) == "unknown world 'institut': did you mean 'institute'?"


def test_a_few_names_are_all_listed_beside_the_nearest():
    line = unknown("arrival", "say", ["stay", "declare"])
    assert line == "unknown arrival 'say': did you mean 'stay'? Expected one of 'declare', 'stay'"
    assert unknown("level", "o", ["O"]) == "unknown level 'o': did you mean 'O'?"


def test_near_names_are_found_whatever_their_case():
    assert "'Hallway'" in unknown("type", "hallwya", ["Hallway", "Office"])


def test_all_names_are_listed_where_none_is_near():
    assert unknown("type", "xyz", ["office", "hallway"]) == "unknown type 'xyz': expected one of 'hallway', 'office'"


def test_values_of_any_kind_and_no_known_names_do_not_break_it():
    assert unknown("kind", None, []) == "unknown kind None"
    assert unknown("kind", [1] * 100, []) == f"unknown kind {str([1] * 100)[:80]}..."


def test_an_extra_is_named_as_it_is_installed_from_a_checkout():
    assert hint("figures need matplotlib", "plots") == 'figures need matplotlib: pip install -e ".[plots]"'
