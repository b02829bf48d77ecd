"""Work that takes longer than a frame, done in a thread of its own while the viewer draws."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Generic, TypeVar

Result = TypeVar("Result")


class Worker(Generic[Result]):
    """Does one piece of work after the other; of those that are asked for meanwhile, only the last.

    Attributes
    ----------
    busy : bool
        Whether what was asked for last is still to come.
    """

    def __init__(self) -> None:
        self._threads = ThreadPoolExecutor(1, thread_name_prefix="anamorph-viewer")
        self._future: Future[Result] | None = None
        self._key: object = None
        self.busy = False

    def get(self, key: object, work: Callable[[], Result], patience: float) -> Result | None:
        """The result of a piece of work; None until it is there, and where it has failed.

        Parameters
        ----------
        key : object
            What stands for the work: it is done again only for a key that is not equal to the last.
        work : callable
        patience : float
            How long to wait for it, seconds.

        Raises
        ------
        Exception
            What the work has raised, once.
        """
        if key != self._key and (self._future is None or self._future.done()):
            self._key, self._future = key, self._threads.submit(work)
        if self._future is None:
            return None
        wait([self._future], patience)
        self.busy = key != self._key or not self._future.done()
        if self.busy:
            return None
        if self._future.exception() is None:
            return self._future.result()
        failed, self._future = self._future, None
        return failed.result()
