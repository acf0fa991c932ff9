"""Python functions inside a solver of CasADi: nothing that they raise may cross the solver's frames."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache
from typing import Any


class Guard:
    """Keeps what is raised within a solver, to raise it at the end."""

    def __init__(self) -> None:
        self.raised: BaseException | None = None
        self._in_model = False

    @contextmanager
    def kept_together(self) -> Iterator[None]:
        """Let nothing that is raised cross the solver's frames: raise it at the end.

        Ctrl-C inside the model is such an exception; while the solver itself works it only leaves a note, as
        CasADi would take it for a failure of the solver.
        """

        def interrupted(*_: Any) -> None:
            if self._in_model:
                raise KeyboardInterrupt
            self.raised = KeyboardInterrupt()

        ours = (
            threading.current_thread() is threading.main_thread()
            and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        )
        if ours:
            signal.signal(signal.SIGINT, interrupted)
        try:
            yield
        finally:
            if ours:
                signal.signal(signal.SIGINT, signal.default_int_handler)
            if self.raised is not None:
                raise self.raised

    def guarded(self, function: Callable[..., list[Any]], arguments: Sequence[Any]) -> list[Any] | None:
        """Call `function`; keep what it raises, and from then on give nothing."""
        try:
            if self.raised is None:
                return function(*arguments)
        except BaseException as why:
            self.raised = why
        return None

    def ask(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call the model, which Ctrl-C may stop."""
        self._in_model = True
        try:
            return function(*arguments)
        finally:
            self._in_model = False


@lru_cache(1)
def callback_class() -> Any:
    """A CasADi function (name, method of a `Guard`, inputs, outputs), made once CasADi is loaded."""
    import casadi as ca

    class Callback(ca.Callback):
        def __init__(self, name: str, function: Any, inputs: dict[str, Any], outputs: dict[str, Any]) -> None:
            super().__init__()
            self.function, self.inputs, self.outputs = function, list(inputs.items()), list(outputs.items())
            self.construct(name, {})

        def get_n_in(self) -> int:
            return len(self.inputs)

        def get_n_out(self) -> int:
            return len(self.outputs)

        def get_name_in(self, i: int) -> str:
            return self.inputs[i][0]

        def get_name_out(self, i: int) -> str:
            return self.outputs[i][0]

        def get_sparsity_in(self, i: int) -> Any:
            return self.inputs[i][1]

        def get_sparsity_out(self, i: int) -> Any:
            return self.outputs[i][1]

        def eval(self, arguments: Sequence[Any]) -> list[Any]:
            answer = self.function.__self__.guarded(self.function, arguments)
            # zeros look like an optimum: the solver stops there without a complaint
            return [ca.DM(shape, 0.0) for _, shape in self.outputs] if answer is None else answer

    return Callback
