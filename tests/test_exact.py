import math

import numpy as np
import pytest

from regionslam_env.exact import hypot, principal


@pytest.mark.parametrize("scale", [1e-12, 0.1, 1.0, 1e5])
def test_hypot_is_that_of_python_bit_by_bit(scale):
    pairs = np.random.default_rng(0).standard_normal((2000, 2)) * scale * np.array([[1.0, 0.3]])
    for x, y in [*pairs.tolist(), (0.0, 0.0), (-0.0, scale), (scale, scale)]:
        assert hypot(x, y) == math.hypot(x, y)


def test_principal_is_the_remainder_of_python_bit_by_bit():
    rng = np.random.default_rng(1)
    for angle in [*rng.uniform(-20, 20, 2000).tolist(), *(math.pi * np.arange(-9, 10)).tolist(), 1e6, -0.0]:
        expected = math.remainder(angle, 2 * math.pi)
        assert principal(angle) == expected
        assert math.copysign(1, principal(angle)) == math.copysign(1, expected)
