"""The page on smoothers, and the README's line, are what the kept figures give."""

from pathlib import Path

import pytest

from docs.making import guide
from docs.making.in_short import in_short
from motorcade.replays.comparison.plan import COMPARED, standard
from motorcade.replays.comparison.report.results import Results
from motorcade.replays.comparison.run import run_comparison

TOP = Path(__file__).resolve().parents[3]

if not (TOP / "README.md").exists():
    pytest.skip("no pages here: an installed wheel is tested", allow_module_level=True)


def test_page_and_readme_are_written_from_the_kept_figures() -> None:
    kept = guide.kept()
    assert (TOP / "docs" / "which_smoother.md").read_text(encoding="utf-8") == guide.page(kept)
    readme = (TOP / "README.md").read_text(encoding="utf-8")
    assert guide.with_line(readme, guide.readme_line(kept)) == readme
    assert set(kept["representations"]) == set(COMPARED)
    assert len(kept["in_short"]) == 5


@pytest.mark.parametrize(
    ("auto", "robust", "ties", "said"),
    [
        (0.10, 0.30, False, "30.0 %: tuning gains nothing."),
        (0.30, 0.10, False, "10.0 %: tuning would gain that much."),
        (0.10, 0.10, True, "10.0 %, which is a tie."),
    ],
)
def test_the_first_sentence_says_who_wins(
    auto: float, robust: float, ties: bool, said: str
) -> None:
    rows = [
        {"method": "auto", "representation": "own", "ratio_to_raw": auto},
        {"method": "robust_map", "representation": "motor", "ratio_to_raw": robust},
    ]
    rows.sort(key=lambda row: row["ratio_to_raw"])
    for rank, row in enumerate(rows, 1):
        row |= {"rank": rank, "ties_with_best": ties or rank == 1}
        row |= {"ratio_low": None, "ratio_high": None}
    ranking = {"scope": "all", "metric": "score", "rows": rows, "unranked": []}
    plan = {
        "motions": ["screw"],
        "degradations": ["gaussian"],
        "methods": ["auto", "robust_map"],
        "representations": ["motor"],
    }
    told = {"plan": plan, "rankings": [ranking], "ratios_to_motor": []}
    (first,) = in_short(Results(told, {}))
    assert first.endswith(said)


@pytest.mark.slow
def test_a_part_of_the_comparison_gives_the_kept_figures_again(tmp_path: Path) -> None:
    kept = guide.kept()
    means = kept["means"]
    plan = standard(
        len(kept["plan"]["test_seeds"]),
        methods=kept["plan"]["methods"],
        representations=tuple(kept["representations"]),
        motions=[means["motion"]],
        degradations=[means["degradation"]],
    )
    assert list(plan.test_seeds) == kept["plan"]["test_seeds"]
    run_comparison(plan, tmp_path)
    found = Results.read(tmp_path).figures
    assert len(means["rows"]) == len(plan.pairs())
    for method, representation, *values in means["rows"]:
        for metric, value in zip(means["metrics"], values, strict=True):
            place = (means["motion"], means["degradation"], method, representation, metric)
            assert found[place].mean == pytest.approx(value, rel=1e-3), place
