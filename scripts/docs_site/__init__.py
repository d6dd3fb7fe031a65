"""The documentation's site: its configuration, the pages that are made from other files, and checks of all pages."""
