"""Files of CURVE keys: made, passed on, listed. The format is that of ``zmq.auth``."""

import os
import re
import shutil
import stat
from pathlib import Path

from zmq.auth import create_certificates, load_certificate
from zmq.utils import z85

from vegrip.errors import ConfigError

NAME = re.compile(r"[A-Za-z0-9_\-]{1,64}")
LENGTH = 40  # characters of a key
PUBLIC, SECRET = ".key", ".key_secret"


def make_keys(folder: Path, name: str) -> tuple[Path, Path]:
    """Make a pair of keys; return the files of the public and of the secret one, which only we can read."""
    if not NAME.fullmatch(name):
        raise ConfigError(f"{name!r} is no name for keys; use letters, digits, _ and -")
    if any((folder / f"{name}{suffix}").exists() for suffix in (PUBLIC, SECRET)):
        raise ConfigError(f"{folder} has keys of {name} already; choose another name or remove them")
    before = os.umask(0o077)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        public, secret = (Path(file) for file in create_certificates(folder, name))
    except OSError as error:
        raise ConfigError(f"no keys can be written to {folder}: {error.strerror}") from None
    finally:
        os.umask(before)
    return public, secret


def trust_key(public: Path, peers: Path) -> Path:
    """Put a public key into the folder ``peers`` of allowed subscribers; return its new path."""
    key, secret = read_keys(public)
    if secret is not None or public.suffix != PUBLIC:
        raise ConfigError(
            f"{public} is not a public key; pass on the file that ends in {PUBLIC}, never the other"
        )
    place = peers / public.name
    if place.exists() and read_keys(place)[0] != key:
        raise ConfigError(
            f"{place} is another key of the same name; remove it first if it is not used any more"
        )
    peers.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(public, place)
    return place


def list_keys(folder: Path) -> dict[str, str]:
    if not folder.is_dir():
        raise ConfigError(
            f"{folder}: there is no such folder; `vegrip keys new NAME` makes keys/, "
            "`vegrip keys trust FILE` keys/peers/"
        )
    return {file.stem: read_keys(file)[0].decode() for file in sorted(folder.glob(f"*{PUBLIC}"))}


def read_keys(file: Path) -> tuple[bytes, bytes | None]:
    """Return the public key in ``file``, and the secret one if it is there."""
    try:
        public, secret = load_certificate(file)
        for key in (public, secret):
            if key is not None and (len(key) != LENGTH or not set(key) <= set(z85.Z85CHARS)):
                raise ValueError(f"a key has {LENGTH} characters of Z85")
        mode = file.stat().st_mode
    except (OSError, ValueError, LookupError) as error:
        raise ConfigError(f"{file} is no key file: {error}") from None
    if secret is not None and stat.S_IMODE(mode) & 0o077:
        raise ConfigError(
            f"{file} can be read by other users; `chmod 600 {file}`, or make new keys if they did"
        )
    return public, secret
