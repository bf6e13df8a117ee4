"""What commands do with characters: blends, authored scenes."""
