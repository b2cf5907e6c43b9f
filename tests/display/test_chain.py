"""The chain from a file to a model: what is given wrong is one sentence that names what is wanted."""

import dataclasses

import numpy as np
import pytest

import vegrip
from vegrip.errors import InputError, KindError, RecordingError, UsageError, VegripError
from vegrip.identification.samples import SAMPLE_RADIUS_M
from vegrip.identification.samples import recording as sample_recording

COLUMNS = {"t": "time_s", "episode": "trial", "displacement": "depth_mm", "normal_force": "force_mN"}
UNITS = {"displacement": "mm", "normal_force": "mN"}


@pytest.fixture(scope="module")
def recording():
    t = np.arange(0.0, 4.0, 0.01)
    depth = np.interp(t, [0.0, 0.5, 1.0, 3.0, 3.5], [-2e-4, -2e-4, 8e-4, 8e-4, -2e-4])
    force = vegrip.paper_model(8e-3).simulate(t, depth).normal_force
    noise = np.random.default_rng(3).standard_normal((2, t.size)) * [[5e-6], [0.01]]
    columns = {"displacement": depth + noise[0], "normal_force": force + noise[1]}
    return vegrip.Recording("made", t, np.zeros(t.size, dtype=int), columns, vegrip.Fingertip(radius=8e-3))


@pytest.fixture(scope="module")
def fitted(recording):
    return vegrip.fit(recording)


@pytest.fixture
def table(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return vegrip.sample("press.csv")


def test_a_table_is_read_as_the_command_reads_it(table):
    mine = vegrip.import_recording(
        table, columns=COLUMNS, units=UNITS, radius="8 mm", noise={"normal_force": 0.01}
    )
    theirs = sample_recording()
    assert mine.fingertip.radius == SAMPLE_RADIUS_M
    assert mine.sensors["normal_force"] == 0.01
    for name in ("displacement", "normal_force"):
        np.testing.assert_array_equal(mine.columns[name], theirs.columns[name])


def test_several_tables_are_the_episodes_of_one_recording(table):
    one = vegrip.import_recording(table, columns=COLUMNS, units=UNITS)
    both = vegrip.import_recording(table, str(table), columns=COLUMNS, units=UNITS)
    assert len(both) == 2 * len(one)
    assert len(list(both.episodes())) == 12


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ((["press.csv"],), KindError, "wants the path of a table or rosbag, and was given a list"),
        ((), UsageError, "was given none"),
        (("nothing.csv",), InputError, "nothing.csv: there is no such file"),
        (("press.csv",), RecordingError, "columns: normal_force=COLUMN or map_file"),
    ],
)
def test_what_cannot_be_imported_is_said_in_the_words_of_python(table, given, error, said):
    with pytest.raises(error, match=said) as raised:
        vegrip.import_recording(*given)
    assert "--" not in str(raised.value)


def test_a_folder_that_is_a_recording_and_a_log_are_told_who_reads_them(table):
    vegrip.sample("press")
    vegrip.sample("press.blf")
    with pytest.raises(RecordingError, match=r"vegrip\.read_recording\('press'\)"):
        vegrip.import_recording("press")
    with pytest.raises(UsageError, match=r"vegrip import press\.blf -o FOLDER"):
        vegrip.import_recording("press.blf")
    with pytest.raises(KindError, match="wants a dict"):
        vegrip.import_recording(table, columns=["force"])


def test_a_sample_is_written_once_and_never_over_something_else(table):
    before = table.stat().st_mtime_ns
    assert vegrip.sample("press.csv") == table
    assert table.stat().st_mtime_ns == before
    table.write_text("mine")
    with pytest.raises(InputError, match="is not this sample"):
        vegrip.sample("press.csv")
    with pytest.raises(UsageError, match="did you mean press"):
        vegrip.sample("pres")


@pytest.mark.parametrize("call", [vegrip.compare, vegrip.fit, vegrip.diagnose, vegrip.refine, vegrip.draft])
@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("fit", "was given a Fit; give the recording and the model of it"),
        ("model", "was given a ContactModel; the model comes second"),
        ("press", "was given the text 'press'; read it first"),
        (None, "was given None; vegrip.read_recording"),
        ([1.0], "was given a list"),
    ],
)
def test_what_is_no_recording_is_named_with_what_is_wanted(call, given, said, fitted):
    of = {"fit": fitted, "model": fitted.model}.get(given, given) if isinstance(given, str) else given
    with pytest.raises(KindError, match=f"^{call.__name__} wants a Recording first, and {said}") as raised:
        call(of)
    assert isinstance(raised.value, TypeError)
    assert isinstance(raised.value, VegripError)


