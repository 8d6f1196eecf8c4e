"""Particle filters for state-space models, with proposals that are learned once.

A model is a file, a text, a dict, matrices or functions. Data are arrays, data frames or CSV files. A filter estimates hidden
states and the evidence, and warns when either cannot be trusted.

>>> import motes
>>> model = motes.Model.parse('''
... [initial]
... level = "normal(1000, 1000)"
... [transition]
... level = "normal(level, 38)"
... [measurement]
... flow = "normal(level, 123)"
... ''')
>>> filtered = model.filter([1120, 1160, None, 1210], seed=1)
>>> filtered.mean.shape
(4, 1)
"""

from ._errors import MotesWarning
from ._motes import __version__
from .card import Card
from .posterior_fit import PosteriorFit
from . import distributions
from .distributions import *
from .forecast import Forecast
from .functions import of_functions
from .linear import linear_gaussian
from .maximum_fit import MaximumFit, MaximumParameter
from .model import Model
from .online import OnlineFilter
from .proposal import Learned, Proposal
from .results import Filtered, Smoothed
from .settings import FilterSettings
from .simulated import Simulated
from .step import Step

__all__ = [
    *distributions.__all__,
    "Card",
    "FilterSettings",
    "Filtered",
    "PosteriorFit",
    "Forecast",
    "Learned",
    "MaximumFit",
    "MaximumParameter",
    "Model",
    "MotesWarning",
    "OnlineFilter",
    "Proposal",
    "Simulated",
    "Smoothed",
    "Step",
    "__version__",
    "linear_gaussian",
    "of_functions",
]
