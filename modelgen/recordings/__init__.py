"""Recordings: cases, CSV tables in any unit, the kinematics of a displacement. Knows nothing of models."""

from modelgen.recordings.case import (
    Case,
    CaseFile,
    Noise,
    Recording,
    RecordingSpec,
    load_case,
    read_case_file,
)
from modelgen.recordings.kinematics import Kinematics, kinematics
from modelgen.recordings.signature import Channel, Signature

__all__ = [
    "Case",
    "CaseFile",
    "Channel",
    "Kinematics",
    "Noise",
    "Recording",
    "RecordingSpec",
    "Signature",
    "kinematics",
    "load_case",
    "read_case_file",
]
