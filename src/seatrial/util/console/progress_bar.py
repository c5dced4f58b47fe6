# SPDX-License-Identifier: MIT
"""The line of progress as rich draws it. Imported only where it is drawn."""

from collections.abc import Callable, Iterable
from typing import TextIO

from rich.console import Console, RenderableType
from rich.progress import BarColumn, Progress, ProgressColumn, Task
from rich.table import Column
from rich.text import Text

from seatrial.util.errors import printable
from seatrial.util.status import Status, duration_text, time_left

PER_SECOND = 4.0  # [1/s] drawings
PERCENT, LEFT = 5, 15  # [columns] least widths
BARS = ((100, 20), (76, 10))  # [columns] of the terminal from which on a bar is so wide; else none


class SteadyConsole(Console):
    """Never hides the cursor: a process that is killed leaves the terminal as it was."""

    def show_cursor(self, show: bool = True) -> bool:
        """Nothing to do."""
        del show
        return False


class Words(ProgressColumn):
    """A part of the line. Names come from files: a Text is never read as markup."""

    def __init__(self, words: Callable[[], str], style: str, column: Column) -> None:
        super().__init__(table_column=column)
        self.words, self.style = words, style

    def render(self, task: Task) -> Text:
        """The words of this moment."""
        del task
        return Text(printable(self.words(), ""), style=self.style)


class Bar(Progress):
    """Stage, bar, percentage, time left; the latest status at every drawing."""

    def __init__(
        self, stream: TextIO, status: Callable[[], Status], begun: Callable[[], float | None]
    ) -> None:
        self.status = status
        console = SteadyConsole(file=stream, highlight=False, markup=False, emoji=False)
        bar = [wide for least, wide in BARS if console.width >= least][:1]
        room = console.width - PERCENT - LEFT - sum(bar) - len(bar) - 2
        super().__init__(
            Words(
                lambda: stage_text(status().stage, room),
                "",
                Column(no_wrap=True, overflow="ellipsis", ratio=1),
            ),
            *(BarColumn(wide) for wide in bar),
            Words(
                lambda: percent_text(status()),
                "bold",
                Column(no_wrap=True, justify="right", min_width=PERCENT),
            ),
            Words(lambda: left_text(status(), begun()), "dim", Column(no_wrap=True, min_width=LEFT)),
            console=console, transient=True, refresh_per_second=PER_SECOND, expand=True,
            redirect_stdout=False, redirect_stderr=False,
        )  # fmt: skip
        self.add_task("", total=1.0)

    def get_renderables(self) -> Iterable[RenderableType]:
        """The line with the bar where the status is."""
        for task in self.tasks:
            self.update(task.id, completed=self.status().share)
        return super().get_renderables()


def stage_text(stage: str, room: int) -> str:
    """The names of nested stages in so many columns: the outer ones give way to the inner one."""
    short = stage
    while len(short) > room and ": " in short:
        stage = stage.partition(": ")[2]
        short = f"… {stage}"
    return short


def percent_text(status: Status) -> str:
    """Share done."""
    return f"{100 * status.share:.0f} %"


def left_text(status: Status, begun: float | None) -> str:
    """Time left, of work that began at `begun` [s] on the monotonic clock."""
    left = None if begun is None else time_left(begun, status.share)
    return "" if left is None else f"{duration_text(left)} left"
