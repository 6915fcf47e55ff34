"""Long work: progress, interruption, threads, processes and the end of the interpreter."""

import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import threading

import numpy as np
import pytest

import diffract
from diffract import Context, HeightField, direction


def python(code, **keywords):
    """Starts a Python process on `code`."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen([sys.executable, "-c", textwrap.dedent(code)], **pipes, **keywords)


def test_progress_is_told_on_the_thread_of_the_caller_and_fits_tqdm():
    import tqdm

    seen = []
    bar = tqdm.tqdm(file=open(os.devnull, "w"))

    def progress(done, of, stage):
        seen.append((done, of, stage, threading.get_ident()))
        bar.reset(of) or bar.update(done)

    field = HeightField.generate("elaphe", patch=20e-6)
    field.table(tolerance=0.02, progress=progress, context=Context(cache=False))
    assert seen and all(0 <= done <= of and isinstance(stage, str) for done, of, stage, _ in seen)
    assert {thread for *_, thread in seen} == {threading.get_ident()}


def test_an_error_in_progress_ends_the_work():
    def progress(done, of, stage):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        HeightField.generate("elaphe").table(tolerance=1e-3, footprint=0, progress=progress, context=Context(cache=False))


def test_ctrl_c_ends_the_work():
    # Minutes of work, if nothing ends it.
    process = python("""
        import signal
        import diffract
        # Shells let what they start behind them ignore the signal.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        context = diffract.Context(cache=False)
        def progress(done, of, stage):
            print("running", flush=True)
        try:
            diffract.render("sphere", "blaze", size=(640, 480), samples=20000, tolerance=0.1, context=context, progress=progress)
        except KeyboardInterrupt:
            print("interrupted", flush=True)
        """)
    assert process.stdout.readline() == "running\n"
    process.send_signal(signal.SIGINT)
    rest, errors = process.communicate(timeout=60)
    assert rest.endswith("interrupted\n") and process.returncode == 0, errors


def test_the_program_ends_by_ctrl_c_as_programs_do():
    command = [sys.executable, "-m", "diffract", "peaks", "elaphe", "--theta-i", "75", "--angles", "-40:40:0.001"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    # It is at work once it has threads of its own.
    while process.poll() is None and len(os.listdir(f"/proc/{process.pid}/task")) < 3:
        pass
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode == -signal.SIGINT


def test_a_closed_pipe_ends_the_program_quietly():
    process = subprocess.Popen(
        [sys.executable, "-m", "diffract", "help", "render"], stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    process.stdout.close()
    errors = process.stderr.read()
    process.wait(timeout=60)
    assert b"Traceback" not in errors and b"panic" not in errors


def test_the_program_says_what_is_wrong_and_returns_its_code():
    process = subprocess.run(
        [sys.executable, "-m", "diffract", "render", "--size", "0x0", "-o", "a.png"], capture_output=True, text=True
    )
    assert process.returncode == 2 and "--size" in process.stderr and not process.stdout


@pytest.mark.parametrize("is_daemon", [True, False])
def test_an_interpreter_ends_while_a_thread_renders(is_daemon):
    process = python(f"""
        import threading, diffract
        begun = threading.Event()
        def draw():
            context = diffract.Context(cache=False)
            diffract.render("sphere", "blaze", size=(640, 480), samples=20000, tolerance=0.1, context=context,
                            progress=lambda *_: begun.set())
        threading.Thread(target=draw, daemon={is_daemon}).start()
        begun.wait()
        if not {is_daemon}:
            # Threads that are no daemons are waited for: end them as a program does that is told to.
            import os, signal
            threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGTERM)).start()
        print("the end", flush=True)
        """)
    printed, errors = process.communicate(timeout=120)
    assert printed == "the end\n", errors
    assert process.returncode == (0 if is_daemon else -signal.SIGTERM), errors
    assert "panicked" not in errors and "Fatal" not in errors


def test_two_contexts_work_at_once_in_two_threads(tmp_path):
    field = HeightField.generate("sinusoid")
    light, views = direction(30, 0), direction(np.linspace(0, 60, 40), 180)
    tables = {}

    def make(name):
        context = Context(cache=tmp_path / name, threads=1)
        tables[name] = field.table(tolerance=0.05, coherence=20e-6, context=context)

    threads = [threading.Thread(target=make, args=(name,)) for name in ("one", "two")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    one, two = (tables[name].rgb(light, views) for name in ("one", "two"))
    np.testing.assert_array_equal(one, two)
    assert all(len(list((tmp_path / name).iterdir())) == 1 for name in ("one", "two"))


def test_other_threads_run_meanwhile():
    counted = []

    def count():
        while not done.is_set():
            counted.append(None)
            done.wait(0.001)

    done = threading.Event()
    thread = threading.Thread(target=count)
    thread.start()
    HeightField.generate("elaphe", patch=20e-6).table(tolerance=0.02, context=Context(cache=False))
    done.set()
    thread.join()
    assert len(counted) > 5


def answer_in_child(field, queue):
    queue.put(field.brdf()(direction(30, 0), direction(46.05, 180), 550e-9))


def answer_by_what_the_parent_made(brdf, queue):
    queue.put(brdf(direction(30, 0), direction(46.05, 180), 550e-9))


def test_a_fork_answers_by_what_its_parent_made(brdf):
    start = multiprocessing.get_context("fork")
    queue = start.Queue()
    process = start.Process(target=answer_by_what_the_parent_made, args=(brdf, queue))
    process.start()
    value = queue.get(timeout=120)
    process.join(timeout=60)
    assert value == brdf(direction(30, 0), direction(46.05, 180), 550e-9) and process.exitcode == 0


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_processes_answer_alike(blaze, brdf, method):
    start = multiprocessing.get_context(method)
    queue = start.Queue()
    process = start.Process(target=answer_in_child, args=(blaze, queue))
    process.start()
    value = queue.get(timeout=120)
    process.join(timeout=60)
    assert value == brdf(direction(30, 0), direction(46.05, 180), 550e-9) and process.exitcode == 0


def test_contexts_are_checked_and_pickled():
    import pickle

    context = pickle.loads(pickle.dumps(Context(cache=False, threads=2)))
    assert repr(context) == "Context(cache=False, threads=2)"
    with pytest.raises(ValueError, match="threads"):
        Context(threads=0)
    with pytest.raises(TypeError, match="context"):
        HeightField.generate("flat", context="mine")
    with pytest.raises(TypeError, match="context"):
        diffract.set_default_context(None)


def test_numbers_need_no_vulkan_and_pictures_say_what_to_install(without_vulkan):
    process = python("""
        import warnings, diffract
        import numpy as np
        field = diffract.HeightField.generate("elaphe")
        light = diffract.direction(75, 0)
        print(field.brdf()(light, diffract.direction(20, 180), 550e-9) > 0)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            peaks = field.peaks(75, np.arange(-40, -10, 0.5), wavelengths=[500e-9, 550e-9], context=diffract.Context(cache=False))
        print(peaks.period > 0, np.isnan(peaks.error), "left out" in str(caught[0].message))
        try:
            diffract.render("sphere", field, size=(8, 8))
        except diffract.DeviceError as error:
            print(error)
        """, env=without_vulkan)
    printed, errors = process.communicate(timeout=120)
    lines = printed.splitlines()
    assert lines[:2] == ["True", "True True True"], errors
    assert "install" in lines[2], printed


def test_10_000_small_calls_take_no_memory(brdf, blaze):
    def resident():
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")

    light, view = direction(30, 0), direction([10, 13], 180)
    table = blaze.table(tolerance=0.1, coherence=20e-6)

    def calls(count):
        for _ in range(count):
            brdf(light, view, 550e-9)
            brdf(light, view.astype(">f4"), [500e-9, 550e-9])
            table.rgb(light, view)
            blaze.heights.sum()
            direction(30, [0, 1])

    calls(500)
    before = resident()
    calls(2000)
    assert resident() - before < 4 << 20
