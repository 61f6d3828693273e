"""The command as a whole: quick to start, one sentence for an error, nothing imported before it is needed."""

import subprocess
import sys

import pytest

from server.cli import main
from server.cli.console import CommandError


def test_starting_does_not_import_what_only_some_commands_need():
    code = (
        "import sys, server.cli.main as m; m.build();"
        "print([n for n in ('numpy', 'numba', 'scipy', 'fastapi', 'viser') if n in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_libraries_are_told_to_use_one_thread_before_they_are_imported(monkeypatch):
    monkeypatch.delenv("OPENBLAS_NUM_THREADS", raising=False)
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    main.run(["--help"])
    assert main.os.environ["OPENBLAS_NUM_THREADS"] == "1"
    assert main.os.environ["NUMBA_NUM_THREADS"] == "3"  # what the user has set stays


def test_help_lists_every_subcommand(capsys):
    assert main.run(["--help"]) == 0
    shown = capsys.readouterr().out
    for name in ("demo", "serve", "simulate", "replay", "evaluate", "warm"):
        assert f"{name} " in shown


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fly"], "No such command 'fly'"),
        (["simulate", "--robots", "many"], "'--robots': Input should be a valid integer"),
        (["evaluate", "only.tum"], "Missing argument 'TRUTH.tum'"),
        (["simulate", "--wings"], "No such option: --wings"),
        (["simulate", "--poses", "guess"], "'guess' is not one of"),
    ],
)
def test_what_is_typed_wrongly_ends_in_one_sentence(capsys, arguments, words):
    assert main.run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert words in shown.err
    assert shown.err.count("\n") == 1
    assert "Traceback" not in shown.err


def test_an_interruption_ends_quietly(capsys, monkeypatch):
    monkeypatch.setattr("server.cli.main.build", lambda: _raising(KeyboardInterrupt()))
    assert main.run([]) == 130
    assert capsys.readouterr().err == ""


def test_an_error_of_several_lines_becomes_one_sentence(capsys, monkeypatch):
    monkeypatch.setattr("server.cli.main.build", lambda: _raising(CommandError("the file\nis gone")))
    assert main.run([]) == 1
    assert capsys.readouterr().err == "the file is gone.\n"


def _raising(error: BaseException):
    def command(**_: object) -> None:
        raise error

    return command
