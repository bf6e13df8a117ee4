"""What a page shows of a run: one JSON document, which `web/modules/look.js` reads."""
