"""Scene files bound to a run: anchors found by tracking, characters and props read and played."""
