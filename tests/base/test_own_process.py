"""Errors in a thread fail a test: in the test's own process and in a program that it runs."""

import threading

import pytest
from own_process import run_program


def test_an_error_in_a_thread_of_a_program_is_an_error() -> None:
    program = """
        import threading
        thread = threading.Thread(target=lambda: 1 // {})
        thread.start()
        thread.join()
        print("ends")
    """
    assert run_program(program.format(1)) == "ends\n"
    with pytest.raises(AssertionError, match="ZeroDivisionError"):
        run_program(program.format(0))


@pytest.mark.xfail(raises=pytest.PytestUnhandledThreadExceptionWarning, strict=True)
def test_an_error_in_a_thread_of_a_test_fails_it() -> None:
    def fail() -> None:
        raise AssertionError

    thread = threading.Thread(target=fail)
    thread.start()
    thread.join()
