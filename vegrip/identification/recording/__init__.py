"""Recordings: what fingertips measured, on disk and in memory, and the ways into that form."""

from vegrip.identification.recording.data import Fingertip, Recording
from vegrip.identification.recording.folder import read_recording, write_recording
from vegrip.identification.recording.report import Finding, Kind, LoadReport

__all__ = ["Finding", "Fingertip", "Kind", "LoadReport", "Recording", "read_recording", "write_recording"]
