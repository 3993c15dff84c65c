import json

import pytest
from PIL import Image
from typer.testing import CliRunner

from agents import generation_commands as commands
from agents.cli import app
from regionslam_env.rendering.gallery import draw_gallery
from regionslam_env.rendering.palette import PAPER, type_colour
from regionslam_env.worlds.format import load_world
from regionslam_env.worlds.generate.generator import KINDS, generate


def invoke(*args):
    return CliRunner().invoke(app, [str(a) for a in args])


def last_json(result):
    return json.loads(result.stdout.rstrip("\n").split("\n")[-1])


def test_a_world_is_generated_into_a_file(tmp_path):
    out = tmp_path / "world.geojson"
    result = invoke("world", "generate", "office", "--seed", 3, "--size", 20, "--out", out, "--json")
    assert result.exit_code == 0, result.output
    facts, world = last_json(result), load_world(out)
    assert (facts["kind"], facts["seed"], facts["split"], facts["file"]) == ("office", 3, "train", str(out))
    assert facts["regions"] == len(world.regions) and facts["doors"] == len(world.doors)
    assert [r.id for r in world.regions] == [r.id for r in generate("office", 3, {"size": 20}).regions]


def test_another_split_is_another_world(tmp_path):
    files = [tmp_path / f"{split}.geojson" for split in ("train", "test")]
    for file in files:
        assert invoke("world", "generate", "school", "--split", file.stem, "--out", file).exit_code == 0
    assert files[0].read_bytes() != files[1].read_bytes()


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("offise",), ("offise", "did you mean 'office'")),
        (("office", "--size", 3), ("world_options.size is 3", "5 to 10000")),
        (("office", "--clutter", 2), ("world_options.clutter is 2.0", "0 to 1")),
        (("office", "--split", "tset"), ("tset", "did you mean 'test'")),
        (("office", "--out", "world.png"), ("world.png", "expected .geojson")),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, told, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = invoke("world", "generate", *arguments)
    assert result.exit_code == 2 and "Traceback" not in result.output
    assert all(words in result.output for words in told) and not list(tmp_path.iterdir())


def test_a_kind_is_shown_by_number(tmp_path):
    result = invoke("world", "show", "apartment", "--seed", 4, "--out", tmp_path / "flat.png", "--json")
    assert result.exit_code == 0 and last_json(result)["name"] == "apartment 4"
    assert Image.open(tmp_path / "flat.png").size[0] > 500


def test_the_gallery_shows_every_kind(tmp_path):
    result = invoke("world", "gallery", "--size", 12, "--out", tmp_path / "worlds.png", "--json")
    assert result.exit_code == 0 and last_json(result)["kinds"] == list(KINDS)
    picture = Image.open(tmp_path / "worlds.png")
    assert picture.size[0] > 1000 and picture.size[1] > 5 * 300
    colours = {colour for _, colour in picture.convert("RGB").getcolors(1 << 24)}
    assert {PAPER, *map(type_colour, ("bed", "door", "hallway", "office"))} <= colours and len(colours) <= 256


@pytest.mark.parametrize("ending", ["jpg", "webp"])
def test_a_gallery_has_the_format_of_its_ending(ending, tmp_path):
    path = tmp_path / f"worlds.{ending}"
    assert invoke("world", "gallery", "--kind", "apartment", "--size", 10, "--out", path).exit_code == 0
    assert Image.open(path).mode == "RGB"


def test_the_gallery_of_one_kind_has_rows_of_difficulty(tmp_path, monkeypatch):
    monkeypatch.setattr(commands, "LADDERS", {"clutter": (0, 0.5, 1)})
    result = invoke("world", "gallery", "--kind", "apartment", "--size", 10, "--out", tmp_path / "w.png", "--json")
    assert result.exit_code == 0 and last_json(result)["kinds"] == ["apartment"]
    one_row = draw_gallery([[generate("apartment", k, {"size": 10}) for k in range(3)]]).size[1]
    assert Image.open(tmp_path / "w.png").size[1] > one_row + 300
    assert invoke("world", "gallery", "--kind", "castle", "--out", tmp_path / "w.png").exit_code == 2


def test_the_list_names_the_kinds():
    assert last_json(invoke("world", "list", "--json"))["kinds"] == list(KINDS)


@pytest.mark.compiled
def test_the_benchmark_reports_every_check():
    result = last_json(invoke("benchmark", "worlds", "--worlds", 2, "--kind", "apartment", "--json"))
    assert set(result["worlds_per_minute"]) == {"apartment"} and result["kinds"]["apartment"]["reachable"] == 1.0
    assert invoke("benchmark", "worlds", "--kind", "appartment").exit_code == 2
