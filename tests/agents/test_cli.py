from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path

import pytest
from PIL import Image
from typer.testing import CliRunner

from agents import cli
from agents.cli import app
from agents.run import SUMMARY_KEYS
from regionslam_env.rendering.palette import PERSON, SHUT

EXAMPLES = Path(__file__).parents[1] / "worlds" / "importers" / "data"
START_IN_A_LINE = ("run", "go to the hallway", "--seed", "3")


def invoke(*args: object):
    return CliRunner().invoke(app, [str(a) for a in args])


def last_json(result) -> dict:
    return json.loads(result.stdout.rstrip("\n").split("\n")[-1])


@pytest.fixture(scope="module")
def mission(tmp_path_factory) -> tuple[Path, object]:
    out = tmp_path_factory.mktemp("out") / "new" / "folder"
    return out, invoke(*START_IN_A_LINE, "--out", out, "--json")


@pytest.mark.compiled
def test_a_mission_ends_with_success(mission):
    _, result = mission
    assert result.exit_code == 0, result.output
    assert "I am in" in result.stdout and "Done" in result.stdout


@pytest.mark.compiled
def test_the_summary_is_the_last_line_and_a_file(mission):
    out, result = mission
    summary = last_json(result)
    assert tuple(summary) == SUMMARY_KEYS
    assert json.loads((out / "summary.json").read_text()) == summary
    assert summary["success"] is True and summary["false_arrival"] is False
    assert summary["mission"] == "go to the hallway" and summary["world"] == "institute" and summary["seed"] == 3
    assert summary["localization"] == "slam" and summary["noise"] == "standard" and summary["dynamics"] == "none"
    assert summary["start_distance"] == 2 and summary["version"] == version("regionslam-env")
    assert 0 < summary["spl"] <= 1 and summary["path_length"] >= 2 and 0 <= summary["ape_end"] <= summary["ape_max"]


@pytest.mark.compiled
def test_a_mission_among_people_and_closing_doors(tmp_path):
    result = invoke(*START_IN_A_LINE, "--dynamics", "all", "--out", tmp_path, "--json")
    assert result.exit_code == 0, result.output
    summary = last_json(result)
    assert summary["success"] is True and summary["dynamics"] == "all"
    with Image.open(tmp_path / "mission.gif") as gif:
        colours = {colour for _, colour in gif.convert("RGB").getcolors(2**24)}
    assert {PERSON, SHUT} <= colours


def test_unknown_dynamics_are_refused_in_one_line():
    for command in (("run", "go to the hallway"), ("evaluate", "scripted"), ("play",)):
        result = invoke(*command, "--dynamics", "peeple")
        assert result.exit_code == 2
        assert "unknown dynamics 'peeple': did you mean 'people'?" in result.stderr


@pytest.mark.compiled
def test_every_output_is_complete(mission):
    out, _ = mission
    assert sorted(p.name for p in out.iterdir()) == [
        "map.geojson",
        "map.png",
        "mission.gif",
        "mission.png",
        "summary.json",
    ]
    with Image.open(out / "mission.gif") as gif:
        assert gif.n_frames > 3
    with Image.open(out / "map.png") as picture:
        picture.load()
    features = json.loads((out / "map.geojson").read_text())["features"]
    assert any(f["properties"]["type"] == "hallway" for f in features)


@pytest.mark.compiled
def test_the_same_command_gives_the_same_summary(mission):
    _, result = mission
    first, second = last_json(result), last_json(invoke(*START_IN_A_LINE, "--json"))
    del first["wall_seconds"], second["wall_seconds"]
    assert json.dumps(first) == json.dumps(second)


@pytest.mark.compiled
def test_a_failed_mission_has_exit_code_1(monkeypatch):
    monkeypatch.setattr("agents.run.MAX_STEPS", 3)
    result = invoke("run", "go to the kitchen", "--start-distance", 20, "--json")
    assert result.exit_code == 1
    summary = last_json(result)
    assert summary["success"] is False and summary["false_arrival"] is False and summary["steps"] == 3
    assert "out of time, 0% of the instructions done)" in result.stdout and summary["explored"] is None


