"""Hills to look at, for the examples: the same on every machine."""

import numpy as np


def hills(size: int = 256, height: float = 400.0, seed: int = 3) -> np.ndarray:
    """(size, size) elevations: noise whose amplitude falls with its frequency, as that of mountains does, and a winding valley."""
    random = np.random.default_rng(seed)
    frequency = np.fft.fftfreq(2 * size)
    far = np.hypot(frequency[:, None], frequency[None, :])
    far[0, 0] = np.inf
    waves = np.fft.fft2(random.normal(size=far.shape)) / far**2.1
    # A part of a larger sheet, which does not repeat.
    ground = np.real(np.fft.ifft2(waves))[:size, :size]
    ground = (ground - ground.min()) / np.ptp(ground)
    across = np.linspace(-1, 1, size)[:, None] - 0.35 * np.sin(np.linspace(0, 5, size))[None, :]
    return height * ground * (0.2 + 0.8 * (1 - np.exp(-((across / 0.3) ** 2))))


def relief(elevation: np.ndarray, cell_size: float) -> np.ndarray:
    """Shaded as on maps: light from the north-west, 0 to 1."""
    down, right = np.gradient(elevation, cell_size)
    light = (1 + 0.7 * right + 0.7 * down) / np.sqrt(1 + right**2 + down**2) / np.sqrt(1.98)
    return np.clip(light, 0, 1)
