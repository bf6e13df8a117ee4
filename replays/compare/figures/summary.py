"""The findings in a screenful of text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

_SHOWN = 12


def as_text(results: Mapping[str, Any]) -> str:
    """The best of all by score, what each representation costs beside motors, and the ties.

    Args:
        results: what ``results.json`` holds.
    """
    return "\n".join([*_ranking(results), "", *_representations(results), "", *_ties(results)])


def _ranking(results: Mapping[str, Any]) -> list[str]:
    ranked = next((one for one in results["rankings"] if one["metric"] == "score"), None)
    if ranked is None:
        return ["nothing has a result in every cell, so nothing is ranked"]
    lines = [f"{'rank':<10}{'method':<28}{'representation':<18}residual error and jitter, of raw"]
    for row in ranked["rows"][:_SHOWN]:
        bounds = f"{row['rank_low']}-{row['rank_high']}"
        tie = "  ties with the first" if row["ties_with_best"] and row["rank"] > 1 else ""
        lines.append(
            f"{row['rank']:<3}{bounds:<7}{row['method']:<28}{row['representation']:<18}"
            f"{_interval(row, 'ratio_to_raw')}{tie}"
        )
    if ranked["unranked"]:
        lines.append(f"not ranked, as not run or failed in some cell: {len(ranked['unranked'])}")
    return lines


def _representations(results: Mapping[str, Any]) -> list[str]:
    metrics = ("ape_rmse_m", "rotation_rmse_deg", "linear_jitter_m_s2", "angular_jitter_rad_s2")
    rows = [
        one
        for one in results["ratios_to_motor"]
        if one["method"] == "all" and one["scope"] == "all" and one["representation"] != "motor"
    ]
    lines = [f"{'times what motors leave, all methods':<38}" + "".join(f"{m:<24}" for m in metrics)]
    for name in dict.fromkeys(row["representation"] for row in rows):
        of = {row["metric"]: row for row in rows if row["representation"] == name}
        lines.append(
            f"{name:<38}" + "".join(f"{_interval(of[m], 'ratio_to_motor'):<24}" for m in metrics)
        )
    return lines


def _ties(results: Mapping[str, Any]) -> list[str]:
    ties = results["exact_ties"]
    lines = []
    for theory in dict.fromkeys(one["theory"] for one in ties):
        of = [one for one in ties if one["theory"] == theory]
        largest = max(
            one[key] or 0.0
            for one in of
            for key in ("largest_difference_m", "largest_difference_rad")
        )
        holds = "holds" if all(one["holds"] for one in of) else "DOES NOT HOLD"
        lines.append(f"{theory}: {holds}, to {largest:.1g}")
    return lines


def _interval(row: Mapping[str, Any], key: str) -> str:
    if row["ratio_low"] is None:
        return _ratio(row[key])
    return f"{_ratio(row[key])} ({_ratio(row['ratio_low'])}-{_ratio(row['ratio_high'])})"


def _ratio(value: float) -> str:
    """Narrow enough for its column."""
    return f"{value:.3f}" if value < 100.0 else f"{value:.1f}" if value < 1e4 else f"{value:.2g}"
