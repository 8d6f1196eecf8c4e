"""Proposals that were learned."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _motes
from .card import Card

if TYPE_CHECKING:
    from ._definition import Definition


class Proposal:
    """A proposal that was learned for a model, and can be used for any sequence of it."""

    def __init__(self, found: _motes.Proposal, model: Definition):
        self._found, self._model = found, model

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_found": self._model._model.proposal_bytes(self._found)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._found = self._model._model.proposal_of_bytes(state["_found"])

    @staticmethod
    def load(folder: str | os.PathLike[str], model: Definition, *, to_tune: bool = False) -> Proposal:
        """Reads the proposal that was saved in `folder`; it must have been learned for `model`.

        With `to_tune` the model's parameters may be others: it is then a `start` for `Model.learn`.
        """
        return Proposal(model._model.load_proposal(os.fspath(folder), to_tune), model)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Writes it into `folder`, replacing a proposal that is there. The command reads it by `--proposal folder`."""
        self._model._model.save_proposal(self._found, os.fspath(folder))

    @property
    def name(self) -> str:
        """What it is called on a card."""
        return self._found.name

    @property
    def choice(self) -> str:
        """What it was chosen as, in a sentence."""
        return self._found.choice

    @property
    def evidence_errors(self) -> dict[str, float]:
        """The root-mean-square error of the log-evidence of simulated sequences with 100 particles, in nats: of designed proposals,
        of what was learned for filters, and of the potentials that `Model.evidence` and `Model.smooth` take."""
        return dict(self._found.evidence_errors)

    def __repr__(self) -> str:
        return f"Proposal {self.name}: {self.choice}, {self._found.updates} updates in {self._found.seconds:.1f} s"


class Learned:
    """What came of learning."""

    def __init__(self, proposal: Proposal, validation: list[tuple[int, float]], seconds: float, card: Card | None, seed: int):
        #: The proposal, with the best weights on validation sequences.
        self.proposal = proposal
        #: What validation of a network for each particle said after so many updates, in nats a step: `(checks, 2)`.
        self.validation: NDArray[np.float64] = np.array(validation, dtype=np.float64).reshape(-1, 2)
        #: How long learning took.
        self.training_seconds = seconds
        #: The proposal beside designed ones; none where none was asked for.
        self.card = card
        #: What all its random numbers came from.
        self.seed = seed

    def __repr__(self) -> str:
        return repr(self.proposal) + ("" if self.card is None else f"\n{self.card!r}")

    def _repr_html_(self) -> str:
        return f"<p>{self.proposal!r}</p>" + ("" if self.card is None else self.card._repr_html_())


def named(proposal: str | Proposal, argument: str = "proposal") -> str | _motes.Proposal:
    """A proposal by its name, or a learned one as the compiled part has it."""
    if isinstance(proposal, Proposal):
        return proposal._found
    if isinstance(proposal, str):
        return proposal
    raise TypeError(f"{argument}: {type(proposal).__name__}; it must be a name or a Proposal")