@pytest.mark.compiled
def test_a_failed_exploration_says_how_much_is_missing(monkeypatch):
    monkeypatch.setattr("agents.run.MAX_STEPS", 100)
    result = invoke("run", "explore", "--json")
    assert result.exit_code == 1
    explored = last_json(result)["explored"]
    assert 0 < explored < 0.9
    words = f"out of time, 0% of the instructions done, {explored:.1%} of the regions mapped where 90% are needed)"
    assert words in result.stdout


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("run", "go to the kitchn"), ("kitchn", "kitchen")),
        (("run", "make me a sandwich"), ("sandwich", "go to the")),
        (("run", "go to the kitchen", "--world", "institut"), ("institut", "institute")),
        (("run", "go to the kitchen", "--world", "no/such.geojson"), ("no/such.geojson",)),
        (("run", "go to the kitchen", "--noise", "standart"), ("standart", "standard")),
        (("run", "go to the kitchen", "--localization", "slamm"), ("slamm", "slam")),
        (("run", "go to the kitchen", "--start-distance", "9999"), ("9999",)),
        (("run", "go to the kitchen", "--start-distance", "nan"), ("start-distance",)),
        (("run", "go to the kitchen", "--seed", "-1"), ("seed",)),
        (("evaluate", "scriptet"), ("scriptet", "scripted")),
        (("evaluate", "no/such.zip"), ("no/such.zip",)),
        (("evaluate", "random", "--env", "RegionSLAM/GoTo-v1"), ("GoTo-v1", "RegionSLAM/GoTo-v0")),
        (("evaluate", "random", "--goal", "kitchn"), ("kitchn", "kitchen")),
        (
            ("evaluate", "random", "--mission", "find the lab"),
            ("--mission is 'find the lab'", "RegionSLAM/GoTo-v0 takes --goal; RegionSLAM/Mission-v0 takes --mission"),
        ),
        (
            ("play", "--env", "RegionSLAM/Mission-Oracle-v0", "--goal", "lab"),
            ("--goal is 'lab'", "RegionSLAM/Mission-Oracle-v0 takes --mission; RegionSLAM/GoTo-v0 takes --goal"),
        ),
        (
            ("train", "--env", "RegionSLAM/Explore-v0", "--goal", "lab"),
            ("RegionSLAM/Explore-v0 is always the same; RegionSLAM/GoTo-v0 takes --goal",),
        ),
        (("evaluate", "random", "--split", "tests"), ("tests", "'test'")),
        (("train", "--out", "runs/x.foo"), ("runs/x.foo: ending '.foo', expected .zip",)),
        (("train", "--env", "CartPole-v1"), ("CartPole-v1", "RegionSLAM/GoTo-v0")),
        (("benchmark", "envs"), ("envs", "'env'")),
        (("benchmark", "tour", "--seeds", "0"), ("seeds",)),
        (("benchmark", "tour", "--noise", "standart"), ("standart", "standard")),
        (("world", "show", "institut"), ("institut", "institute")),
        (("world", "lst"), ("lst", "list")),
        (("world", "import", "no.xml"), ("no.xml",)),
        (("world", "import", EXAMPLES / "floor.yaml", "--scale", "-1"), ("floor.yaml", "scale is -1.0", "above 0")),
        (("world", "import", EXAMPLES / "imdf", "--scale", "2"), ("imdf", "scale is 2.0", "unit of its own")),
        (("world", "import", EXAMPLES / "imdf", "--level", "Ground flor"), ("Ground flor", "'Ground floor'")),
        (("world", "import", EXAMPLES / "home.json", "--level", "7"), ("home.json", "unknown level '7'", "'0'")),
        (("world", "import", EXAMPLES / "floor.yaml", "--types", "no.json"), ("no.json",)),
        (("world", "import", EXAMPLES / "floor.yaml", "--out", "w.png"), ("w.png", "expected .geojson")),
        (("world", "import", EXAMPLES / "floor.rooms.yaml"), ("floor.rooms.yaml", "import the map itself")),
        (("world", "import", EXAMPLES, "--out", "w.geojson"), ("w.geojson", "expected a folder")),
        (("world", "survey", "nowhere"), ("nowhere", "no folder")),
    ],
)
def test_bad_input_is_one_line_with_the_nearest_names(args, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = invoke(*args, *(("--out", tmp_path / "out") if args[0] == "run" else ()))
    assert result.exit_code == 2, result.output
    assert result.stderr.startswith("error: ") and result.stderr.count("\n") == 1, result.stderr
    assert all(word in result.stderr for word in words), result.stderr
    assert list(tmp_path.rglob("*.*")) == []  # nothing has been written


@pytest.mark.parametrize("content", [b"", b"{", b'{"type": "FeatureCollection"}', b"\xff\xfe\x00", b"[" * 5000])
@pytest.mark.parametrize("command", [("world", "validate"), ("run", "go to the kitchen", "--world")])
def test_a_broken_world_file_is_named(command, content, tmp_path):
    file = tmp_path / "broken.geojson"
    file.write_bytes(content)
    result = invoke(*command, file)
    assert result.exit_code == 2 and result.stderr.count("\n") == 1
    assert "broken.geojson" in result.stderr


def test_an_output_folder_that_is_a_file(tmp_path):
    (tmp_path / "out").write_text("")
    result = invoke("run", "go to the kitchen", "--out", tmp_path / "out")
    assert result.exit_code == 2 and "expected a folder" in result.stderr


@pytest.mark.parametrize("command", [("generate", "office"), ("import", EXAMPLES / "home.json")])
def test_a_world_that_cannot_be_written_is_named_as_it_was_given(command, tmp_path):
    (tmp_path / "file").write_text("")
    target = tmp_path / "file" / "a.geojson"
    result = invoke("world", *command, "--out", target)
    assert result.exit_code == 2 and result.stderr.startswith(f"error: {tmp_path / 'file'}")
    assert ".a" not in result.stderr and result.stderr.count("\n") == 1
    made = tmp_path / "new" / "folder" / "a.geojson"
    assert invoke("world", *command, "--out", made).exit_code == 0 and [made] == list(made.parent.iterdir())


@pytest.mark.compiled
def test_worlds_are_listed_and_shown(tmp_path):
    worlds = last_json(invoke("world", "list", "--json"))["worlds"]
    assert "institute" in [w["name"] for w in worlds]
    result = invoke("world", "show", "institute", "--out", tmp_path / "floor.png", "--json")
    assert result.exit_code == 0 and last_json(result)["types"]["kitchen"] == 1
    with Image.open(tmp_path / "floor.png") as picture:
        assert picture.size[0] == 1280


@pytest.mark.compiled
def test_a_world_survives_import_and_validation(tmp_path):
    from regionslam_env.worlds.format import save_world
    from regionslam_env.worlds.loading import load

    original, copy = tmp_path / "a.geojson", tmp_path / "b.geojson"
    save_world(load("institute"), original)
    imported = last_json(invoke("world", "import", original, "--out", copy, "--json"))
    assert imported["regions"] == len(load("institute").regions)
    valid = last_json(invoke("world", "validate", copy, "--json"))
    assert valid["valid"] is True and valid["unreachable"] == []


def test_a_building_is_imported_with_a_report(tmp_path):
    table, out = tmp_path / "own.json", tmp_path / "shop.geojson"
    table.write_text('{"labels": {"supplies": "workshop"}}')
    result = invoke("world", "import", EXAMPLES / "shop.building.yaml", "--out", out, "--types", table, "--json")
    assert result.exit_code == 0, result.output
    values = last_json(result)
    assert (values["doors"], values["connected"], values["level"], values["levels"]) == (3, True, "L1", ["L1", "L2"])
    assert values["good_share"] == 1.0 and values["flagged"] == []
    assert sorted(room["type"] for room in values["rooms"]) == ["hallway", "kitchen", "office", "workshop"]
    assert values["dropped"] == [{"what": "door at (5.0, -9.0)", "why": "leads to one room only"}]
    assert "every room can be reached by doors" in result.stdout
    assert last_json(invoke("world", "show", out, "--json"))["types"]["workshop"] == 1


def test_a_folder_of_buildings_is_imported_and_refusals_are_told(tmp_path):
    source = tmp_path / "plans"
    source.mkdir()
    for name in ("home.json", "cottage.xml"):
        (source / name).write_bytes((EXAMPLES / name).read_bytes())
    (source / "broken.yaml").write_text("rooms: 3")
    result = invoke("world", "import", source, "--out", tmp_path / "worlds", "--json")
    assert result.exit_code == 1, result.output
    values = last_json(result)
    assert sorted(f.name for f in (tmp_path / "worlds").iterdir()) == ["cottage.geojson", "home.geojson"]
    assert [Path(refused["file"]).name for refused in values["refused"]] == ["broken.yaml"]
    assert "tried" in values["refused"][0]["why"] and values["rooms"] == 8
    survey = invoke("world", "survey", source, "--json")
    assert survey.exit_code == 1 and last_json(survey)["good_share"] == 1.0
    for name in ("home.json", "cottage.xml"):
        (source / name).unlink()
    assert invoke("world", "survey", source).exit_code == 2


def test_a_survey_cuts_no_name_and_counts_in_english(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    name = "a-house-whose-name-is-so-long-that-it-fills-a-line-of-eighty-columns-of-a-terminal-0001.json"
    (tmp_path / name).write_bytes((EXAMPLES / "home.json").read_bytes())
    lines = invoke("world", "survey", tmp_path).stdout.splitlines()
    assert lines[0].split()[:4] == ["rooms", "doors", "assumed", "open"]
    assert f"{name}, 0, HouseExpo" in lines[1] and "…" not in "".join(lines)
    assert lines[-1].startswith("4 rooms on 1 level: ")
    (tmp_path / "other.json").write_bytes((EXAMPLES / "home.json").read_bytes())
    assert "8 rooms on 2 levels: " in invoke("world", "survey", tmp_path).stdout


@pytest.mark.compiled
def test_evaluation_prints_means_and_intervals(tmp_path):
    options = ("--split", "test", "--goal", "kitchen", "--dynamics", "people", "--out", tmp_path)
    result = invoke("evaluate", "random", "--env", "RegionSLAM/GoTo-Oracle-v0", "--episodes", 2, *options, "--json")
    assert result.exit_code == 0, result.output
    values = last_json(result)
    assert values["episodes"] == 2 and values["metrics"]["spl"]["n"] == 2
    assert values["metrics"]["false_arrival"]["n"] == 0  # nothing to declare in GoTo-v0
    assert "95 % interval" in result.stdout
    assert values["settings"] == {
        "world": "institute",
        "split": "test",
        "localization": "oracle",
        "noise": "standard",
        "dynamics": "people",
        "goal": "kitchen",
    }
    assert json.loads((tmp_path / "summary.json").read_text()) == values


@pytest.mark.compiled
@pytest.mark.parametrize("name", [(), ("env",)])
def test_the_benchmark_of_the_environment_is_the_default(name):
    result = invoke("benchmark", *name, "--steps", 100, "--json")
    assert result.exit_code == 0, result.output
    assert last_json(result)["steps_per_second"] > 0 and "steps per second" in result.stdout


def test_benchmarks_are_listed():
    result = invoke("benchmark", "--help")
    assert result.exit_code == 0
    assert all(name in result.stdout for name in ("env", "filter", "tour"))


def test_help_needs_no_environment():
    result = invoke("--help")
    assert result.exit_code == 0
    for command in ("run", "evaluate", "train", "benchmark", "world"):
        assert command in result.stdout


@pytest.mark.parametrize("group", [(), ("benchmark",), ("reproduce",), ("world",)])
def test_what_commands_do_is_listed_to_the_end(group, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    commands = invoke(*group, "--help").stdout.partition("Commands:\n")[2].splitlines()
    assert len(commands) > 1 and all(line.endswith(".") and len(line.split()) > 3 for line in commands), commands
    assert not any(line.endswith(("...", "Fig.")) for line in commands)


def test_the_version_is_told():
    result = invoke("--version")
    assert (result.exit_code, result.stdout) == (0, f"regionslam {version('regionslam-env')}\n")


def test_the_console_script_is_the_command_line():
    assert callable(cli.main)
