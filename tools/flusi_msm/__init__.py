# SPDX-License-Identifier: GPL-3.0-or-later
"""Prepares and evaluates runs of flusi-msm, and offers its programs as functions (docs/guide/python.md).

`train`, `diagnose` and `fly` run the programs. `read_wing`, `read_measurement`, `read_training`, `read_diagnosis`, `read_series`
and `read_field` read their files. Functions take and return numpy arrays or tables in SI units unless they say otherwise. A
mistake of the user is an `InputError` whose text is meant for the user.
"""
from importlib import import_module
from typing import TYPE_CHECKING, Any

from flusi_msm.errors import InputError

if TYPE_CHECKING:
    from flusi_msm.measurement.file import write_measurement
    from flusi_msm.programs import RunError
    from flusi_msm.tables import Diagnosis, Measurement, list_fields, read_diagnosis, read_field, read_measurement, read_series, stroke_average, to_si
    from flusi_msm.training.run import Training, read_training
    from flusi_msm.wing.file import Wing, read_wing, write_wing
    from flusi_msm.workflow import DiagnosisResult, FlightResult, TrainingResult, diagnose, fly, train

# These modules are imported only when they are used: a tool that plots a wing does not wait for pandas.
_PLACES = {
    "flusi_msm.measurement.file": ("write_measurement",),
    "flusi_msm.programs": ("RunError",),
    "flusi_msm.tables": ("Diagnosis", "Measurement", "list_fields", "read_diagnosis", "read_field", "read_measurement", "read_series", "stroke_average",
                         "to_si"),
    "flusi_msm.training.run": ("Training", "read_training"),
    "flusi_msm.wing.file": ("Wing", "read_wing", "write_wing"),
    "flusi_msm.workflow": ("DiagnosisResult", "FlightResult", "TrainingResult", "diagnose", "fly", "train"),
}
_MODULE_OF = {name: module for module, names in _PLACES.items() for name in names}
__all__ = ["Diagnosis", "DiagnosisResult", "FlightResult", "InputError", "Measurement", "RunError", "Training", "TrainingResult", "Wing",
           "diagnose", "fly", "list_fields", "read_diagnosis", "read_field", "read_measurement", "read_series", "read_training", "read_wing",
           "stroke_average", "to_si", "train", "write_measurement", "write_wing"]
__version__ = "0.2.0"


def __getattr__(name: str) -> Any:
    if name in _MODULE_OF:
        return getattr(import_module(_MODULE_OF[name]), name)
    raise AttributeError(f"module 'flusi_msm' has no attribute {name!r}")
