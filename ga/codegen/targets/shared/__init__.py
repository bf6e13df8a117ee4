"""What several targets share: text, dialects made of templates, C and Python around statements."""
