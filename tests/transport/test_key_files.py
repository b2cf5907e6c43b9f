"""Keys: made so that only their owner can read them, passed on without the secret, compared by eye."""

import json
import stat

import pytest

from vegrip.cli import main
from vegrip.errors import ConfigError
from vegrip.transport.curve import Curve, Keys
from vegrip.transport.key_files import list_keys, make_keys, read_keys, trust_key


def test_the_secret_can_be_read_by_its_owner_only(tmp_path):
    public, secret = make_keys(tmp_path / "keys", "hand")
    assert stat.S_IMODE(secret.stat().st_mode) == 0o600
    assert read_keys(public)[0] == read_keys(secret)[0]
    assert read_keys(public)[1] is None


def test_a_secret_that_others_can_read_is_refused(tmp_path):
    public, secret = make_keys(tmp_path, "hand")
    secret.chmod(0o644)
    with pytest.raises(ConfigError, match="chmod 600"):
        Keys(Curve(own=str(secret), peers=str(tmp_path), publisher=str(public)))


def test_keys_are_never_overwritten(tmp_path):
    before = make_keys(tmp_path, "hand")[1].read_bytes()
    with pytest.raises(ConfigError, match="already"):
        make_keys(tmp_path, "hand")
    assert (tmp_path / "hand.key_secret").read_bytes() == before


@pytest.mark.parametrize("name", ["", "../up", "a b", "x" * 65])
def test_a_name_that_could_lead_elsewhere_is_refused(tmp_path, name):
    with pytest.raises(ConfigError, match="no name"):
        make_keys(tmp_path, name)


def test_a_trusted_key_is_in_the_folder_and_the_secret_never_is(tmp_path):
    public, secret = make_keys(tmp_path, "node")
    assert trust_key(public, tmp_path / "peers").name == "node.key"
    assert list_keys(tmp_path / "peers") == list_keys(tmp_path)
    with pytest.raises(ConfigError, match="not a public key"):
        trust_key(secret, tmp_path / "peers")
    other, _ = make_keys(tmp_path / "other", "node")
    with pytest.raises(ConfigError, match="another key"):
        trust_key(other, tmp_path / "peers")


def test_the_command_line_says_where_the_keys_are(tmp_path, capsys):
    folder, peers = str(tmp_path / "k"), str(tmp_path / "p")
    assert main(["keys", "new", "hand", "--folder", folder, "--json"]) == 0
    made = json.loads(capsys.readouterr().out)
    assert main(["keys", "trust", made["public"], "--peers", peers]) == 0
    capsys.readouterr()
    assert main(["keys", "list", "--folder", peers, "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["hand"]) == 40, "a key is 40 characters of Z85"
    assert main(["keys", "new", "hand", "--folder", folder]) == 3
    assert main(["keys", "list", "--folder", str(tmp_path / "nowhere")]) == 3
