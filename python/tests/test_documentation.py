"""Documentation: examples of docstrings, the page of the book, and the version."""

import doctest
import inspect
import pathlib
import re

import pytest

import diffract

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs/PYTHON.md"


def documented():
    """Returns everything that users see, by name."""
    found = {"diffract": diffract}
    for name in diffract.__all__:
        found[name] = value = getattr(diffract, name)
        if inspect.isclass(value):
            members = {key: member for key, member in vars(value).items() if not key.startswith("_")}
            found.update({f"{name}.{key}": getattr(member, "__func__", member) for key, member in members.items()})
    return {name: value for name, value in found.items() if inspect.getdoc(value) is not None or callable(value)}


@pytest.mark.parametrize("name", [name for name, value in documented().items() if ">>>" in (inspect.getdoc(value) or "")])
def test_the_examples_of_docstrings_print_what_they_say(name):
    value = documented()[name]
    case = doctest.DocTestParser().get_doctest(inspect.getdoc(value), {}, name, None, None)
    told = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(case, out=told.append)
    assert not told, "".join(told)


def test_everything_has_a_docstring_that_begins_as_a_sentence():
    for name, value in documented().items():
        if name in ("Cancelled", "DeviceError"):
            continue
        first = (inspect.getdoc(value) or "").splitlines()[:1]
        assert first and first[0][0].isupper() and "{optics}" not in inspect.getdoc(value), name


def test_help_is_a_page_that_begins_with_the_units():
    import pydoc

    page = pydoc.plain(pydoc.render_doc(diffract))
    assert "Lengths are metres" in page.split("DESCRIPTION")[0] + page.split("DESCRIPTION")[1][:200]
    for name in diffract.__all__:
        assert name in page


def blocks():
    """Returns the blocks of Python in the page of the book, each behind as many lines as stand before it."""
    found, inside = [], None
    for number, line in enumerate(PAGE.read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("```"):
            if inside is not None:
                found.append("\n".join(inside))
                inside = None
            elif line.strip() == "```python":
                inside = [""] * number
        elif inside is not None:
            inside.append(line)
    return found


def test_the_page_of_the_book_runs(scratch, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "agg")
    # Workers of other processes import what the page defines from a file, as they do from a user's.
    monkeypatch.syspath_prepend(str(scratch))
    space = {"__name__": "page"}
    found = blocks()
    assert len(found) >= 8
    for block in found:
        exec(compile(block, str(PAGE), "exec"), space)
    for picture in re.findall(r"images/(python-[a-z]+\.png)", PAGE.read_text(encoding="utf-8")):
        assert (scratch / picture).stat().st_size > 1000


def test_the_version_has_one_place():
    def version(path, pattern):
        return re.search(pattern, (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE).group(1)

    program = version("Cargo.toml", r'^version = "(.*)"')
    assert diffract.__version__ == program
    assert version("CITATION.cff", r"^version: (.*)") == program
    assert version("integrations/three/package.json", r'"version": "(.*)"') == program


def test_a_cluster_of_four_workers_with_a_shared_cache_answers_bit_by_bit(scratch):
    from distributed import Client, LocalCluster

    def colours(seed, cache):
        import numpy
        import diffract

        field = diffract.HeightField.generate("elaphe", seed=seed, patch=4e-6)
        context = diffract.Context(cache=cache, threads=1)
        table = field.table(tolerance=0.1, coherence=4e-6, context=context)
        views = diffract.direction(numpy.linspace(0, 60, 50), 180)
        return table.rgb(diffract.direction(30, 0), views).tobytes()

    seeds = [1, 2, 3, 4, 1, 2, 3, 4]
    alone = [colours(seed, scratch / "alone") for seed in seeds[:4]] * 2
    options = {"n_workers": 4, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**options, local_directory=str(scratch)) as cluster, Client(cluster) as client:
        there = client.gather(client.map(colours, seeds, cache=scratch / "shared", pure=False))
    assert there == alone
    assert len(list((scratch / "shared").iterdir())) == 4
