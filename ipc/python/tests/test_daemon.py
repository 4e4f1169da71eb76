"""What only a daemon does: shared memory, deaths, other processes and threads, signals."""

import gc
import os
import signal
import subprocess
import sys
import tempfile
import threading

import numpy as np
import pytest
from conftest import INSTANCE, PATIENCE, until

import taut

#: Stays at its first improvement until told to stop (fault_injection).
HANGS = 0x4A464A464A464A46


@pytest.fixture
def rooms(daemon, problems):
    return daemon.load_problem(problems / "rooms.json")


def hanging(planner, rooms, **options):
    return planner.shorten(rooms.path, rooms.robot, rooms.scene, mode="random-shortcut", seed=HANGS, **options)


def mapped(address):
    """Name of what is mapped at an address of this process."""
    with open("/proc/self/maps") as maps:
        for line in maps:
            start, end = (int(part, 16) for part in line.split()[0].split("-"))
            if start <= address < end:
                return line.split()[-1]
    raise AssertionError("nothing is mapped there")


def test_views_are_the_daemons_memory(daemon, rooms):
    best = daemon.shorten(rooms.path, rooms.robot, rooms.scene, budget=1000).result()
    address = best.path.__array_interface__["data"][0]
    assert best.is_shared and mapped(address).startswith("/dev/shm/")
    assert not mapped(best.copy().__array_interface__["data"][0]).startswith("/dev/shm/")
    assert best.path.__array_interface__["data"][0] == address


def test_who_keeps_many_gets_copies_and_nothing_changes(daemon, problems):
    shelf = daemon.load_problem(problems / "arm_shelf.json")
    kept, copies = [], []
    while sum(not best.is_shared for best in kept) == 0:
        for best in daemon.shorten(shelf.path, shelf.robot, shelf.scene, seed=len(kept)):
            kept.append(best)
            copies.append(best.copy())
        assert len(kept) < 10_000
    assert all(np.array_equal(best.path, copy) for best, copy in zip(kept, copies))


def test_finish_early_gives_the_best_so_far(daemon, rooms):
    with hanging(daemon, rooms) as answers:
        first = next(answers)
        answers.finish_early()
        assert answers.result(PATIENCE).length <= first.length


def test_dropping_or_closing_cancels(daemon, rooms):
    for end in (lambda answers: answers.close(), lambda answers: None):
        # More than may be in flight at once: each is over before the next.
        for _ in range(6):
            answers = hanging(daemon, rooms)
            next(answers)
            end(answers)
            del answers
            gc.collect()
    answers = hanging(daemon, rooms)
    answers.close()
    assert answers.next() is None and list(answers) == []
    with pytest.raises(taut.Cancelled):
        answers.result()


def test_a_timeout_is_no_end(daemon, rooms):
    with hanging(daemon, rooms) as answers:
        next(answers)
        assert answers.next(timeout=0.05) is None
        with pytest.raises(TimeoutError):
            answers.result(timeout=0.05)
        answers.finish_early()
        assert answers.result(PATIENCE).final


def test_a_deadline_is_kept(daemon, rooms):
    result = hanging(daemon, rooms, deadline=1.0).result(PATIENCE)
    assert result.ended == "deadline" and result.proved


def test_more_than_four_at_once_are_too_many_for_one_connection(daemon, rooms):
    held = [hanging(daemon, rooms) for _ in range(4)]
    with pytest.raises(taut.Overloaded):
        hanging(daemon, rooms)
    for answers in held:
        answers.close()


