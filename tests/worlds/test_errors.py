from regionslam_env.errors import unknown


def test_the_nearest_name_is_named():
    assert (
        unknown("world", "institut", ["institute", "office"]) == "unknown world 'institut': did you mean 'institute'?"
    )


def test_near_names_are_found_whatever_their_case():
    assert "'Hallway'" in unknown("type", "hallwya", ["Hallway", "Office"])


def test_all_names_are_listed_where_none_is_near():
    assert unknown("type", "xyz", ["office", "hallway"]) == "unknown type 'xyz': expected one of 'hallway', 'office'"


def test_values_of_any_kind_and_no_known_names_do_not_break_it():
    assert unknown("kind", None, []) == "unknown kind 'None'"
