"""What joints are (hips, thighs, hands …), what is up and ahead: told by tree, bones and motion."""
