"""What browsers are given: the frame of pages, films that can be sought, the viewer's modules.

It knows neither recordings nor runs: what a page shows is handed to it.
"""
