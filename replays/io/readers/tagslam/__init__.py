"""TagSLAM's recordings: marker corners, tags, odometry, and its own result as reference."""
