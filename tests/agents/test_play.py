import builtins

import gymnasium
import numpy as np
import pytest
from typer.testing import CliRunner

from agents import play as module
from agents.cli import app
from agents.console import InputError
from agents.play import play
from regionslam_env.envs import GoToEnv
from tests.floors import two_rooms

START = {"goal": "kitchen", "start": (2.0, 2.0, 0.0)}


@pytest.fixture
def pygame(monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    return pytest.importorskip("pygame")


class Pressing(gymnasium.Wrapper):
    """Presses keys before some of the steps, closes the window after others, and takes note of the actions."""

    def __init__(self, env, pygame, presses, last):
        super().__init__(env)
        self.pygame, self.presses, self.last, self.actions = pygame, presses, last, []

    def reset(self, **kwargs):
        return self.env.reset(**kwargs, options=START)

    def step(self, action):
        post, event = self.pygame.event.post, self.pygame.event.Event
        for kind, key in self.presses.get(len(self.actions), ()):
            post(event(kind, key=key))
        self.actions.append(np.asarray(action).tolist())
        if len(self.actions) == self.last:
            post(event(self.pygame.QUIT))
        return self.env.step(action)


def make(**kwargs):
    return GoToEnv(world=two_rooms(), render_mode="rgb_array", **kwargs)


@pytest.mark.compiled
def test_keys_drive_and_closing_the_window_ends(pygame):
    down, up = pygame.KEYDOWN, pygame.KEYUP
    presses = {0: [(down, pygame.K_UP)], 1: [(down, pygame.K_LEFT)], 2: [(up, pygame.K_UP), (up, pygame.K_LEFT)],
               3: [(down, pygame.K_s), (down, pygame.K_d)]}  # fmt: skip
    env = Pressing(make(), pygame, presses, last=5)
    assert play(env, seed=1) == 0
    assert env.actions == [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.0, 0.0], [-0.5, -0.5]]


@pytest.mark.compiled
def test_the_space_bar_declares_and_the_end_is_told(pygame):
    told = []
    env = Pressing(make(arrival="declare"), pygame, {0: [(pygame.KEYDOWN, pygame.K_SPACE)]}, last=2)
    assert play(env, seed=1, tell=told.append) == 1
    assert env.actions == [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]
    assert [info["false_arrival"] for info in told] == [True]


def without_pygame(monkeypatch):
    real = builtins.__import__

    def fake(name, *args, **kwargs):
        if name == "pygame":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", fake)


def test_without_pygame_it_says_what_to_install(monkeypatch):
    without_pygame(monkeypatch)
    with pytest.raises(InputError, match=r'pip install -e "\.\[render\]"'):
        play(make())


def test_without_a_display_it_says_so(pygame, monkeypatch):
    monkeypatch.setenv("SDL_VIDEODRIVER", "no such driver")
    with pytest.raises(InputError, match="no window can be opened"):
        play(Pressing(make(), pygame, {}, last=1))


def test_the_command_line_tells_how_an_episode_ended(monkeypatch):
    def drive(env, seed, tell):
        assert env.unwrapped.render_mode == "rgb_array" and seed == 3
        tell({"success": True, "spl": 0.5})
        return 1

    monkeypatch.setattr(module, "play", drive)
    result = CliRunner().invoke(app, ["play", "--goal", "kitchen", "--seed", "3", "--json"])
    assert result.exit_code == 0 and "arrow keys" in result.stdout and "Done: SPL 0.50." in result.stdout
    assert '"episodes": [{"success": true, "spl": 0.5}]' in result.stdout
