"""Every render mode, as Gymnasium uses it: without a display, with a window, as a film, as text."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.wrappers import HumanRendering, RecordVideo

from regionslam_env.envs import GoToEnv

IDS = ("RegionSLAM/GoTo-v0", "RegionSLAM/Explore-v0", "RegionSLAM/Mission-v0")
pytestmark = pytest.mark.compiled


def drive(env, steps=3):
    env.reset(seed=0)
    for _ in range(steps):
        env.step([0.5, 0.5])
    return env


@pytest.mark.parametrize("env_id", IDS)
def test_rgb_array_is_a_picture_of_its_own_memory(env_id):
    env = drive(gymnasium.make(env_id, render_mode="rgb_array"))
    first = env.render()
    assert first.dtype == np.uint8 and first.ndim == 3 and first.shape[2] == 3
    kept = first.copy()
    env.step([1.0, 0.0])
    assert (first == kept).all() and (env.render() != kept).any()


@pytest.mark.parametrize("env_id", IDS)
def test_ansi_tells_the_mission_and_shows_the_robot(env_id):
    env = drive(gymnasium.make(env_id, render_mode="ansi"))
    text = env.render()
    assert text.startswith(env.unwrapped.mission_text) and " me" in text and "\x1b" not in text


def test_ansi_keeps_its_direction_throughout_an_episode():
    """A start askew by half a right angle is where the picture would flip between two turns."""
    env = gymnasium.make("RegionSLAM/GoTo-v0", render_mode="ansi", goal="kitchen")
    env.reset(seed=0)
    env.reset(options={"start": (*env.unwrapped.true_pose[:2], np.pi / 4)})
    sizes = set()
    for _ in range(12):
        env.step([0.0, 0.2])
        lines = env.render().split("\n")
        legend = next(k for k, line in enumerate(lines) if line[1:].startswith(" me"))
        sizes.add(max(map(len, lines[1:legend])) > 2 * (legend - 1))
    assert len(sizes) == 1


@pytest.mark.filterwarnings("ignore:.*natively:UserWarning")
def test_human_opens_a_window_and_draws_every_step(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pygame = pytest.importorskip("pygame")
    env = drive(gymnasium.make("RegionSLAM/GoTo-v0", render_mode="human"))
    window = pygame.display.get_surface()
    assert window is not None and len(set(map(tuple, pygame.surfarray.array3d(window).reshape(-1, 3).tolist()))) > 10
    env.close()


def test_a_window_without_a_warning_is_gymnasiums_wrapper_by_hand(monkeypatch, recwarn):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pytest.importorskip("pygame")
    env = drive(HumanRendering(gymnasium.make("RegionSLAM/GoTo-v0", render_mode="rgb_array")))
    env.close()
    assert not [warning for warning in recwarn if "natively" in str(warning.message)]


def test_a_video_is_recorded_without_a_display(tmp_path, monkeypatch):
    pytest.importorskip("moviepy")
    monkeypatch.delenv("DISPLAY", raising=False)
    env = gymnasium.make("RegionSLAM/GoTo-v0", render_mode="rgb_array", max_steps=4)
    env = RecordVideo(env, str(tmp_path), episode_trigger=lambda episode: True)
    drive(env, 4)
    env.close()
    (film,) = tmp_path.glob("*.mp4")
    assert film.stat().st_size > 1000


def test_an_unknown_mode_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match="rgb_array"):
        GoToEnv(render_mode="rgb_arrray")


def test_no_mode_draws_nothing_and_loads_no_renderer():
    code = (
        "import sys, gymnasium, regionslam_env\n"
        "env = gymnasium.make('RegionSLAM/GoTo-v0').unwrapped\n"
        "env.reset(seed=0), env.step([0.5, 0.5])\n"
        "print(env.render(), [m for m in ('PIL', 'pygame') if m in sys.modules])"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.stdout.strip() == "None []", result.stderr
