"""Numbers for a page: quantised, as differences, deflated, as base64.

A packed array is 16-bit whole numbers. Each is stored as its difference from the one before, in time or along the
array, with the sign in the lowest bit; first all low bytes, then all high ones. What rests then deflates to nothing.
"""

import base64
import zlib

import numpy as np

FRAMES = 32  # of a block, which the page inflates as a whole
STEPS = 65535


def deflated(*parts):
    return base64.b64encode(zlib.compress(b"".join(parts), 9)).decode()


def folded(differences):
    """Whole numbers of either sign as ones without: 0, -1, 1, -2, ... become 0, 1, 2, 3, ..."""
    bits = 8 * differences.dtype.itemsize - 1
    return ((differences << 1) ^ (differences >> bits)).astype(differences.dtype)


def planes(numbers):
    """The bytes of folded numbers: the lowest of all, then the next."""
    size = numbers.dtype.itemsize
    return np.ascontiguousarray(numbers.view(np.uint8).reshape(-1, size).T).tobytes()


def along(numbers):
    """The bytes of whole numbers by their differences along the last axis."""
    first = np.zeros((*numbers.shape[:-1], 1), numbers.dtype)
    differences = np.diff(numbers, axis=-1, prepend=first)
    return planes(folded(np.ascontiguousarray(differences).ravel()))


def quantised(values, low, high):
    """Steps between low and high, as int16 with the bits of uint16."""
    span = np.where(high > low, np.subtract(high, low), 1)
    steps = np.rint((values - low) / span * STEPS)
    return np.clip(steps, 0, STEPS).astype(np.uint16).view(np.int16)


def blocks(values, low, high, before=None):
    """Yields blocks of FRAMES frames of values [frame, element, component].

    The first frame of a block, and with `before`, another run's values, every frame, is stored as its difference from
    that other run; without one, as it is.
    """
    for first in range(0, len(values), FRAMES):
        part = quantised(in_order(values[first : first + FRAMES]), low, high)
        if before is None:
            reference = np.concatenate([np.zeros_like(part[:1]), part[:-1]])
        else:
            reference = quantised(in_order(before[first : first + FRAMES]), low, high)
        yield deflated(planes(folded((part - reference).transpose(0, 2, 1).ravel())))


def in_order(poses):
    """Poses with each quaternion of the two that mean its orientation that is nearer to the frame's before."""
    if poses.shape[2] != 7:
        return poses
    poses = np.array(poses)
    for frame in range(1, len(poses)):
        turned = (poses[frame, :, 3:] * poses[frame - 1, :, 3:]).sum(axis=1) < 0
        poses[frame, turned, 3:] *= -1
    return poses


def code_of(distance, size):
    """A distance as a byte: 0 of 0, else by its logarithm from 1e-8 of the scene's size, 1, to the size, 255."""
    with np.errstate(divide="ignore"):
        decades = np.log10(distance / size)
    return np.where(distance > 0, np.clip(np.rint(1 + 254 * (1 + decades / 8)), 1, 255), 0).astype(np.uint8)
