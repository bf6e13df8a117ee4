"""From marks to text: `view` projects and orders them, `svg` and `page` write them."""