def test_what_is_no_model_noise_or_way_of_zeros_is_named(recording, fitted):
    with pytest.raises(KindError, match=r"wants a ContactModel .* was given a Fit; give its \.model"):
        vegrip.compare(recording, fitted)
    with pytest.raises(KindError, match=r"vegrip\.read_model\('m\.toml'\)"):
        vegrip.fit(recording, "m.toml")
    with pytest.raises(KindError, match="wants a Noise as its noise, and was given a float"):
        vegrip.fit(recording, noise=0.01)
    with pytest.raises(UsageError, match="zeros is 'each'; it is 'recording', 'episode' or a group"):
        vegrip.diagnose(recording, zeros="each")
    with pytest.raises(RecordingError, match="made holds no row, and so no episode; give fit a recording"):
        vegrip.fit(recording.select(recording.t < 0.0))


def test_a_model_that_was_fitted_leaves_the_same_as_its_fit(recording, fitted):
    assert vegrip.compare(recording, fitted.model).error == pytest.approx(fitted.error, rel=1e-3)


def test_what_cannot_be_added_is_said_before_a_fit(fitted):
    with pytest.raises(KindError, match="wants names of effects, such as 'adhesion', and was given 3"):
        fitted.add(3)
    with pytest.raises(VegripError, match="did you mean adhesion"):
        fitted.add("adhesio")
    assert fitted.add() is fitted


def test_a_ladder_is_of_fits_of_one_recording(recording, fitted):
    for given, said in ((fitted, "a Fit"), ([recording], "a Recording"), (3, "an int")):
        with pytest.raises(KindError, match=f"ladder wants fits of one recording, .* was given {said}"):
            vegrip.ladder(given)
    with pytest.raises(UsageError, match="given none"):
        vegrip.ladder([])
    columns = {**recording.columns, "normal_force": 1.01 * recording.columns["normal_force"]}
    other = vegrip.fit(dataclasses.replace(recording, name="other", columns=columns))
    with pytest.raises(UsageError, match="several recordings, made and other"):
        vegrip.ladder([fitted, other])
    again = vegrip.fit(dataclasses.replace(recording))
    assert [rung.effect for rung in vegrip.ladder([fitted, again]).rungs] == [None, "other values"]


def test_lists_are_arrays_and_what_is_no_number_or_no_fingertip_is_named():
    made = vegrip.Recording("made", [0, 1], [0, 0], {"normal_force": [1, 2]}, vegrip.Fingertip(8e-3))
    assert made.columns["normal_force"].dtype == float
    with pytest.raises(RecordingError, match="made: normal_force are no numbers"):
        vegrip.Recording("made", [0, 1], [0, 0], {"normal_force": ["a", 2]})
    with pytest.raises(KindError, match=r"fingertip is 0\.008; give vegrip\.Fingertip"):
        vegrip.Recording("made", [0, 1], [0, 0], {"normal_force": [1, 2]}, 8e-3)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"radius": 8}, "which is 8 m; give a length above 0 and up to 1 m"),
        (
            {"noise": {"normal_force": "10 mN"}},
            "the noise of normal_force is '10 mN'; give its standard deviation",
        ),
        ({"noise": {"force": 0.01}}, "unknown sensor force"),
        ({"zeros": {"displacement": "contakt"}}, "must be one of none, first, baseline, contact"),
    ],
)
def test_a_length_a_noise_or_a_zero_that_cannot_be_is_refused(table, given, said):
    with pytest.raises(VegripError, match=said):
        vegrip.import_recording(table, columns=COLUMNS, units=UNITS, **given)


def test_a_call_names_the_arguments_that_it_takes(recording):
    with pytest.raises(
        KindError, match="fit: got an unexpected keyword argument 'most'; it takes recording, model"
    ):
        vegrip.fit(recording, most=3)
    with pytest.raises(KindError, match="most is '3'; it is a whole number"):
        vegrip.diagnose(recording, most="3")


def test_a_name_that_looks_like_html_is_text_in_a_card(recording, fitted):
    name = "<script>alert(1)</script>"
    named = dataclasses.replace(
        recording, name=name, fingertip=dataclasses.replace(recording.fingertip, name=name)
    )
    again = vegrip.fit(named)
    found = (named, again, again.model, vegrip.ladder([again]), vegrip.compare(named, again.model))
    for one in (
        *found,
        vegrip.diagnose(named),
        vegrip.SlipMargin(0, name, 0),
        vegrip.ContactEstimate(0, name, 0),
    ):
        assert "<script" not in one._repr_html_()
        assert "&lt;script" in one._repr_html_()
