"""What smoothing invents: detours and turns, overshoot, and answers that depend on the frame."""
