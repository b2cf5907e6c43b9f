"""Recordings: what fingertips measured, on disk and in memory, and the ways into that form."""

from vegrip.recording.data import Fingertip, Recording
from vegrip.recording.folder import read_recording, write_recording
from vegrip.recording.report import Finding, Kind, LoadReport

__all__ = ["Finding", "Fingertip", "Kind", "LoadReport", "Recording", "read_recording", "write_recording"]
