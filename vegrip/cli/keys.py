"""``vegrip keys``: keys for networks beyond this machine."""

from pathlib import Path
from typing import Annotated

import typer

from vegrip.cli._options import JSON, group
from vegrip.cli._terminal import answer

app = group(
    "Make and exchange keys: an address beyond this machine needs them.\n\n"
    "Example: vegrip keys new hand && vegrip keys trust keys/hand.key"
)
Folder = Annotated[Path, typer.Option(help="Folder of our own keys.")]


@app.command()
def new(
    name: Annotated[str, typer.Argument(help="Whose keys: one name for each program on the network.")],
    folder: Folder = Path("keys"),
    as_json: JSON = False,
) -> None:
    """Make a pair of keys: NAME.key is public, NAME.key_secret stays here.

    Example: vegrip keys new hand

    """
    from vegrip.transport.key_files import make_keys

    public, secret = make_keys(folder, name)
    _print_result(
        {"public": str(public), "secret": str(secret)},
        f"{public} is public: give it to the other side; {secret} is secret: keep it",
        as_json=as_json,
    )


@app.command()
def trust(
    key: Annotated[Path, typer.Argument(help="A public key, NAME.key.")],
    peers: Annotated[Path, typer.Option(help="Folder of the public keys of allowed subscribers.")] = Path(
        "keys/peers"
    ),
    as_json: JSON = False,
) -> None:
    """Let the owner of a public key subscribe to us.

    Example: vegrip keys new node && vegrip keys trust keys/node.key

    """
    from vegrip.transport.key_files import trust_key as trusted

    place = trusted(key, peers)
    _print_result({"trusted": str(place)}, f"{place}: may subscribe", as_json=as_json)


@app.command("list")
def list_(folder: Folder = Path("keys"), as_json: JSON = False) -> None:
    """List the public keys in a folder, to be compared over another way than the network.

    Example: vegrip keys new glove && vegrip keys list

    """
    from vegrip.transport.key_files import list_keys

    keys = list_keys(folder)
    _print_result(
        dict(keys), "\n".join(f"{name}  {key}" for name, key in keys.items()) or "no keys", as_json=as_json
    )


def _print_result(found: dict[str, str], sentence: str, *, as_json: bool) -> None:
    answer(found, lambda: typer.echo(sentence), as_json=as_json)
