"""A filter that was saved goes on as if it had never stopped, and a damaged file is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from slam.checkpoint import GENERATORS, generator_from_plain, generator_to_plain, settings_from_plain, settings_to_plain
from slam.config import SlamConfig
from slam.fastslam import RegionSLAM
from slam.geojson import MapError
from slam.measurement import MeasurementNoise, RegionMeasurement, Scan
from slam.motion import MotionNoise, Odometry
from slam.storage import load_arrays, save_arrays
from tests.slam.storage import check_storage

CONFIG = SlamConfig(
    n_particles=3,
    motion_noise=MotionNoise(distance=0.01),
    measurement_noise=MeasurementNoise(sigma_xy=0.2),
    gate_new=90,
)


def drive(slam: RegionSLAM, first: int, last: int) -> None:
    """Steps of a drive past four rooms, each drawn from its number alone."""
    for step in range(first, last):
        rng = np.random.default_rng(step)
        rooms = [
            RegionMeasurement("office", 5.0 * k - 0.3 * step + rng.normal(0, 0.1), 2.0, 4, 3, links={(k + 1) % 4: 0.9})
            for k in range(4)
        ]
        slam.step(Odometry(0.3, 0.0, rng.normal(0, 0.01)), Scan(rooms))


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    slam = RegionSLAM(CONFIG, seed=3)
    drive(slam, 0, 6)
    slam.save(tmp_path / "filter.npz")
    return tmp_path / "filter.npz"


def test_it_goes_on_bit_identically(saved: Path) -> None:
    through, resumed = RegionSLAM(CONFIG, seed=3), RegionSLAM.load(saved)
    drive(through, 0, 12)
    check_storage(resumed._posterior.cloud.maps)
    assert resumed.config == CONFIG
    drive(resumed, 6, 12)
    for name in ("pose_mean", "pose_cov", "ess", "types"):
        np.testing.assert_array_equal(getattr(resumed.belief, name), getattr(through.belief, name))
    assert resumed.belief.features.tobytes() == through.belief.features.tobytes()
    assert resumed.belief.map.to_geojson() == through.belief.map.to_geojson()


def test_saving_changes_nothing_and_twice_gives_the_same(saved: Path, tmp_path: Path) -> None:
    slam = RegionSLAM.load(saved)
    slam.save(tmp_path / "again.npz")
    a, b = load_arrays(saved), load_arrays(tmp_path / "again.npz")
    assert a.keys() == b.keys()
    assert all(a[name].tobytes() == b[name].tobytes() for name in a)


def test_a_damaged_file_is_refused_unless_the_damage_is_beside_the_content(saved: Path) -> None:
    """One bit is turned over at 60 places; some, such as the dates of a zip file, mean nothing."""
    sound, before = saved.read_bytes(), load_arrays(saved)
    refused = 0
    for place in np.linspace(0, len(sound) - 1, 60).astype(int):
        content = bytearray(sound)
        content[place] ^= 0x10
        saved.write_bytes(content)
        try:
            RegionSLAM.load(saved)
        except MapError as error:
            refused += 1
            assert str(error).startswith(f"{saved}: ")
        else:
            after = load_arrays(saved)
            assert all(after[name].tobytes() == before[name].tobytes() for name in before)
    assert refused > 40


def test_a_cut_file_and_another_file_are_refused(saved: Path, tmp_path: Path) -> None:
    saved.write_bytes(saved.read_bytes()[:-200])
    with pytest.raises(MapError, match=r"filter\.npz: not a file of arrays"):
        RegionSLAM.load(saved)
    save_arrays(tmp_path / "other.npz", {"a": np.zeros(3)})
    with pytest.raises(MapError, match=r"other\.npz: not a filter that was saved"):
        RegionSLAM.load(tmp_path / "other.npz")
    with pytest.raises(FileNotFoundError):
        RegionSLAM.load(tmp_path / "none.npz")


def test_a_changed_number_is_noticed(saved: Path) -> None:
    arrays = dict(load_arrays(saved))
    arrays["table"] = arrays["table"] + 1
    save_arrays(saved, arrays)
    with pytest.raises(MapError, match="damaged"):
        RegionSLAM.load(saved)


def test_another_version_is_refused(saved: Path) -> None:
    arrays = dict(load_arrays(saved))
    arrays["about"] = np.array(str(arrays["about"]).replace('"version": 2', '"version": 99'))
    save_arrays(saved, arrays)
    with pytest.raises(MapError, match="version is 99, expected 2"):
        RegionSLAM.load(saved)


@pytest.mark.parametrize("name", GENERATORS)
def test_every_generator_goes_on(name: str) -> None:
    generator = np.random.Generator(getattr(np.random, name)(5))
    generator.standard_normal(7)
    restored = generator_from_plain(generator_to_plain(generator))
    np.testing.assert_array_equal(restored.standard_normal(5), generator.standard_normal(5))


def test_settings_survive() -> None:
    assert settings_from_plain(settings_to_plain(CONFIG)) == CONFIG
