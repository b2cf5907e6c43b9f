"""The numbers of the paper, as ``vegrip paper`` gives them, against the golden ones."""

import json
import math

import pytest

from vegrip.cli import main
from vegrip.contact.paper import tables
from vegrip.errors import DomainError

DIGITS = 6e-7
INF = math.inf

# t, k, and f/(mu N), m/(mu N a0) at d/a = 0, .25, .5, 1, 2
GOLDEN_FIG_10 = [
    (
        0.2,
        2.568902,
        [0, 0.277020, 0.532621, 0.875149, 0.972620],
        [0.650711, 0.613991, 0.512446, 0.251993, 0.115710],
    ),
    (
        1.0,
        3.695187,
        [0, 0.264609, 0.512692, 0.865746, 0.970803],
        [0.716520, 0.679190, 0.574279, 0.287037, 0.131094],
    ),
    (
        INF,
        3.856149,
        [0, 0.263528, 0.510896, 0.864843, 0.970631],
        [0.722585, 0.685209, 0.580041, 0.290381, 0.132552],
    ),
]

# t, h, a/a0, C_k, k, p_max/p0
GOLDEN_FIG_8 = [
    [0, 1, 1, 1.5, 2, 1.5],
    [0.05, 1.043075, 1.021311, 1.438055, 2.149693, 1.378668],
    [0.1, 1.079966, 1.039214, 1.388933, 2.295040, 1.286089],
    [0.2, 1.138617, 1.067060, 1.317388, 2.568902, 1.157008],
    [0.5, 1.236326, 1.111902, 1.213273, 3.209266, 0.981354],
    [1, 1.286485, 1.134233, 1.165968, 3.695187, 0.906320],
    [2, 1.299391, 1.139908, 1.154387, 3.848553, 0.888406],
    [INF, 1.3, 1.140175, 1.153846, 3.856149, 0.887574],
]


@pytest.fixture(scope="module")
def printed() -> dict:
    """What ``vegrip paper --json`` prints."""
    return tables.numbers()


def test_json_on_standard_output_reads_back_as_the_numbers(
    capsys: pytest.CaptureFixture[str], printed: dict
) -> None:
    assert main(["paper", "--json"]) == 0
    text = capsys.readouterr().out

    def refuse(constant: str) -> float:
        raise AssertionError(f"{constant} is not JSON")

    assert json.loads(text, parse_constant=refuse) == printed


def test_table_1_agrees_with_quadrature_of_equilibrium(printed: dict) -> None:
    assert set(printed["table1"]) == {*map(str, range(1, 11)), "50", "inf"}
    for k, C in printed["table1"].items():
        assert pytest.approx(tables.coefficient_by_quadrature(float(k)), abs=1e-10) == C


def test_table_2_agrees_with_quadrature_of_equilibrium(printed: dict) -> None:
    some = ["2.0", "2.2", "2.4", "2.5", "2.6", "2.8", "3.0", "3.2", "3.4", "3.5", "3.6", "3.8", "4.0"]
    assert list(printed["table2"]) == some
    for k, (C, ratio) in printed["table2"].items():
        check = tables.coefficient_by_quadrature(float(k))
        assert pytest.approx((check, math.sqrt(1.5 / check)), abs=1e-10) == (C, ratio)


def test_limit_surface_of_hertz_has_its_closed_form_inside_the_patch(printed: dict) -> None:
    for d, f, m in printed["limit_surface"]["2"]:
        if d <= 1:
            assert f == pytest.approx(3 * math.pi / 8 * (d - d**3 / 4), abs=1e-9)
            assert m == pytest.approx(3 * math.pi / 16 * (1 - d**2 + 3 * d**4 / 8), abs=1e-9)


def test_limit_surfaces_are_given_at_every_distance(printed: dict) -> None:
    for k in ("2", "3", "4"):
        assert [row[0] for row in printed["limit_surface"][k]] == [
            0,
            0.1,
            0.25,
            0.5,
            0.75,
            1,
            1.5,
            2,
            3,
            5,
            10,
        ]
    assert printed["limit_surface"]["3"][3] == pytest.approx([0.5, 0.5230228984, 0.4926471282], abs=6e-10)
    assert printed["limit_surface"]["4"][7] == pytest.approx([2, 0.9704899177, 0.1168120772], abs=6e-10)


def test_figure_4_is_the_relaxation_function(printed: dict) -> None:
    times = [0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0, INF]
    assert [t for t, *_ in printed["fig4"]] == [t for t, *_ in printed["fig8"]] == times
    for t, g in printed["fig4"]:
        assert g == pytest.approx(0.7 + 0.3 * math.exp(-3.1 * t), abs=1e-14)


def test_figure_8_has_the_golden_digits(printed: dict) -> None:
    rows = {row[0]: row for row in printed["fig8"]}
    for golden in GOLDEN_FIG_8:
        assert rows[golden[0]] == pytest.approx(golden, abs=DIGITS)


def test_figure_10_has_the_golden_digits(printed: dict) -> None:
    rows = {t: (k, points) for t, k, points in printed["fig10"]}
    assert list(rows) == [0.0, 0.2, 1.0, INF]
    for t, k, f, m in GOLDEN_FIG_10:
        assert rows[t][0] == pytest.approx(k, abs=DIGITS)
        assert [point[0] for point in rows[t][1]] == pytest.approx(f, abs=DIGITS)
        assert [point[1] for point in rows[t][1]] == pytest.approx(m, abs=DIGITS)


def test_fits_have_the_golden_digits(printed: dict) -> None:
    assert printed["coupling_fit"] == pytest.approx({"A": 0.519550, "B": 0.534980}, abs=DIGITS)
    assert printed["log_fit"] == pytest.approx({"A": 1.722474, "B": -1.790844}, abs=DIGITS)


def test_tables_fit_a_terminal_of_eighty_columns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["paper"]) == 0
    text = capsys.readouterr().out
    assert "…" not in text
    assert "1.240490015" in text
    assert max(map(len, text.splitlines())) <= 80


def test_a_fitted_exponent_is_asked_for_up_to_a_ten_thousandth_below_the_end_of_the_law() -> None:
    fit = tables.PowerFit(A=1.0, B=-1.0)
    assert fit.exponent(1.5 * (1.0 - 1.1e-4)) > 1e3
    with pytest.raises(DomainError):
        fit.exponent(1.5 * (1.0 - 0.9e-4))
