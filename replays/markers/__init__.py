"""Jobs on pictures of markers and boards: finding, drawing, calibrating, and mapping loose ones."""
