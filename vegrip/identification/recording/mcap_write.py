"""From a recording or a session to one MCAP file: a channel of JSON messages per table.

::

    attachment thumb/recording.toml     the descriptions, as they stand in the folder
    metadata   vegrip.missing_states    how many states of which finger were sent and are not in it, if any
    channel /hand/thumb/state           recording.csv; jsonschema vegrip.FingertipState
    channel /hand/thumb/contact         contact.csv and so on, on the topics of proto/messages.toml

The channel's metadata say which file it was and in which order its columns stood; the sequence of a message
is its row. ``log_time`` is the stamp of the message on the recorder's clock.
"""

import heapq
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from vegrip.errors import RecordingError
from vegrip.identification.recording.data import Recording
from vegrip.identification.recording.extras import bag_library
from vegrip.identification.recording.folder import TOML, toml_text
from vegrip.identification.recording.mcap_cells import json_schema, properties, to_json
from vegrip.identification.recording.mcap_tables import TextTable, read_all, tables_of
from vegrip.identification.recording.missing import MISSING
from vegrip.identification.recording.writer import SESSION
from vegrip.whole_file import whole_file

METADATA = f"vegrip.{MISSING}"
"""Name of the metadata record."""


def write_mcap(folder: Path | str, path: Path | str) -> dict[Path, Recording]:
    """Write the recording or session in ``folder`` to the MCAP file ``path``; return what was read.

    Raises:
        RecordingError: no recording, a damaged table, or a file that cannot be written.
        UsageError: the library mcap is not installed.

    """
    folder, path = Path(folder), Path(path)
    library = bag_library("mcap.writer")
    recordings = read_all(folder)
    tables = list(tables_of(folder, recordings))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part, part.open("wb") as file:
            writer = library.Writer(file, enable_data_crcs=True)
            writer.start(library="vegrip")
            for name, text in _descriptions(folder, recordings):
                writer.add_attachment(0, 0, name, "application/toml", text.encode())
            if missing := _missing(recordings):
                writer.add_metadata(METADATA, missing)
            _write_tables(writer, tables)
            writer.finish()
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written ({error.strerror or error})") from None
    return recordings


def _descriptions(folder: Path, recordings: dict[Path, Recording]) -> Iterator[tuple[str, str]]:
    if (folder / SESSION).exists():
        yield SESSION, _text(folder / SESSION)
    for place, recording in recordings.items():
        yield (place / TOML).relative_to(folder).as_posix(), toml_text(recording)


def _missing(recordings: dict[Path, Recording]) -> dict[str, str]:
    """Return finger -> states that its recorder lost, for programs that read no attachment."""
    return {
        recording.fingertip.name: str(recording.source[MISSING])
        for recording in recordings.values()
        if recording.source.get(MISSING)
    }


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise RecordingError(f"{path}: is not a text file in UTF-8") from None


def _write_tables(writer: Any, tables: list[TextTable]) -> None:
    first = min((table.stamps[0] for table in tables), default=0)
    earlier = max(-first, 0)  # times in MCAP are unsigned: all are moved so that the first is zero
    streams = [_stream(writer, table) for table in tables]
    for stamp, channel, sequence, data in heapq.merge(*streams, key=lambda message: message[0]):
        log_time = stamp + earlier
        writer.add_message(channel, log_time, data, log_time, sequence)


def _stream(writer: Any, table: TextTable) -> Iterator[tuple[int, int, int, bytes]]:
    """Register the channel of ``table`` and yield its messages: stamp, channel, row, JSON."""
    name = f"vegrip.{table.kind.__name__}"
    schema = writer.register_schema(name, "jsonschema", json_schema(table.kind, table.columns))
    about = {"file": table.file, "columns": ",".join(table.columns), "rows": str(len(table.rows))}
    channel = writer.register_channel(table.topic, "json", schema, about)
    known = properties(table.kind)
    for row, (stamp, cells) in enumerate(zip(table.stamps, table.rows, strict=True)):
        try:
            data = to_json(dict(zip(table.columns, cells, strict=True)), known)
        except RecordingError as error:
            raise RecordingError(f"{table.file}: row {row + 1}: {error}") from None
        yield stamp, channel, row, data