def test_many_threads_share_a_connection(daemon, rooms):
    plain = daemon.shorten(rooms.path, rooms.robot, rooms.scene, budget=500).result().path.copy()
    wrong = []

    def work():
        for _ in range(10):
            try:
                result = daemon.shorten(rooms.path, rooms.robot, rooms.scene, budget=500).result()
            except taut.Overloaded:
                continue
            if not np.array_equal(result.path, plain):
                wrong.append(result.path)

    threads = [threading.Thread(target=work) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert not wrong and not any(thread.is_alive() for thread in threads)


def test_one_thread_waits_and_another_ends_it(daemon, rooms):
    answers = hanging(daemon, rooms)
    next(answers)
    said = []

    def wait():
        while not said:
            try:
                said.append(answers.next())
            except taut.InvalidInput:
                # The other thread looks just now.
                continue
            except taut.Error as error:
                said.append(error)

    thread = threading.Thread(target=wait)
    thread.start()

    def is_busy():
        try:
            answers.next(timeout=0.0)
        except taut.InvalidInput as error:
            return "another thread" in str(error)
        return False

    until(is_busy)
    answers.close()
    thread.join(PATIENCE)
    assert isinstance(said[0], taut.Cancelled)


def test_a_killed_daemon_is_an_exception_and_views_stay(own_daemon, problems):
    planner = taut.connect(own_daemon.instance)
    rooms = planner.load_problem(problems / "rooms.json")
    answers = hanging(planner, rooms)
    best = next(answers)
    copy = best.copy()
    own_daemon.kill()
    with pytest.raises(taut.DaemonLost):
        answers.next(PATIENCE)
    assert answers.next() is None and np.array_equal(best.path, copy)
    with pytest.raises(taut.DaemonLost):
        planner.shorten(rooms.path, rooms.robot, rooms.scene)
    own_daemon.start()
    rooms = planner.load_problem(problems / "rooms.json")
    assert planner.shorten(rooms.path, rooms.robot, rooms.scene).result().proved
    assert np.array_equal(best.path, copy)


def test_no_daemon_is_said_so():
    # A socket's path is short.
    with tempfile.TemporaryDirectory(prefix="taut") as folder:
        with pytest.raises(taut.DaemonLost, match="taut serve"):
            taut.connect(f"none:{folder}/i")
    with pytest.raises(taut.Error):
        taut.connect("a bad name!")


def test_a_closed_connection_is_an_exception(planner, problems):
    planner.close()
    planner.close()
    assert planner.closed
    for call in (
        planner.robots,
        lambda: planner.robot("rooms"),
        lambda: planner.load_problem(problems / "rooms.json"),
        lambda: planner.shorten([[0.0, 0.0]], "rooms"),
        lambda: planner.scene("rooms").snapshot(),
    ):
        with pytest.raises(taut.DaemonLost, match="closed"):
            call()


def test_a_forked_child_is_refused_and_harms_nobody(daemon, rooms):
    answers = hanging(daemon, rooms)
    best = next(answers)
    child = os.fork()
    if child == 0:
        code = 1
        try:
            refused = 0
            for call in (daemon.robots, answers.next, lambda: best.path):
                try:
                    call()
                except taut.DaemonLost:
                    refused += 1
            del daemon, answers, best
            gc.collect()
            code = 0 if refused == 3 else 2
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0
    answers.finish_early()
    assert answers.result(PATIENCE).proved and "rooms" in daemon.robots()


WAITS = """
import signal, sys, taut
# A shell that starts the tests in the background has its children ignore this, and Python leaves that as it is.
signal.signal(signal.SIGINT, signal.default_int_handler)
d = taut.connect(sys.argv[1])
p = d.load_problem(sys.argv[2])
answers = d.shorten(p.path, p.robot, p.scene, mode="random-shortcut", seed=0x4A464A464A464A46)
next(answers)
try:
    print("waiting", flush=True)
    answers.result()
except KeyboardInterrupt:
    print("interrupted", flush=True)
    answers.finish_early()
    assert answers.result().proved
    sys.exit(7)
"""


def test_an_interrupt_comes_through(problems):
    command = [sys.executable, "-c", WAITS, INSTANCE, str(problems / "rooms.json")]
    child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "waiting\n"
    child.send_signal(signal.SIGINT)
    try:
        said, _ = child.communicate(timeout=PATIENCE)
    finally:
        child.kill()
    assert (said, child.returncode) == ("interrupted\n", 7)


def test_a_replaced_robot_of_other_columns_is_asked_for_again(daemon, problems, tmp_path):
    with taut.connect(INSTANCE) as other:
        robots = problems.parent / "robots"
        panda = other.load_robot("turncoat", robots / "panda_like.urdf", replace=True)
        start = np.zeros(7)
        start[3], start[5] = -1.5, 1.5
        path = np.linspace(start, start + 0.05, 4)
        names = panda.columns
        assert daemon.shorten(path, "turncoat", columns=names).result().proved
        turned = other.load_robot("turncoat", robots / "panda_like.urdf", columns=names[::-1], replace=True)
        assert turned.columns == names[::-1] and turned.hash != panda.hash
        again = daemon.shorten(path, "turncoat", columns=names).result()
        assert again.proved and np.array_equal(again.path[[0, -1]], path[[0, -1]])
        other.unload_robot("turncoat")
