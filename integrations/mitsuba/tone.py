"""Displayed colours, as diffract shows them: shaders/color.glsl."""

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def without_negatives(rgb):
    """Moves colours toward the grey of the same luminance until no component is negative."""
    grey = np.maximum(rgb @ LUMINANCE, 0)[..., None]
    least = rgb.min(axis=-1, keepdims=True)
    return grey + (rgb - grey) * np.where(least < 0, grey / np.maximum(grey - least, 1e-30), 1)


def neutral(rgb):
    """Maps linear sRGB by the Khronos PBR Neutral Tone Mapper (Khronos Group, 2024)."""
    fresnel, start, desaturation = 0.04, 0.76, 0.15
    rgb = without_negatives(rgb)
    least = rgb.min(axis=-1, keepdims=True)
    rgb = np.maximum(rgb - np.where(least < 2 * fresnel, least - least**2 / (4 * fresnel), fresnel), 0)
    peak = rgb.max(axis=-1, keepdims=True)
    room = 1 - start
    compressed = 1 - room**2 / np.maximum(peak + room - start, 1e-30)
    white = 1 - 1 / (desaturation * (peak - compressed) + 1)
    bright = rgb * (compressed / np.maximum(peak, 1e-30))
    return np.where(peak < start, rgb, bright + (compressed - bright) * white)


def codes(rgb):
    """Returns the 8-bit codes of sRGB (IEC 61966-2-1)."""
    rgb = np.clip(rgb, 0, 1)
    return np.uint8(np.round(255 * np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * rgb ** (1 / 2.4) - 0.055)))
