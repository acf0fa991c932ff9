"""Recordings: cases, and CSV tables in any unit. Knows nothing of models."""

from modelgen.recordings.case import (
    Case,
    CaseFile,
    Noise,
    Recording,
    RecordingSpec,
    load_case,
    read_case_file,
)
from modelgen.recordings.signature import Channel, Signature

__all__ = [
    "Case",
    "CaseFile",
    "Channel",
    "Noise",
    "Recording",
    "RecordingSpec",
    "Signature",
    "load_case",
    "read_case_file",
]
