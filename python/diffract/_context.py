"""Cache, threads and device of calls."""

from __future__ import annotations

import os
from typing import Union

from diffract import _diffract

# 2 GiB, as the program's.
_LIMIT = 1 << 31
_default = None


class Context:
    """Cache, threads and device of calls.

    Every call that takes long has a keyword ``context``; without it, it takes the default one. Two
    contexts work at once in two threads. A context is pickled as its settings, and survives a fork.

    Parameters
    ----------
    cache : path, bool, optional
        Folder that keeps what is computed, for the next call and the next program. It is made if
        there is none. By default that of the user, ``~/.cache/diffract``; False for no cache.
    cache_limit : int, optional
        Largest size of the cache in bytes: 2 GiB.
    threads : int, optional
        Number of threads of its own. By default all contexts share as many as the machine runs at
        once.
    device : str, optional
        Part of the name of a Vulkan device, its number, or ``"cpu"`` for one in software. By
        default the best of the machine.

    Examples
    --------
    >>> import diffract
    >>> quiet = diffract.Context(cache=False, threads=1)
    >>> field = diffract.HeightField.generate("sinusoid", context=quiet)
    """

    def __init__(
        self,
        *,
        cache: Union[str, os.PathLike, bool, None] = None,
        cache_limit: int = _LIMIT,
        threads: int | None = None,
        device: str | None = None,
    ) -> None:
        self._settings = {"cache": cache, "cache_limit": cache_limit, "threads": threads, "device": device}
        folder = None if cache is None or isinstance(cache, bool) else os.fspath(cache)
        limit = 0 if cache is False else cache_limit
        self._core = _diffract.CoreContext(folder, limit, threads, device)

    def __repr__(self) -> str:
        given = {name: value for name, value in self._settings.items() if value not in (None, _LIMIT)}
        return f"Context({', '.join(f'{name}={value!r}' for name, value in given.items())})"

    def __reduce__(self):
        return _context, (self._settings,)


def _context(settings):
    return Context(**settings)


def set_default_context(context: Context) -> None:
    """Makes `context` the one of calls without a keyword ``context``.

    Examples
    --------
    >>> import diffract
    >>> diffract.set_default_context(diffract.Context(cache_limit=500_000_000))
    """
    global _default
    if not isinstance(context, Context):
        raise TypeError(f"context is a {type(context).__name__}; give a diffract.Context")
    _default = context


def core(context):
    """Returns the core of `context`, or of the default one."""
    global _default
    if context is None:
        if _default is None:
            _default = Context()
        context = _default
    if not isinstance(context, Context):
        raise TypeError(f"context is a {type(context).__name__}; give a diffract.Context")
    return context._core
