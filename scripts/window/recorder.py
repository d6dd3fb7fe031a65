"""Records what a person sees: pictures of the screen with the mouse, as an animated GIF made by ImageMagick."""

import subprocess
from pathlib import Path

from window import driver

SIZE = "880x"
COLOURS = 96
MOVE_FRAMES, MOVE_CS = 5, 6  # frames between two positions of the mouse, and their hundredths of a second
HOLD_CS, CLICK_CS, LAST_CS = 90, 25, 250
# the mouse as a polygon of pixels of the screen, because a picture of the screen does not have it
_ARROW = ((0, 0), (0, 22), (5, 17), (9, 25), (13, 23), (9, 16), (16, 16))


class Recorder:
    """Keeps frames in a folder. The mouse moves between them, over the last picture."""

    def __init__(self, folder: Path, crop: str):
        """crop: the part of the screen that is kept, as ImageMagick writes it."""
        folder.mkdir(parents=True, exist_ok=True)
        self._folder, self._crop = folder, crop
        self._frames: list[tuple[Path, int]] = []
        self._mouse = (700, 600)
        self._screen = folder / "screen.png"

    def look(self, hold_cs: int = HOLD_CS) -> None:
        """Takes a picture of the screen as the next frame."""
        subprocess.run(["import", "-window", "root", str(self._screen)], check=True)
        self._keep(hold_cs)

    def move(self, position: tuple[int, int]) -> None:
        """Shows the mouse on its way to a position, and moves it there."""
        x, y = self._mouse
        for step in range(1, MOVE_FRAMES + 1):
            part = step / MOVE_FRAMES
            part = part * part * (3.0 - 2.0 * part)
            self._mouse = round(x + part * (position[0] - x)), round(y + part * (position[1] - y))
            self._keep(MOVE_CS)
        driver.move(position)

    def follow(self, position: tuple[int, int]) -> None:
        """The mouse is at a position, where a drag took it."""
        self._mouse = position

    def click(self) -> None:
        """Clicks at the mouse, with a ring around it."""
        self._keep(CLICK_CS, is_click=True)
        driver.click(self._mouse)

    def save(self, path: Path) -> None:
        """Writes the GIF. Colors are few and only what changes is stored, so that a page loads quickly."""
        frames = [word for file, delay in self._frames for word in ("-delay", str(delay), str(file))]
        shown = ["+dither", "-colors", str(COLOURS), "-layers", "OptimizeFrame", "-layers", "OptimizeTransparency"]
        subprocess.run(["convert", *frames, "-loop", "0", *shown, str(path)], check=True)
        print(f"{path.name}: {len(self._frames)} frames, {path.stat().st_size / 1e6:.2f} MB", flush=True)

    def _keep(self, delay_cs: int, is_click: bool = False) -> None:
        file = self._folder / f"{len(self._frames):03}.png"
        x, y = self._mouse
        arrow = " ".join(f"{x + dx},{y + dy}" for dx, dy in _ARROW)
        ring = ["-fill", "none", "-stroke", "#ffb030", "-strokewidth", "4", "-draw", f"circle {x},{y} {x + 20},{y}"]
        mouse = ["-fill", "white", "-stroke", "black", "-strokewidth", "1", "-draw", f"polygon {arrow}"]
        size = ["-crop", self._crop, "+repage", "-resize", SIZE]
        command = ["convert", str(self._screen), *(ring if is_click else []), *mouse, *size, str(file)]
        subprocess.run(command, check=True)
        self._frames.append((file, delay_cs))
