# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a mesh's live skin to a point cache on a Dask cluster: one task for each chunk of frames, and one that joins them.

usage: python3 bake.py FILE --object=NAME --frames=A..B --output=DIR (--scheduler=ADDRESS | --local=K)
                       [--tls-ca-file=FILE --tls-cert=FILE --tls-key=FILE]
                       [--chunks=N] [--blender=PATH] [--retries=R] [-- further arguments of `sinew bake`]

Whoever can reach a Dask scheduler runs programs on its workers: a task is a pickle. Start scheduler and workers with
certificates (dask scheduler --tls-ca-file=ca.pem --tls-cert=cert.pem --tls-key=key.pem), and give bake.py the same options.

Requires the packages of requirements.txt, and on every worker Blender with Sinew, and FILE and DIR at the same paths. If a
worker dies during a bake, Dask gives its chunk to another worker. That is safe, because files are complete or do not exist,
and a chunk has the same bytes wherever it is baked. Progress goes to standard error. The result of the last task goes to
standard output as one line of JSON. Exit codes: 0 done, 1 a task failed after all retries, 2 wrong arguments.
"""

import argparse
import json
import socket
import subprocess
import sys
import uuid

from distributed import Client, LocalCluster, as_completed
from distributed.security import Security

FAILURE_LINES = 12  # how much of Blender's output the report of a failure quotes


def run_blender(command: list[str], *_after) -> dict:
    """Runs one command of Sinew in Blender, on a worker. Returns its result and the worker's host name.

    _after: results of tasks that must be done before. Raises RuntimeError with the last lines of output if Blender fails.
    """
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace")
    results = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode != 0 or not results:
        output = "\n".join((done.stdout + done.stderr).splitlines()[-FAILURE_LINES:])
        raise RuntimeError(f"{command[0]} ended with {done.returncode} on {socket.gethostname()}:\n{output}")
    return json.loads(results[-1]) | {"host": socket.gethostname()}


def submit(client: Client, options: argparse.Namespace):
    """Submits all tasks. Returns the futures of the chunks in order, and the future of the merge, which waits for them."""
    program = [options.blender, "-b", "-y", "--command", "sinew"]
    frames = [f"--frames={options.frames}"] if options.frames else []
    # with =, because a name may begin with -
    mesh, output = f"--object={options.object}", f"--output={options.output}"
    bake = [*program, "bake", options.file, mesh, *frames, output, *options.further]
    merge = [*program, "merge", options.output, mesh, "--json"]
    run = uuid.uuid4().hex[:8]  # unique keys, so that Dask does not return the results of an earlier bake
    settings = {"pure": False, "retries": options.retries}
    chunks = []
    for number in range(1, options.chunks + 1):
        command = [*bake, f"--chunk={number}/{options.chunks}", "--json"]
        chunks.append(client.submit(run_blender, command, key=f"chunk-{number}-{run}", **settings))
    return chunks, client.submit(run_blender, merge, *chunks, key=f"merge-{run}", **settings)


def follow(chunks: list, merge, say) -> dict:
    """Waits for all tasks and reports each chunk. Returns the result of the merge. Raises the first failure."""
    for count, (future, result) in enumerate(as_completed(chunks, with_results=True), 1):
        number = chunks.index(future) + 1
        say(f"chunk {number} baked on {result['host']} in {result['seconds']} s ({count} of {len(chunks)})")
    return merge.result()


def parse(arguments: list[str]) -> argparse.Namespace:
    """Reads the command line. Arguments after `--` are for `sinew bake`."""
    summary, _, details = __doc__.partition("\n\n")
    formatter = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=summary, epilog=details, formatter_class=formatter)
    parser.add_argument("file", metavar="FILE", help="the .blend file")
    parser.add_argument("--object", metavar="NAME", required=True, help="the mesh; it must be bound")
    parser.add_argument(
        "--frames", metavar="A..B", help="first and last frame (default: the scene's; --frames=-5..9 if negative)"
    )
    parser.add_argument("--output", metavar="DIR", required=True, help="a folder that all workers share")
    cluster = parser.add_mutually_exclusive_group(required=True)
    cluster.add_argument(
        "--scheduler", metavar="ADDRESS", help="the address of a running Dask cluster, such as tls://farm:8786"
    )
    cluster.add_argument("--local", metavar="K", type=_count, help="start K workers on this machine")
    parser.add_argument("--tls-ca-file", metavar="FILE", help="the authority's certificate (PEM), for a tls:// scheduler")
    parser.add_argument("--tls-cert", metavar="FILE", help="the certificate (PEM) of this machine")
    parser.add_argument("--tls-key", metavar="FILE", help="the private key (PEM) of that certificate")
    parser.add_argument("--chunks", metavar="N", type=_count, default=8, help="the number of chunks (default: 8)")
    parser.add_argument("--blender", metavar="PATH", default="blender", help="Blender's program on the workers")
    parser.add_argument("--retries", metavar="R", type=int, default=1, help="retries of a failed chunk (default: 1)")
    end = arguments.index("--") if "--" in arguments else len(arguments)
    options = parser.parse_args(arguments[:end])
    options.further = arguments[end + 1 :]
    given = [value is not None for value in (options.tls_ca_file, options.tls_cert, options.tls_key)]
    if any(given) != all(given) or (options.scheduler or "").startswith("tls://") != all(given):
        parser.error("a tls:// scheduler requires --tls-ca-file, --tls-cert and --tls-key; another takes none of them")
    return options


def security_of(options: argparse.Namespace) -> Security | None:
    """The certificates with which the cluster is reached, or None."""
    if options.tls_ca_file is None:
        return None
    return Security(
        tls_ca_file=options.tls_ca_file,
        tls_client_cert=options.tls_cert,
        tls_client_key=options.tls_key,
        require_encryption=True,
    )


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"'{text}' is not a number of 1 or more")
    return int(text)


def say(message: str):
    print(f"sinew: {message}", file=sys.stderr, flush=True)


def main() -> int:
    options = parse(sys.argv[1:])
    security = security_of(options)
    if options.scheduler and security is None:
        say("warning: a scheduler without tls:// takes tasks from whoever can reach it")
    cluster = None
    if options.local:
        cluster = LocalCluster(n_workers=options.local, threads_per_worker=1, host="127.0.0.1", dashboard_address=None)
    try:
        with Client(cluster or options.scheduler, security=security) as client:
            chunks, merge = submit(client, options)
            say(f"{options.object} in {options.chunks} chunks on {len(client.scheduler_info()['workers'])} workers")
            try:
                result = follow(chunks, merge, say)
            except BaseException:
                client.cancel([*chunks, merge])
                raise
    except (RuntimeError, OSError) as error:  # a task failed, or the scheduler can't be reached
        say(f"error: {error}")
        return 1
    finally:
        if cluster:
            cluster.close()
    print(json.dumps(result), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
