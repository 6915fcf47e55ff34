"""Conversion of arguments to arrays."""

import numpy as np


def floats(name, value):
    """Returns `value` as an array of 64-bit floats of this machine; masked elements are NaN. Errors
    tell the `name` of the argument.
    """
    if isinstance(value, np.ma.MaskedArray):
        value = np.ma.filled(value.astype(np.float64), np.nan)
    try:
        array = np.asarray(value)
    except ValueError as error:
        raise ValueError(f"{name} is no array of numbers ({error}); give rows of the same length") from None
    if array.dtype.kind not in "fiub":
        raise TypeError(f"{name} has elements of the type {array.dtype}; give real numbers")
    return np.require(array, dtype=np.float64, requirements=["C", "A"])


def pair(name, value):
    """Returns a number twice, or two numbers, as a tuple."""
    try:
        numbers = tuple(float(number) for number in np.broadcast_to(floats(name, value), 2))
    except ValueError:
        raise ValueError(f"{name} is {value!r}; give one number or two") from None
    return numbers


def records(columns, kinds=None):
    """Returns `columns`, arrays by name, as a structured array; `kinds` has the types that are not
    64-bit floats.
    """
    kinds = kinds or {}
    dtype = np.dtype([(name, kinds.get(name, "f8")) for name in columns], align=True)
    table = np.empty(len(next(iter(columns.values()))), dtype)
    for name, values in columns.items():
        table[name] = values
    return table
