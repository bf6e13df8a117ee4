"""`motorcade evaluate` prints what matters, everything where asked, and keeps its JSON whole."""

import json
from pathlib import Path

import numpy as np
import pytest

from motorcade.fusion.metrics import evaluate
from motorcade.fusion.motions import MOTIONS
from motorcade.fusion.motions.degradations import Gaussian
from motorcade.replays.cli import main
from motorcade.replays.files.trajectories import read_trajectory, write_trajectory


def test_the_figures_that_matter_are_printed_and_all_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = MOTIONS["screw"].sampled(30.0, 3.0)
    noisy = Gaussian(0.005, 0.01).apply(truth, np.random.default_rng(2))
    write_trajectory(truth, tmp_path / "truth.tum")
    write_trajectory(noisy, tmp_path / "noisy.tum")
    words = ["evaluate", str(tmp_path / "noisy.tum"), str(tmp_path / "truth.tum")]
    kept = tmp_path / "errors.json"
    assert main([*words, "--json", str(kept)]) == 0
    short = dict(line.split() for line in capsys.readouterr().out.splitlines())
    assert main([*words, "--all"]) == 0
    full = dict(line.split() for line in capsys.readouterr().out.splitlines())
    found = evaluate(*(read_trajectory(tmp_path / f"{name}.tum") for name in ("noisy", "truth")))
    assert json.loads(kept.read_text()) == found.as_dict()
    assert list(full) == list(found.as_dict())
    assert short.items() <= full.items()
    assert "None" not in short.values()
    assert 10 <= len(short) <= 13
    assert {"align", "pairs", "ape_rmse_m", "rotation_rmse_deg", "rpe_trans_rmse_m"} <= set(short)
    assert {"linear_jitter_m_s2", "angular_jitter_rad_s2", "lag_ms"} <= set(short)
    assert float(short["ape_rmse_m"]) == pytest.approx(found.as_dict()["ape_rmse_m"], rel=1e-8)
