"""What an engineer should use, in five sentences that are written from the figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from motorcade.fusion.smoothing.representations import BEST_EULER
from motorcade.replays.comparison.plan import OWN
from motorcade.replays.comparison.report.matrix import CAUSAL, LABELS
from motorcade.replays.comparison.report.page import compared, percent
from motorcade.replays.comparison.report.results import Ratio, Results, listed, tied
from motorcade.replays.comparison.statistics import PRACTICAL_SHARE

__all__ = ["in_short", "shares"]

_AUTO = ("auto", OWN)
_ROBUST = "robust_map"
_WRONG = ("outliers", "outliers_and_flips")
_EULER = "euler"
_CLEARLY = 1.05


def in_short(results: Results) -> list[str]:
    """The sentences that the figures allow."""
    parts = (_offline, _plainly_wrong, _live, _representations, _euler)
    return [sentence for part in parts for sentence in part(results)]


def shares(results: Results) -> dict[str, str]:
    """Shares over all: of `auto`, of the best that is tuned, and of that on Euler angles."""
    ratios = results.ratio_to_raw("all", "score")
    best = _tuned(results)
    method = str(best["method"])
    told = {"method": method, "representation": str(best["representation"])}
    told["best"] = percent(best["ratio_to_raw"])
    for name, pair in (("auto", _AUTO), ("euler", (method, BEST_EULER))):
        told[name] = percent(ratios[pair].value) if pair in ratios else "–"
    return told


def _tuned(results: Results) -> Mapping[str, Any]:
    """What leaves least of all that is tuned."""
    return next(row for row in results.ranking() if row["method"] not in ("raw", "auto"))


def _offline(results: Results) -> Iterator[str]:
    rows = {(row["method"], row["representation"]): row for row in results.ranking()}
    auto, best = rows.get(_AUTO), _tuned(results)
    if auto is None:
        return
    later = max(auto, best, key=lambda row: row["rank"])
    end = ": tuning would gain that much"
    if later["ties_with_best"] and min(auto["rank"], best["rank"]) == 1:
        end = ", which is a tie"
    elif later is best:
        end = ": tuning gains nothing" + _but_where(results)
    yield (
        "Where all poses are there already, leave them to `auto`, the default: told nothing, it "
        f"leaves {percent(auto['ratio_to_raw'])} of the raw poses' residual error and jitter over "
        f"all motions and kinds of noise, and {_name(best)}, the best of all methods whose "
        "parameters are tuned on the ground truth of each motion and noise, "
        f"{percent(best['ratio_to_raw'])}{end}."
    )


def _but_where(results: Results) -> str:
    """Kinds of noise with which what is tuned leaves clearly less than `auto`."""
    named = []
    for name in results.degradations:
        scope = f"degradation:{name}"
        rows = [row for row in results.ranking(scope) if row["method"] not in ("raw", "auto")]
        auto = results.ratio_to_raw(scope, "score").get(_AUTO)
        if auto is not None and rows and auto.value > _CLEARLY * rows[0]["ratio_to_raw"]:
            named.append(LABELS[name])
    return f" over all, but does with {listed(named)}" if named else ""


def _plainly_wrong(results: Results) -> Iterator[str]:
    found = {}
    for name in _WRONG:
        ratios = results.ratio_to_raw(f"degradation:{name}", "score")
        robust = [one.value for pair, one in ratios.items() if pair[0] == _ROBUST]
        if _AUTO in ratios and robust:
            found[name] = (ratios[_AUTO].value, min(robust))
    if not found:
        return
    labels = [LABELS[name] for name in found]
    wins = [
        LABELS[name]
        for name, (auto, robust) in found.items()
        if robust < (1.0 - PRACTICAL_SHARE) * auto
    ]
    advice = "stay with `auto`"
    if wins:
        where = "" if len(wins) == len(found) else f" for {listed(wins)}"
        advice = f"take `{_ROBUST}`{where} if you know that noise, else `auto`"
    ours, theirs = (listed([percent(one[k]) for one in found.values()]) for k in (0, 1))
    yield (
        f"Where some poses are plainly wrong ({listed(labels)}), `auto` leaves {ours} and "
        f"`{_ROBUST}`, which is told the noise of the good poses, {theirs}: {advice}"
        f"{_among_plain(results)}."
    )


def _among_plain(results: Results) -> str:
    """Where the robust method stands with plain noise."""
    ranked = results.ranking(f"degradation:{results.degradations[0]}")
    methods = list(dict.fromkeys(row["method"] for row in ranked if row["method"] != "raw"))
    if _ROBUST not in methods:
        return ""
    place = methods.index(_ROBUST) + 1
    return f" (with plain noise `{_ROBUST}` is number {place} of {len(methods)} methods)"


def _live(results: Results) -> Iterator[str]:
    for row in results.ranking():
        if row["method"] in CAUSAL:
            yield (
                f"Where poses arrive one by one, {_name(row)} leaves least of the causal methods, "
                f"{percent(row['ratio_to_raw'])}, if you can tune it; `LiveSmoother` needs no "
                "tuning, and `make bench SUITE=live` holds it against tuned ones."
            )
            return


def _representations(results: Results) -> Iterator[str]:
    ratios = {
        name: ratio for name, ratio in over_all(results).items() if not name.startswith(_EULER)
    }
    if not ratios:
        return
    ties = [f"`{name}`" for name, ratio in ratios.items() if tied(ratio)]
    parts = [f"{listed(ties)} {'tie' if len(ties) > 1 else 'ties'} with motors"] if ties else []
    parts += [
        f"`{name}` leaves {compared(ratio)}" for name, ratio in ratios.items() if not tied(ratio)
    ]
    yield f"Choose the method first, the representation second: over all methods {listed(parts)}."


def _euler(results: Results) -> Iterator[str]:
    ratios = over_all(results)
    if BEST_EULER not in ratios:
        return
    best = ratios[BEST_EULER]
    told = "tie with motors" if tied(best) else f"leave {compared(best)}"
    others = [
        f"{how} {compared(ratios[name])}"
        for name, how in (
            ("euler_unwrapped", "with x-y′-z″ unwrapped an angle at a time"),
            ("euler", "with x-y′-z″ as they come, wrapped at ±180°,"),
        )
        if name in ratios
    ]
    yield (
        "Euler angles whose order stays farthest from its gimbal lock, each triple on the branch "
        f"nearest to the one before (`{BEST_EULER}`), {told} over all methods"
        f"{'; those ' + listed(others) if others else ''}."
    )


def over_all(results: Results) -> dict[str, Ratio]:
    """Times what motors leave, over all methods, by representation."""
    return {
        name: ratio
        for (method, name), ratio in results.ratio_to_motor("all", "score").items()
        if method == "all" and name in results.representations and name != "motor"
    }


def _name(row: Mapping[str, Any]) -> str:
    return f"`{row['method']}` on `{row['representation']}`"
