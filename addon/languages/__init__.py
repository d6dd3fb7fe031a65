# SPDX-License-Identifier: GPL-3.0-or-later
"""The languages of the user interface: tables of texts, and the translation of messages that have values in them."""
