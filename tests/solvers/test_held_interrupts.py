"""Ctrl-C while a problem is built comes when it is built, once, and leaves the handler as it was."""

from __future__ import annotations

import signal
import threading

import pytest

from mcdas_opt.solvers.held_interrupts import held_interrupts


def pressed_while_errors_are_cleared(done: list[str]) -> None:
    with held_interrupts():
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            done.append("dropped")
        done.append("built")


def test_an_interrupt_is_raised_at_the_end_and_the_handler_is_pythons_again() -> None:
    done: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        pressed_while_errors_are_cleared(done)
    assert done == ["built"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_without_an_interrupt_nothing_is_raised() -> None:
    with held_interrupts():
        assert signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_other_threads_leave_signals_alone() -> None:
    seen: list[object] = []

    def work() -> None:
        with held_interrupts():
            seen.append(signal.getsignal(signal.SIGINT))

    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    assert seen == [signal.default_int_handler]
