"""Entry of the `waymark` command."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

import typer

from server.cli import (
    bench,
    ca,
    demo,
    evaluate,
    experiment,
    export,
    fit_radio,
    labels,
    replay,
    report,
    serve,
    simulate,
    solve,
    tag,
    warm,
)
from server.cli.console import CommandError, say


def build() -> typer.Typer:
    """Return the command with all its subcommands."""
    command = typer.Typer(
        name="waymark",
        help="Mission control for search and rescue where GPS and radio fail.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
    )
    command.command("demo")(demo.demo)
    command.command("serve")(serve.serve)
    command.command("simulate")(simulate.simulate)
    command.command("replay")(replay.replay)
    command.command("evaluate")(evaluate.evaluate)
    command.command("export")(export.export)
    command.command("report")(report.report)
    command.command("solve")(solve.solve)
    command.command("fit-radio")(fit_radio.fit_radio)
    command.command("experiment")(experiment.experiment)
    command.command("bench")(bench.bench)
    command.add_typer(tag.tag)
    command.command("ca")(ca.ca)
    command.command("labels")(labels.labels)
    command.command("warm")(warm.warm)
    return command


def run(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit code: 0, 1 for what went wrong, 2 for what was typed wrongly.

    Everything that is the user's to mend ends in one sentence on stderr.
    """
    _one_thread_each()
    try:
        code = build()(args=arguments, prog_name="waymark", standalone_mode=False)
    except typer.TyperException as error:
        if error.exit_code == 2 and not error.format_message():
            return 2  # no arguments: the help has been printed
        say(f"{_sentence(error.format_message())} See waymark --help.")
        return error.exit_code
    except CommandError as error:
        say(_sentence(str(error)))
        return 1
    except (KeyboardInterrupt, typer.Abort):
        return 130
    except BrokenPipeError:  # the reader of our output went away, as `head` does
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115 - the interpreter closes it as it exits
        return 1
    return code if isinstance(code, int) else 0


def app() -> None:
    """Run the command and exit, for the script that an installation creates."""
    sys.exit(run())


def _one_thread_each() -> None:
    """Keep linear algebra and kernels to one thread each: on small matrices more make every step slower.

    The libraries read this when they are imported, so it has to stand before the first import of numpy.
    """
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ.setdefault(name, "1")


def _sentence(text: str) -> str:
    text = " ".join(text.split())
    return text if text.endswith((".", "!", "?")) else f"{text}."


if __name__ == "__main__":
    app()
