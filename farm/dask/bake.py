# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a mesh's live skin to a point cache on a Dask cluster: a task for each chunk of frames, and one that joins them.

usage: python3 bake.py FILE --object NAME --frames A..B --output DIR (--scheduler ADDRESS | --local K)
                       [--chunks N] [--blender PATH] [--retries R] [-- further arguments of `sinew bake`]

Needs the packages of requirements.txt, Blender with Sinew on every worker, and FILE and DIR at the same paths there. Dask
schedules: when a worker dies in mid-bake it gives that chunk to another, which is safe, since files appear whole or not at
all and a chunk has the same bytes wherever it is baked. Progress goes to standard error, the result of the last task as one
line of JSON to standard output. Exit codes: 0 done, 1 a task failed for good, 2 wrong arguments.
"""

import argparse
import json
import socket
import subprocess
import sys
import uuid

from distributed import Client, LocalCluster, as_completed

LINES_OF_A_FAILURE = 12


def run_blender(command: list[str], *_after) -> dict:
    """What a worker does: runs Blender with Sinew's command line, and returns its result and the worker's name.

    _after: results that must be there before. Raises RuntimeError with Blender's last words where it failed.
    """
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
    told = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode != 0 or not told:
        words = "\n".join((done.stdout + done.stderr).splitlines()[-LINES_OF_A_FAILURE:])
        raise RuntimeError(f"{command[0]} ended with {done.returncode} on {socket.gethostname()}:\n{words}")
    return json.loads(told[-1]) | {"host": socket.gethostname()}


def submit(client: Client, wanted: argparse.Namespace):
    """Submits all tasks: the futures of the chunks in their order, and that of the merge, which waits for them."""
    program = [wanted.blender, "-b", "-y", "--command", "sinew"]
    frames = [f"--frames={wanted.frames}"] if wanted.frames else []
    bake = [*program, "bake", wanted.file, "--object", wanted.object, *frames, "--output", wanted.output, *wanted.further]
    merge = [*program, "merge", wanted.output, "--object", wanted.object, "--json"]
    run = uuid.uuid4().hex[:8]  # a bake that is started again is another, whatever Dask remembers
    options = {"pure": False, "retries": wanted.retries}
    chunks = []
    for number in range(1, wanted.chunks + 1):
        command = [*bake, "--chunk", f"{number}/{wanted.chunks}", "--json"]
        chunks.append(client.submit(run_blender, command, key=f"chunk-{number}-{run}", **options))
    return chunks, client.submit(run_blender, merge, *chunks, key=f"merge-{run}", **options)


def follow(chunks: list, merge, say) -> dict:
    """Waits for all tasks, telling each chunk as it is done; returns the result of the merge. Raises the first failure."""
    for count, (future, told) in enumerate(as_completed(chunks, with_results=True), 1):
        number = chunks.index(future) + 1
        say(f"chunk {number} baked on {told['host']} in {told['seconds']} s ({count} of {len(chunks)})")
    return merge.result()


def arguments(given: list[str]) -> argparse.Namespace:
    about, _, more = __doc__.partition("\n\n")
    parser = argparse.ArgumentParser(description=about, epilog=more, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", metavar="FILE", help="the .blend")
    parser.add_argument("--object", metavar="NAME", required=True, help="the mesh, bound by Sinew")
    parser.add_argument(
        "--frames", metavar="A..B", help="first and last frame (default: the scene's; --frames=-5..9 if negative)"
    )
    parser.add_argument("--output", metavar="DIR", required=True, help="a folder that all workers share")
    where = parser.add_mutually_exclusive_group(required=True)
    where.add_argument("--scheduler", metavar="ADDRESS", help="of a running Dask cluster, such as tcp://farm:8786")
    where.add_argument("--local", metavar="K", type=_count, help="start K workers on this machine")
    parser.add_argument("--chunks", metavar="N", type=_count, default=8, help="in how many parts (default: 8)")
    parser.add_argument("--blender", metavar="PATH", default="blender", help="Blender's program on the workers")
    parser.add_argument("--retries", metavar="R", type=int, default=1, help="how often a chunk is tried again (default: 1)")
    at = given.index("--") if "--" in given else len(given)
    wanted = parser.parse_args(given[:at])
    wanted.further = given[at + 1 :]
    return wanted


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is no number from 1 on")
    return int(text)


def say(message: str):
    print(f"sinew: {message}", file=sys.stderr, flush=True)


def main() -> int:
    wanted = arguments(sys.argv[1:])
    cluster = None
    if wanted.local:
        cluster = LocalCluster(n_workers=wanted.local, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)
    try:
        with Client(cluster or wanted.scheduler) as client:
            chunks, merge = submit(client, wanted)
            say(f"{wanted.object} in {wanted.chunks} chunks on {len(client.scheduler_info()['workers'])} workers")
            try:
                told = follow(chunks, merge, say)
            except BaseException:
                client.cancel([*chunks, merge])
                raise
    except (RuntimeError, OSError) as error:  # a task's own failure, or no scheduler there
        say(f"error: {error}")
        return 1
    finally:
        if cluster:
            cluster.close()
    print(json.dumps(told), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
