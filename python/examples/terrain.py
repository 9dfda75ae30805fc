"""Hills to look at, for the examples: the same on every machine."""

import numpy as np


def hills(size: int = 256, cell_size: float = 20.0, height: float = 400.0, seed: int = 3) -> np.ndarray:
    """(size, size) elevations: noise of many sizes, half as high at twice the frequency, with a valley through the middle."""
    random = np.random.default_rng(seed)
    ground = np.zeros((size, size))
    for octave in range(2, 8):
        coarse = random.normal(size=(2**octave + 1, 2**octave + 1))
        at = np.linspace(0, 2**octave, size)
        rows = np.array([np.interp(at, np.arange(2**octave + 1), line) for line in coarse])
        both = np.array([np.interp(at, np.arange(2**octave + 1), line) for line in rows.T]).T
        ground += both / 2 ** (octave - 2)
    across = np.linspace(-1, 1, size)[:, None] - 0.35 * np.sin(np.linspace(0, 5, size))[None, :]
    ground = ground - ground.min()
    return ground / ground.max() * height * (0.15 + 0.85 * (1 - np.exp(-((across / 0.35) ** 2))))


def relief(elevation: np.ndarray, cell_size: float) -> np.ndarray:
    """Shaded as on maps: light from the north-west, 0 to 1."""
    down, right = np.gradient(elevation, cell_size)
    light = (1 + 0.7 * right + 0.7 * down) / np.sqrt(1 + right**2 + down**2) / np.sqrt(1.98)
    return np.clip(light, 0, 1)
