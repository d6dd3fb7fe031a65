"""Sinew in a Blender with a window: pictures of its states, and clicks and drags as a person makes them."""
