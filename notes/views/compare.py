"""How far apart two recordings of one scene are, a frame at a time, and what `lockstep verify` says of them."""

import json
import re
import subprocess

import numpy as np

ELEMENTS = {"points": "particle", "bodies": "body", "mesh": "node", "surface": "point", "liquid": "cell"}

# What each verdict asserts (notes/verification.md).
WORDS = {
    "bitwise": "from the same state, the openmp step leaves the same bits as the serial step of the same algorithm",
    "bounded": "every element is as near to the double run as the bound that is derived for it",
    "converged": "another algorithm, which reaches what the serial one reaches",
    "physical": "one step is within the bound derived for it, and a whole run leaves the serial run no faster than"
    " that leaves itself after a change of one ulp",
}


def distances(serial, openmp):
    """Yields for each frame the distance, m, of every element: of places, or of two level sets' values."""
    places = 1 if serial.kind in ("surface", "liquid") else 3
    for a, b in zip(serial.values, openmp.values):
        apart = a[:, :places].astype(np.float64) - b[:, :places]
        yield np.sqrt((apart**2).sum(axis=1))


def frames_of(serial, openmp):
    """For each frame: the rms and the largest distance, m, and the worst element with its place."""
    rows = []
    for frame, apart in enumerate(distances(serial, openmp)):
        worst = int(apart.argmax()) if len(apart) else 0
        rms = float(np.sqrt((apart**2).mean())) if len(apart) else 0.0
        rows.append({"rms": rms, "most": float(apart.max(initial=0)), "element": worst})
        rows[-1]["place"] = place_of(openmp, frame, worst)
    return rows


def place_of(run, frame, element):
    if run.kind in ("surface", "liquid"):
        nx, ny, _ = run.grid["points"]
        place = (element % nx, element // nx % ny, element // (nx * ny))
        return [float(first + run.grid["spacing"] * k) for first, k in zip(run.grid["first"], place)]
    return [float(x) for x in run.values[frame, element, :3]] if run.values.shape[1] else [0.0, 0.0, 0.0]


def same_bits(serial, openmp):
    """Whether every frame of both runs has the same bits: of places, orientations, level sets."""
    if serial.values.shape != openmp.values.shape:
        return False
    whole = zip(serial.values, openmp.values)
    return all(np.array_equal(a.view(np.uint32), b.view(np.uint32)) for a, b in whole)


def verdict(program, scene, form, kind, threads, path):
    """The row of verify on the step of that form, or None where verify does not take the scene."""
    kernel = "levelset/fast_sweeping" if kind == "surface" else "*/step"
    command = [program, "verify", "--kernel", kernel, "--form", form, "--scene", scene, "--json", path]
    done = subprocess.run([*command, "--threads", str(threads)], capture_output=True, text=True)
    if done.returncode not in (0, 1):
        return None
    return json.loads(path.read_text())["rows"][0]


def worst_of(row):
    """The element that a row names, and the frame of the comparison: one step after its start."""
    named = re.search(r"\b(particle|body|node|point|cell) (\d+)", row["worst_at"])
    courses = row.get("courses", [])
    return {"element": int(named[2]), "frame": courses[0]["from"] + 1 if courses else 1} if named else None


def in_words(row):
    claim = f"{row['kernel']} {row['form']} on {row['threads']} threads: {row['verdict']}: {WORDS[row['verdict']]}."
    if not row["passed"]:
        return f"FAILED: {claim} It does not hold: {row['worst_at']}"
    if row["bound"] > 0:
        claim += f" Nearest to its bound: error {row['error']:.3g} of {row['bound']:.3g}, {row['worst_at']}."
    return claim
